"""Flights of the simulator without any noise, logged more slowly than their loop: what was fitted to next to nothing still ends in a diagnosis."""

import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

PROGRAM = os.environ["GUSTLAB_PROGRAM"]

EXPERIMENT = """
format = "gustlab-experiment/1"
name = "smooth"
vehicle = "neuralfly_tunnel"
trajectories = ["multisine", "spiral"]
controllers = ["l1"]
duration_s = 15
effect = [{type = "mass", delta = 0.1}]
log_rate_hz = 50
"""


class SmoothFlights(unittest.TestCase):
    def test_a_cable_of_no_length_is_no_load(self):
        """The swing of a load ran out to a cable of 6 mm beside the mass: no file holds such a load, and nothing was written (exit 4)."""
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            (folder / "smooth.toml").write_text(EXPERIMENT, encoding="utf-8")
            for name in ("multisine", "spiral"):
                subprocess.run([PROGRAM, "run", folder / "smooth.toml", "--trajectory", name, "--seed", "7048", "--out", folder / name],
                               check=True, capture_output=True)
            run = subprocess.run([PROGRAM, "diagnose", folder / "multisine/flight.csv", "--holdout", folder / "spiral/flight.csv",
                                  "--out", folder / "diagnosis", "--jobs", "1"], capture_output=True, text=True, check=False)
            self.assertEqual(0, run.returncode, run.stderr)
            named = {effect["effect"]: effect for effect in json.loads((folder / "diagnosis/diagnosis.json").read_text(encoding="utf-8"))["effects"]}
            self.assertAlmostEqual(0.1, named["mass"]["parameters"]["delta"]["value"], delta=0.005)


if __name__ == "__main__":
    unittest.main()
