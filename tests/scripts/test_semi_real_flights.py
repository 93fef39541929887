"""What is concealed in recorded flights, and was not found before."""

import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import pytest

HOME = Path(__file__).resolve().parents[2]
FLIGHTS = os.environ.get("GUSTLAB_FLIGHTS", "")
PROGRAM = os.environ.get("GUSTLAB_PROGRAM", "")
sys.path.insert(0, str(HOME / "scripts" / "prove"))

from semi_real import SETS, Case, Recordings, build  # noqa: E402


def effects_of(case, family):
    """{name: effect} of what is named where `case` is concealed in the recorded flights of its family."""
    with tempfile.TemporaryDirectory() as folder:
        flights, built = Path(folder, "flights"), Path(folder, "case")
        subprocess.run([sys.executable, str(HOME / "scripts/prove/families.py"), FLIGHTS, "--out", str(flights), "--only", family], check=True,
                       capture_output=True)
        build(case, Recordings(flights, SETS[case.set]), built)
        fitted, held_out = (sorted(map(str, built.glob(f"{role}_*.csv"))) for role in ("fit", "holdout"))
        subprocess.run([PROGRAM, "diagnose", *fitted, "--holdout", *held_out, "--out", str(built / "diagnosis"), "--jobs", "2"], check=True,
                       capture_output=True)
        found = json.loads((built / "diagnosis/diagnosis.json").read_text(encoding="utf-8"))
    return {effect["effect"]: effect for effect in found["effects"]}


@unittest.skipUnless(Path(FLIGHTS, "imrc").is_dir() and PROGRAM, "GUSTLAB_FLIGHTS or GUSTLAB_PROGRAM is not set: the flights were not diagnosed")
class ConcealedInFlights(unittest.TestCase):
    def test_a_delay_longer_than_half_a_swing_of_the_torques_is_found_with_its_size(self):
        late = Case("input_actuation_delay", "imrc_bare", "input", "file", "actuation_delay", {"delay": 0.032})
        delay = effects_of(late, "imrc")["actuation_delay"]["parameters"]["delay"]["value"]
        # the untouched flights show 4 ms of it
        self.assertAlmostEqual(delay, 0.034, delta=0.004)

    @pytest.mark.slow
    def test_a_force_of_every_flight_that_a_number_replaced_does_not_come_back(self):
        heavier = Case("file_mass", "neuralswarm", "file", "file", "mass", {"delta": -0.107})
        found = effects_of(heavier, "neuralswarm")
        self.assertIn("mass", set(found))
        self.assertNotIn("constant_force", set(found))


if __name__ == "__main__":
    unittest.main()
