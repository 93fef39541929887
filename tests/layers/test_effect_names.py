"""The diagnosis asks for the traits of an effect and never for its name: adding an effect is one file and one row."""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


class EffectNames(unittest.TestCase):
    def test_no_effect_is_asked_for_by_name(self):
        registry = (ROOT / "src/effects/registry.cpp").read_text(encoding="utf-8")
        names = re.findall(r'\.name = "(\w+)"', registry)
        self.assertGreater(len(names), 30)
        # whole strings; and in the middle of one the names that are no English words
        asked = re.compile('"(' + "|".join(names) + ')(#|")|type = \\\\"(' + "|".join(names) + r")\b"
                           + r'|"[^"]*\b(' + "|".join(n for n in names if "_" in n) + r')\b[^"]*"')
        found = [f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
                 for folder in ("src/diagnosis", "src/simulation") for path in sorted((ROOT / folder).rglob("*.[ch]pp"))
                 for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
                 if asked.search(line.split("//")[0])]
        self.assertFalse(found, "a trait of the effect's row (include/gustlab/effect.hpp) should say this:\n" + "\n".join(found))
