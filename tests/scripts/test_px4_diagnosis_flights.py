"""The recorded PX4 log whose truth is known, from the log to names in two commands; docs/LOGS.md says the same."""

import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

LOG = Path(os.environ.get("GUSTLAB_FLIGHTS", ""), "logs/px4_hitl_jmavsim.ulg")
PROGRAM = os.environ.get("GUSTLAB_PROGRAM", "")


@unittest.skipUnless(LOG.is_file() and PROGRAM, "GUSTLAB_FLIGHTS or GUSTLAB_PROGRAM is not set: the log was not diagnosed")
class HardwareInTheLoop(unittest.TestCase):
    def test_the_push_is_named_and_the_right_mass_is_not(self):
        with tempfile.TemporaryDirectory() as folder:
            call = lambda *arguments: subprocess.run([PROGRAM, *arguments], cwd=folder, check=True, capture_output=True)
            call("import", str(LOG), "--out", "logs", "--mass", "0.8kg", "--arm", "0.165m", "--thrust-to-weight", "2.04", "--throttle-curve", "0")
            call("diagnose", "logs/px4_hitl_jmavsim_1.csv", "--out", "diagnosis")
            found = json.loads(Path(folder, "diagnosis/diagnosis.json").read_text(encoding="utf-8"))
        # jMAVSim's wind changes at random: one push, which these flights do not tell from a tilt; nothing of mass or thrust
        self.assertEqual(len(found["effects"]), 1)
        self.assertIn("constant_force", found["effects"][0]["class"])
        position = found["fit"]["position_m"]
        half_a_second = found["fit"]["horizon_s"].index(0.5)
        self.assertLess(position["after"][half_a_second], 0.3 * position["before"][half_a_second])
