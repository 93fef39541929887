"""Every C++ file is as .clang-format says (clang-format 14, from scripts/requirements.txt)."""

import subprocess
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("apps", "examples", "include", "src", "tests")


class Format(unittest.TestCase):
    def test_every_file_is_as_clang_format_writes_it(self):
        files = sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.?pp"))
        self.assertGreater(len(files), 500)
        result = subprocess.run([ROOT / ".venv" / "bin" / "clang-format", "--dry-run", "--Werror", *files], cwd=ROOT, stderr=subprocess.PIPE, text=True)
        self.assertEqual(result.returncode, 0, "\n" + result.stderr[:4000])


if __name__ == "__main__":
    unittest.main()
