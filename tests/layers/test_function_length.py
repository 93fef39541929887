"""No function of src/ and apps/ is longer than 60 lines without a reason. The files are as clang-format writes them, so a function ends where a
closing brace stands at the indentation of its first line."""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LIMIT = 60
NO_FUNCTION = re.compile(r"(?:namespace|struct|class|enum|union|extern|if|for|while|do|else|switch|case|try|const auto|auto|return)\b|\}|[^\w~]")

# name: why it is one piece
REASONS = {
    "src/diagnosis/result/to_json.cpp:to_json": "one key after another, in the order of FORMATS.md",
    "src/diagnosis/recording/vehicle_check.cpp:check_rotors": "one hypothesis after another; each is asked only where those before say nothing",
}


def functions(text):
    """(name, first line, lines) of every function with a body of its own lines"""
    lines = text.split("\n")
    for end, line in enumerate(lines):
        if not re.fullmatch(r" {0,2}\}", line):
            continue
        indent = line[:-1]
        start = end - 1
        while start >= 0 and (not lines[start].strip() or lines[start].startswith(indent + " ") or lines[start].startswith("#")):
            start -= 1
        # the signature may go over several lines
        first = start
        head = lines[start].strip()
        if NO_FUNCTION.match(head):
            continue
        name = re.search(r"([\w~:]+)\(", head)
        yield (name[1] if name else head), first + 1, end - first + 1


class FunctionLength(unittest.TestCase):
    def test_no_function_is_longer_than_sixty_lines_without_a_reason(self):
        found = {}
        for folder in ("src", "apps"):
            for path in sorted((ROOT / folder).rglob("*.[ch]pp")):
                for name, line, length in functions(path.read_text(encoding="utf-8")):
                    if length > LIMIT:
                        found[f"{path.relative_to(ROOT)}:{name}"] = length
        self.assertFalse({n: length for n, length in found.items() if n not in REASONS}, "longer than 60 lines, and no reason is given")
        self.assertFalse([n for n in REASONS if n not in found], "no longer so long: take the reason away")


if __name__ == "__main__":
    unittest.main()
