"""Every section that code or a document cites exists in docs/."""

import re
import subprocess
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CITED = re.compile(r"\b([A-Z]+)\.md(?:(?:,|'s)? (?:§|section )(\d+[a-z]?(?:\.\d+)?))?((?:, ?§\d+[a-z]?(?:\.\d+)?)*)")
HEADING = re.compile(r"^(?:#+ |\*\*)(\d+[a-z]?(?:\.\d+)?)\b", re.MULTILINE)
TEXT = (".cpp", ".hpp", ".py", ".sh", ".md", ".toml", ".txt", ".cmake")


def sections(document):
    return set(HEADING.findall(document.read_text(encoding="utf-8")))


class Citations(unittest.TestCase):
    def test_every_cited_section_exists(self):
        files = subprocess.run(["git", "ls-files"], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()
        documents = {path.stem: path for path in [*(ROOT / "docs").glob("*.md"), ROOT / "README.md", ROOT / "CHANGELOG.md"]}
        known = {name: sections(path) for name, path in documents.items()}
        problems, found = [], 0
        for name in (f for f in files if f.endswith(TEXT)):
            text = (ROOT / name).read_text(encoding="utf-8")
            for match in CITED.finditer(text):
                line = text.count("\n", 0, match.start()) + 1
                document = match[1]
                beside = {path.stem for path in (ROOT / name).parent.glob("*.md")}
                if document not in known:
                    if document not in beside:
                        problems.append(f"{name}:{line}: docs/{document}.md does not exist")
                    continue
                for section in filter(None, [match[2], *re.findall(r"§([\da-z.]+)", match[3])]):
                    found += 1
                    if section not in known[document]:
                        problems.append(f"{name}:{line}: {document}.md has no section {section}")
        self.assertGreater(found, 20)
        self.assertFalse(problems, "\n" + "\n".join(problems))

    def test_every_file_on_the_map_exists(self):
        text = (ROOT / "docs/ARCHITECTURE.md").read_text(encoding="utf-8")
        named = re.findall(r"`([\w./]+\.(?:[ch]pp|py|sh|cmake))`", text)
        self.assertGreater(len(named), 10)
        folders = (ROOT, ROOT / "src", ROOT / "src/diagnosis")
        self.assertFalse([name for name in named if not any((folder / name).exists() for folder in folders)])
        # the newcomer's walk through the diagnosis
        walk = re.search(r"From the command to a name in eight files: (.*?)\. Below", text, re.DOTALL)
        self.assertEqual(len(re.findall(r"`[\w./]+\.cpp`", walk[1])), 8)

    def test_the_first_pages_stay_short(self):
        self.assertLess(len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()), 120)
        # two pages
        self.assertLess(len((ROOT / "docs/ARCHITECTURE.md").read_text(encoding="utf-8").split()), 1250)

    def test_every_decision_is_listed_once(self):
        folder = ROOT / "docs/decisions"
        listed = re.findall(r"\]\((\d\d-[a-z0-9-]+\.md)\)", (folder / "README.md").read_text(encoding="utf-8"))
        self.assertEqual(sorted(listed), sorted(path.name for path in folder.glob("[0-9]*.md")))


if __name__ == "__main__":
    unittest.main()
