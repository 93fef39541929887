"""The fuzzers name their sources by patterns (tests/fuzz/CMakeLists.txt): what one of them includes is among them. A build of all of
them takes minutes, so no other test would see that one is missing."""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SRC = ROOT / "src"
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)\.hpp"', re.MULTILINE)


def sources():
    patterns = re.findall(r"\$\{root\}/(src/\S+?\.cpp)", (ROOT / "tests/fuzz/CMakeLists.txt").read_text(encoding="utf-8"))
    return {path for pattern in patterns for path in ROOT.glob(pattern)}


def missing(given):
    """{source that is included and not given: the file that includes it}, through headers too"""
    found, seen, waiting = {}, set(), sorted(given) + [ROOT / "tests/fuzz/readers.cpp"]
    while waiting:
        path = waiting.pop()
        if path in seen:
            continue
        seen.add(path)
        for name in INCLUDE.findall(path.read_text(encoding="utf-8")):
            header, source = SRC / f"{name}.hpp", SRC / f"{name}.cpp"
            if header.exists():
                waiting.append(header)
            if source.exists() and source not in given:
                found[source] = path
    return found


class FuzzSources(unittest.TestCase):
    def test_nothing_is_missing(self):
        self.assertEqual({}, missing(sources()))

    def test_what_is_missing_is_found(self):
        given = sources()
        json_part = SRC / "report/json_part.cpp"
        self.assertIn(json_part, given)
        self.assertEqual([json_part], list(missing(given - {json_part})))


if __name__ == "__main__":
    unittest.main()
