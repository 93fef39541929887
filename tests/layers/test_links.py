"""Links between the pages of this repository lead somewhere."""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LINK = re.compile(r"\]\(([^)\s#]+)[^)]*\)")


class Links(unittest.TestCase):
    def test_lead_to_files_that_are_there(self):
        pages = [page for folder in ("docs", "examples") for page in (ROOT / folder).rglob("*.md")] + list(ROOT.glob("*.md"))
        self.assertGreater(len(pages), 20)
        for page in pages:
            text = re.sub(r"```.*?```|`[^`\n]*`", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
            for link in LINK.findall(text):
                if not re.match(r"[a-z]+:", link):
                    with self.subTest(page=str(page.relative_to(ROOT)), link=link):
                        self.assertTrue((page.parent / link).exists())


if __name__ == "__main__":
    unittest.main()
