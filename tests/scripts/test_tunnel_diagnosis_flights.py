"""Neural-Fly's wind tunnel (O'Connell et al. 2022, doi:10.1126/scirobotics.abm6597): flights in still air and in wind of known speed."""

import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import pytest

HOME = Path(__file__).resolve().parents[2]
FLIGHTS = Path(os.environ.get("GUSTLAB_FLIGHTS", ""))
PROGRAM = os.environ.get("GUSTLAB_PROGRAM", "")


@unittest.skipUnless((FLIGHTS / "neuralfly").is_dir() and PROGRAM, "GUSTLAB_FLIGHTS or GUSTLAB_PROGRAM is not set: the tunnel was not diagnosed")
class WindTunnel(unittest.TestCase):
    @pytest.mark.slow
    def test_drag_and_the_wind_of_every_flight_are_named(self):
        with tempfile.TemporaryDirectory() as folder:
            call = lambda *command: subprocess.run([*map(str, command)], cwd=folder, check=True, capture_output=True)
            call(sys.executable, HOME / "scripts/prove/families.py", FLIGHTS, "--only", "neuralfly", "--out", "families")
            tunnel = Path(folder, "families/neuralfly/tunnel")
            call(PROGRAM, "diagnose", *sorted(tunnel.glob("fit_*.csv")), "--holdout", *sorted(tunnel.glob("holdout_*.csv")), "--out", "diagnosis")
            found = json.loads(Path(folder, "diagnosis/diagnosis.json").read_text(encoding="utf-8"))
        effects = {effect["effect"]: effect for effect in found["effects"]}
        self.assertIn("steady_wind", effects, sorted(effects))
        self.assertTrue(effects.keys() & {"rotor_drag", "quadratic_drag"}, sorted(effects))
        wind_mps = {name.removeprefix("fit_").removesuffix(".csv"): wind["x"]["value"] for name, wind in effects["steady_wind"]["per_flight"].items()}
        # the tunnel blows along -x, at 12.1, 8.5, 4.2 and 0 m/s
        ordered = [wind_mps[flight] for flight in ("NF-T_100wind", "NF-C_70wind", "L1_35wind", "NF_nowind")]
        self.assertEqual(ordered, sorted(ordered))
        self.assertAlmostEqual(wind_mps["NF-C_70wind"], wind_mps["indi_70wind"], delta=1.0)  # two flights in one wind


if __name__ == "__main__":
    unittest.main()
