"""The importer on the published flights; GUSTLAB_FLIGHTS names the folder that holds nanodrone/, nanobench/, ..."""

import hashlib
import json
import os
import tomllib
import unittest
from pathlib import Path

import numpy as np
from import_fixture import ImportCase
from gustlab_import.signals import band

FLIGHTS = os.environ.get("GUSTLAB_FLIGHTS", "")
DATA = Path(__file__).resolve().parents[2] / "docs" / "DATA.md"


@unittest.skipUnless(FLIGHTS and Path(FLIGHTS).is_dir(), "GUSTLAB_FLIGHTS is not set: the published flights were not read")
class Published(ImportCase):
    def files(self, folder: str, pattern: str) -> list:
        found = sorted(Path(FLIGHTS, folder).glob(pattern))
        if not found:
            self.skipTest(f"no {folder}/{pattern} under GUSTLAB_FLIGHTS")
        return found

    def take(self, name: str, files: list, *more) -> tuple:
        code, out, err = self.run_import(*files, "--map", name, "--format", "json", "--out", self.out, *more)
        return code, {one["flights"][0]["log"].removesuffix("_1.csv"): one for one in json.loads(out)["logs"]}, err

    def test_checksums_are_those_of_the_documentation(self):
        text = DATA.read_text()
        described = [Path(FLIGHTS, name) for name in ("nanodrone", "nanobench", "arpl", "crazypad")]
        for path in sorted(path for folder in described for path in folder.rglob("*")):
            if path.is_file() and path.name not in ("LICENSE", "README.md"):
                self.assertIn(hashlib.sha256(path.read_bytes()).hexdigest(), text, path.name)

    def test_nanodrone(self):
        code, flights, _ = self.take("nanodrone", self.files("nanodrone", "*_run1*.csv.gz"))
        self.assertEqual(code, 0)
        for flight in flights.values():
            self.assertFound(flight["findings"], "filtered", "body rate: nothing faster than about 2", "warning")
            self.assertFound(flight["findings"], "delay", "earlier than attitude")
        written = self.written("test_melon_run1_bag1_1.csv")
        self.assertEqual(len(written["time_s"]), 6499)
        # weight from the published thrust coefficient and mass: rotors in rad/s, z up, in hover and on average
        thrust = 3.72e-8 * sum(written[f"u{k}"] ** 2 for k in (1, 2, 3, 4))
        self.assertAlmostEqual(float(np.mean(thrust)) / (0.045 * 9.81), 1.0, delta=0.05)
        # README of the set: 3 and 4 are on the left, 2 and 3 at the back
        self.check_mix(written, 0.0)

    def check_mix(self, written: dict, lag_s: float):
        """More speed on the left rolls right, more at the back pitches down: signs of a fitted mix of the inputs."""
        step = float(np.median(np.diff(written["time_s"])))
        shift = round(lag_s / step)
        inputs = band(np.column_stack([written[f"u{k}"] for k in (1, 2, 3, 4)]), step)
        turned = band(np.gradient(np.column_stack([written["wx"], written["wy"]]), step, axis=0), step)
        mix = np.linalg.lstsq(inputs[:len(inputs) - shift], turned[shift:], rcond=None)[0]
        self.assertEqual([list(np.sign(column)) for column in mix.T], [[-1, -1, 1, 1], [-1, 1, 1, -1]])

    def test_nanobench(self):
        code, flights, _ = self.take("nanobench", self.files("nanobench", "B[236]_*.csv.gz"))
        self.assertEqual(code, 0)
        for name, flight in flights.items():
            self.assertFound(flight["findings"], "ground", "left out")
            written = self.written(name + "_1.csv")
            self.assertAlmostEqual(float(np.median(written["az"])), 9.81, delta=0.2)
            self.assertGreater(np.min(written["pz"]), 0.14)
            self.check_mix(written, 0.04)
        self.assertFound(flights["B3_figure8_fast_rep2"]["findings"], "delay", "body rate against attitude: the time offset "
                         "is not constant", "warning")

    def test_the_corrupt_nanobench_file_is_refused(self):
        files = self.files("nanobench", "B9_trefoil_medium_rep13.csv.gz")
        code, flights, err = self.take("nanobench", files)
        self.assertEqual(code, 3)
        self.assertFalse(self.out.exists())
        self.assertIn("nothing was received after 37.97 s", err)
        self.assertIn("u4 411441", err)
        code, flights, _ = self.take("nanobench", files, "--to", 37.9)
        self.assertEqual(code, 0)

    def test_arpl(self):
        code, flights, _ = self.take("arpl", self.files("arpl", "log1[05]"))
        self.assertEqual(code, 0)
        sidecar = tomllib.loads((self.out / "log10_1.meta.toml").read_text())
        self.assertEqual((sidecar["actuator"], sidecar["hold"]), ("pwm", "zoh"))
        written = self.written("log10_1.csv")
        self.assertGreaterEqual(written["time_s"][0], 35.0)
        self.assertLessEqual(written["time_s"][-1], 65.0)
        self.assertFound(flights["log10"]["findings"], "held", "actuators")
        self.assertFound(flights["log15"]["findings"], "gap", "5 gaps")

    def test_crazypad(self):
        code, flights, _ = self.take("crazypad", self.files("crazypad", "*/E*"))
        self.assertEqual(code, 0)
        self.assertEqual(len(flights), 8)
        written = self.written("normal_flight-E8_log00_1.csv")
        self.assertGreater(np.min(written["pz"]), 0.09)
        # height above the estimated acceleration: it is in the world frame with gravity removed
        self.assertLess(abs(float(np.mean(written["acc_world_z"]))), 0.5)
        self.assertLess(np.max(np.abs(written["roll_rad"])), 0.5)


if __name__ == "__main__":
    unittest.main()
