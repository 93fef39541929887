"""A recorded quadrotor whose inputs come too early by 32 ms, which is longer than half a swing of its torques."""

import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

HOME = Path(__file__).resolve().parents[2]
FLIGHTS = os.environ.get("GUSTLAB_FLIGHTS", "")
PROGRAM = os.environ.get("GUSTLAB_PROGRAM", "")
sys.path.insert(0, str(HOME / "scripts" / "prove"))

from semi_real import SETS, Case, Recordings, build  # noqa: E402


@unittest.skipUnless(Path(FLIGHTS, "imrc").is_dir() and PROGRAM, "GUSTLAB_FLIGHTS or GUSTLAB_PROGRAM is not set: the flights were not diagnosed")
class LateRotors(unittest.TestCase):
    def test_a_delay_longer_than_half_a_swing_is_found_with_its_size(self):
        with tempfile.TemporaryDirectory() as folder:
            flights, case = Path(folder, "flights"), Path(folder, "case")
            subprocess.run([sys.executable, str(HOME / "scripts/prove/families.py"), FLIGHTS, "--out", str(flights), "--only", "imrc"], check=True,
                           capture_output=True)
            late = Case("input_actuation_delay", "imrc_bare", "input", "file", "actuation_delay", {"delay": 0.032})
            build(late, Recordings(flights, SETS["imrc_bare"]), case)
            subprocess.run([PROGRAM, "diagnose", *map(str, sorted(case.glob("fit_*.csv"))), "--out", str(case / "diagnosis"), "--jobs", "2"], check=True,
                           capture_output=True)
            found = json.loads((case / "diagnosis/diagnosis.json").read_text(encoding="utf-8"))
        delay = {effect["effect"]: effect for effect in found["effects"]}["actuation_delay"]["parameters"]["delay"]["value"]
        # the untouched flights show 4 ms of it
        self.assertAlmostEqual(delay, 0.034, delta=0.004)


if __name__ == "__main__":
    unittest.main()
