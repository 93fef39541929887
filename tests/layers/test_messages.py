"""Messages read `problem (why); suggestion`: none runs from its reason into its suggestion without a mark."""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TEXT = r'"(?:[^"\\\n]|\\.)*"'
TEXTS = {".cpp": re.compile(rf"{TEXT}(?:\s*{TEXT})*"), ".py": re.compile(rf"f?{TEXT}(?:\s*f?{TEXT})*|f?'[^'\n]*'")}
SEAM = re.compile(r'"\s*f?"')
# a suggestion begins with what to do
DO = ("add|check|did you mean|fetch|fly|for example|give|go on with|keep|leave|log|make|move|name|paste|remove|rename|repair|run|see|sweep|take|train|trim|use|"
      "weld|write")
RUNS_ON = re.compile(rf'(?:\)|\\") (?:{DO})\b(?!=)')


def run_on(text: str, ending: str) -> list:
    """Texts of a source file in which a suggestion follows a closing bracket or quotation mark and nothing else."""
    return [match[0] for match in TEXTS[ending].finditer(text) if RUNS_ON.search(SEAM.sub("", match[0]))]


class Messages(unittest.TestCase):
    def test_suggestions_stand_behind_a_semicolon(self):
        files = sorted(path for folder in ("apps", "include", "src", "scripts") for path in (ROOT / folder).rglob("*") if path.suffix in (".cpp", ".hpp", ".py"))
        self.assertGreater(len(files), 300)
        found = {str(path.relative_to(ROOT)): said for path in files
                 if (said := run_on(path.read_text(encoding="utf-8"), ".py" if path.suffix == ".py" else ".cpp"))}
        self.assertEqual(found, {})

    def test_texts_that_run_on_are_found(self):
        self.assertEqual(len(run_on('fail("it is (so) "\n     "use another");', ".cpp")), 1)
        self.assertEqual(len(run_on('fail("\\"x\\" is \\"y\\" did you mean \\"z\\"?");', ".cpp")), 1)
        self.assertEqual(len(run_on("raise Failure(f'{path}: is not (\"y\") give another')", ".py")), 1)
        self.assertEqual(run_on('fail("it is (so); use another");', ".cpp"), [])


if __name__ == "__main__":
    unittest.main()
