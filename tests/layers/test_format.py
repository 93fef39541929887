"""What was formatted stays formatted: .clang-format (Debian 12's clang-format 14). A folder joins the list when it is formatted whole."""

import subprocess
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FORMATTED = ("src/diagnosis/alignment/*.?pp", "src/diagnosis/result/decisions.hpp")


class Format(unittest.TestCase):
    def test_formatted_files_are_as_clang_format_writes_them(self):
        files = sorted(path for pattern in FORMATTED for path in ROOT.glob(pattern))
        self.assertTrue(files)
        result = subprocess.run(["clang-format", "--dry-run", "--Werror", *files], cwd=ROOT, stderr=subprocess.PIPE, text=True)
        self.assertEqual(result.returncode, 0, "\n" + result.stderr)


if __name__ == "__main__":
    unittest.main()
