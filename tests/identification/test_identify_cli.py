"""`gustlab identify` on the command line: formats, the model file, and what it says and returns when something is wrong."""

import json
import os
import subprocess
import tempfile
import tomllib
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("GUSTLAB_PROGRAM", str(ROOT / "build" / "release" / "gustlab"))
SIDECAR = 'format = "gustlab-flight/1"\nvehicle = "crazyflie"\nactuator = "thrust"\nsource = "simulation"\n'
MASS_KG, GRAVITY = 0.0282, 9.81


def write_flight(path, phase=0.0, rows=400):
    """A flight at 50 Hz that rocks about hover, whose accelerometer feels 0.02 N along x and −0.3 T sin θ besides."""
    t = 0.02 * np.arange(rows)
    pitch = 0.3 * np.sin(1.7 * t + phase) + 0.1 * np.cos(4.1 * t)
    thrust = 0.277 + 0.08 * np.sin(2.3 * t + phase)
    force_x = 0.02 - 0.3 * thrust * np.sin(pitch)
    columns = {"time_s": t, "qw": np.cos(pitch / 2), "qx": 0 * t, "qy": np.sin(pitch / 2), "qz": 0 * t,
               "px": 0 * t, "py": 0 * t, "pz": 1 + 0 * t, "vx": 0 * t, "vy": 0 * t, "vz": 0 * t,
               "ax": np.cos(pitch) * force_x / MASS_KG, "ay": 0 * t, "az": (thrust + np.sin(pitch) * force_x) / MASS_KG}
    columns |= {f"u{i}": thrust / 4 for i in (1, 2, 3, 4)}
    np.savetxt(path, np.column_stack(list(columns.values())), fmt="%.17g", delimiter=",", header=",".join(columns), comments="")
    path.with_suffix(".meta.toml").write_text(SIDECAR, encoding="utf-8")


