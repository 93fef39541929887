"""A C++ test keeps its names to itself, in a namespace of its file's name: files of a folder are compiled as one (cmake/Together.cmake)."""

import re
import unittest
from pathlib import Path

TESTS = Path(__file__).resolve().parents[1]


class OwnNames(unittest.TestCase):
    def test_every_test_has_a_namespace_of_its_name(self):
        files = sorted(path for path in TESTS.rglob("*_test.cpp") if "reality" not in path.parts and "fuzz" not in path.parts)
        self.assertGreater(len(files), 150)
        for path in files:
            text = path.read_text(encoding="utf-8")
            with self.subTest(path.relative_to(TESTS)):
                self.assertIn(f"\nnamespace {path.stem} {{\n", text)
                self.assertIsNone(re.search(r"^namespace \{$", text, re.MULTILINE), "an anonymous namespace is one for all of them")


if __name__ == "__main__":
    unittest.main()
