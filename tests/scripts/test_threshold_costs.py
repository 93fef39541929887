"""The table whose thresholds can be moved, and the flights in which a rotor's loss is concealed."""

import re
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts" / "prove"))
import threshold_costs  # noqa: E402

TABLE = (ROOT / "src" / threshold_costs.TABLE).read_text(encoding="utf-8")


class Movable(unittest.TestCase):
    def test_every_number_of_the_table_is_replaced_by_name(self):
        text = threshold_costs.movable(TABLE)
        names = {name for declared in re.findall(r"^inline constexpr double ([^;]*);", TABLE, re.MULTILINE) for name in re.findall(r"(\w+)\s*=", declared)}
        self.assertGreater(len(names), 80)
        self.assertEqual(set(re.findall(r'(\w+) = moved\("GUSTLAB_DECISION_\1", ', text)), names)
        self.assertNotIn("constexpr double", text)

    def test_steps_are_on_either_side_of_the_value(self):
        for name, (kind, down, up) in threshold_costs.STEPS.items():
            self.assertIn(kind, ("air", "confidence", "hover"))
            self.assertLess(down, float(threshold_costs.value_of(name)), name)
            self.assertGreater(up, float(threshold_costs.value_of(name)), name)


class ConcealedLoss(unittest.TestCase):
    def test_what_is_left_of_the_thrust_is_what_it_was(self):
        a, b, c = threshold_costs.PWM_THRUST
        thrust = lambda pwm: a * pwm**2 + b * pwm + c
        with tempfile.TemporaryDirectory() as folder:
            log = Path(folder) / "flight_1.csv"
            log.write_text("time_s,u1,u2\n0,30000,31000\n0.01,0,45000\n", encoding="utf-8")
            log.with_suffix(".meta.toml").write_text('vehicle = "x"\n', encoding="utf-8")
            path = threshold_costs.lost(log, 2, 0.1, Path(folder) / "lost")
            rows = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines()[1:]]
            self.assertTrue(path.with_suffix(".meta.toml").exists())
        self.assertEqual([row[:2] for row in rows], [["0", "30000"], ["0.01", "0"]])
        for row, before in zip(rows, (31000, 45000)):
            self.assertAlmostEqual(0.9 * thrust(float(row[2])), thrust(before), places=9)


class Line(unittest.TestCase):
    def test_counts_what_is_exact_wrong_and_rightly_silent(self):
        row = lambda kind, exact, wrong, verdict: {"trial": "t", "kind": kind, "exact": exact, "wrong": wrong, "verdict": verdict}
        before = [row("something", True, False, True), row("something", False, True, True), row("nothing", True, False, True), row("outside", True, False, False)]
        after = [row("something", True, False, True), row("something", True, False, True), row("nothing", False, True, False), row("outside", True, False, False)]
        self.assertEqual(threshold_costs.line("x (1.0)", "2", after, before), "| x (1.0) | 2 | 2 of 2 | 1 of 4 | 0 of 1 | 0 of 1 | 2 |")


if __name__ == "__main__":
    unittest.main()