class IdentifyCli(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        write_flight(self.folder / "a.csv")
        write_flight(self.folder / "b.csv", 1.0)
        # the vehicle's motor lag would come between u and thrust
        (self.folder / "rigid.toml").write_text(
            (ROOT / "models" / "crazyflie" / "vehicle.toml").read_text(encoding="utf-8").split("[[effect]]")[0]
            .replace('"crazyflie.xml"', '"rigid.xml"'), encoding="utf-8")
        (self.folder / "rigid.xml").write_bytes((ROOT / "models" / "crazyflie" / "crazyflie.xml").read_bytes())

    def run_identify(self, *options):
        command = [PROGRAM, "identify", *map(str, options)]
        return subprocess.run(command, capture_output=True, text=True, cwd=self.folder, check=False)

    def identify(self, *options):
        done = self.run_identify("a.csv", "b.csv", "--vehicle", "rigid.toml", "--acceleration", "accelerometer", *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_json_names_what_was_planted(self):
        for optimizer in ("stlsq", "sr3", "best_subset"):
            found = json.loads(self.identify("--optimizer", optimizer, "--format", "json"))
            named = {(target, term): value for target, row in zip(found["targets"], found["coefficients"])
                     for term, value in zip(found["terms"], row) if value}
            self.assertEqual(set(named), {("fx", "1"), ("fx", "T sin theta")}, optimizer)
            self.assertAlmostEqual(named["fx", "1"], 0.02, delta=1e-6)
            self.assertAlmostEqual(named["fx", "T sin theta"], -0.3, delta=1e-5)
            self.assertLess(found["error_fit"], 1e-6)
            self.assertLess(found["error_holdout"], 1e-6)
            self.assertGreater(found["condition_number"], 1.0)

    def test_the_model_file_is_what_was_printed_and_nothing_else_is_written(self):
        before = set(os.listdir(self.folder))
        found = json.loads(self.identify("--out", "model.toml", "--format", "json"))
        self.assertEqual(set(os.listdir(self.folder)) - before, {"model.toml"})
        text = (self.folder / "model.toml").read_text(encoding="utf-8")
        self.assertNotIn(str(self.folder), text)
        (effect,) = tomllib.loads(text)["effect"]
        self.assertEqual(effect["type"], "sindy_residual")
        for target, row in zip(found["targets"], found["coefficients"]):
            written = dict(zip(effect["terms"], effect[target]))
            for term, value in zip(found["terms"], row):
                self.assertEqual(written.get(term, 0.0), value)

    def test_the_same_input_gives_the_same_bytes(self):
        first = self.identify("--format", "json", "--out", "one.toml")
        self.assertEqual(first, self.identify("--format", "json", "--out", "two.toml"))
        self.assertEqual((self.folder / "one.toml").read_bytes(), (self.folder / "two.toml").read_bytes())

    def test_held_out_flights_are_not_fitted(self):
        done = self.run_identify("a.csv", "--holdout", "b.csv", "--vehicle", "rigid.toml", "--acceleration", "accelerometer",
                                 "--format", "json")
        found = json.loads(done.stdout)
        self.assertEqual(found["samples"], 400)
        self.assertEqual(found["holdout"], "flights")
        self.assertLess(found["error_holdout"], 1e-6)

    def test_tables_for_people_and_programs(self):
        table = self.identify()
        self.assertIn("| T sin theta | -0.3 |", table)
        self.assertIn("nothing can be said of: phi, T sin phi.", table)
        lines = self.identify("--format", "csv").splitlines()
        self.assertEqual(lines[0], "target,term,coefficient")
        self.assertEqual([line.rsplit(",", 1)[0] for line in lines[1:]], ["fx,1", "fx,T sin theta"])

    def test_usage_errors_are_2_and_data_errors_3_and_nothing_is_written(self):
        usage = (["--library", "paper,"], ["--library", "polynomial:9"], ["--optimizer", "lasso"], ["--lambda", "much"],
                 ["--lambda", "-1"], ["--nu", "0"], ["--penalty", "l3"], ["--constraint", "fx[nothing] = 0"],
                 ["--optimizer", "stlsq", "--constraint", "fx[1] = 0"], ["--smooth", "2"], ["--derivative", "spline"],
                 ["--format", "yaml"], ["--vehicle", "no_such_vehicle"], ["--refit", "--no-refit"], ["--no-such-option"],
                 ["--library", "polynomial:4:vx,vy,vz", "--optimizer", "best_subset"])
        data = (["--trim", "60"], ["--smooth", "401"], ["--derivative", "savitzky_golay", "--window", "1001"])
        (self.folder / "a.csv").rename(self.folder / "c.csv")
        (self.folder / "a.meta.toml").rename(self.folder / "c.meta.toml")
        before = set(os.listdir(self.folder))
        for code, cases in ((2, usage), (3, data)):
            for options in cases:
                done = self.run_identify("c.csv", *options, "--out", "model.toml")
                self.assertEqual(done.returncode, code, f"{options}: {done.stderr}")
                self.assertTrue(done.stderr.strip(), options)
                self.assertEqual(done.stdout, "")
        self.assertEqual(self.run_identify("missing.csv").returncode, 3)
        self.assertEqual(self.run_identify().returncode, 2)
        self.assertEqual(set(os.listdir(self.folder)), before)

    def test_no_term_is_said_and_no_model_written(self):
        options = ("a.csv", "--vehicle", "rigid.toml", "--lambda", "1e9")
        done = self.run_identify(*options, "--out", "model.toml")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("No term earns its place", done.stdout)
        self.assertIn("model.toml: not written (no term was found", done.stderr)
        self.assertFalse((self.folder / "model.toml").exists())
        self.assertEqual(self.run_identify(*options).returncode, 0)

    def test_another_vehicle_than_the_logs_is_said(self):
        self.assertEqual(self.run_identify("a.csv", "--vehicle", "rigid.toml").stderr, "")
        said = self.run_identify("a.csv", "--vehicle", "iris").stderr
        self.assertEqual(said, 'warning: a.csv: flown by "crazyflie", and --vehicle iris is "iris"\n')

    def test_a_place_that_is_not_there_is_2(self):
        done = self.run_identify("a.csv", "--out", "no/such/folder/model.toml")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual(done.stdout, "")


if __name__ == "__main__":
    unittest.main()
