"""The diagnosis asks for the traits of an effect and never for its name: adding an effect is one file and one row."""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# a comment, a raw string (its text is group 2), a string (its text is group 3) or a character
TOKEN = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\((.*?)\)\1"|"((?:[^"\\\n]|\\.)*)"|\'(?:[^\'\\\n]|\\.)\'', re.DOTALL)


def names_of_effects():
    return re.findall(r'\.name = "(\w+)"', (ROOT / "src/effects/registry.cpp").read_text(encoding="utf-8"))


def strings(text):
    """(line, text) of every string of a C++ file; strings that follow each other are one."""
    found, end = [], -1
    for match in TOKEN.finditer(text):
        value = match[2] if match[2] is not None else match[3]
        if value is None:
            continue
        if found and not text[end:match.start()].strip():
            found[-1] = (found[-1][0], found[-1][1] + value)
        else:
            found.append((text.count("\n", 0, match.start()) + 1, value))
        end = match.end()
    return found


def asked(text, names):
    """Lines that ask for an effect by its name: in a string of its own (or as the first part of name#2), as the type of a table, by the
    beginning or the end of a name of several words, and in the middle of a sentence where the name is no English word."""
    several = [name for name in names if "_" in name]
    whole = re.compile(rf'^({"|".join(names)})(#.*)?$|type = \\?"({"|".join(names)})\b|\b({"|".join(several)})\b')
    parts = {part for name in several for at in range(1, len(name)) for part in (name[:at], name[at:]) if "_" in part and len(part) > 3}
    return [(line, value) for line, value in strings(text) if whole.search(value) or value in parts]


class EffectNames(unittest.TestCase):
    def test_no_effect_is_asked_for_by_name(self):
        names = names_of_effects()
        self.assertGreater(len(names), 30)
        found, read = [], 0
        for folder in ("src/diagnosis", "src/simulation"):
            for path in sorted((ROOT / folder).rglob("*.[ch]pp")):
                text = path.read_text(encoding="utf-8")
                read += len(strings(text))
                found += [f"{path.relative_to(ROOT)}:{line}: {value}" for line, value in asked(text, names)]
        self.assertGreater(read, 1000)
        self.assertFalse(found, "a trait of the effect's row (include/gustlab/effect.hpp) should say this:\n" + "\n".join(found))

    def test_every_way_to_ask_is_found(self):
        names = names_of_effects()
        for code in ('row.name == "mass"', 'find("gust#2")', 'name.starts_with("rotor_")', 'name.ends_with("_delay")', 'R"(rotor_drag)"',
                     'R"x(mass)x"', '"type = \\"inertia\\""', '"a log that shows rotor_drag"', '"https://a.b"; find("mass")', '"rotor" "_drag"',
                     '"in"\n    "ertia"', '\'"\'; find("mass"); \'"\''):
            self.assertTrue(asked(f"if ({code})\n", names), code)
        for code in ('"rotor"', '"delay"', '"the mass of the vehicle"', '// "mass"', '/* "mass"\n"gust" */', '"mass_kg"', "u{}"):
            self.assertFalse(asked(f"if ({code})\n", names), code)


if __name__ == "__main__":
    unittest.main()
