"""Good recordings broken in twenty ways: the diagnosis says what is wrong with each, and takes none of it for physics."""

import csv
import json
import math
import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

PROGRAM = os.environ["GUSTLAB_PROGRAM"]

EXPERIMENT = """
format = "gustlab-experiment/1"
name = "good"
vehicle = "crazyflie"
trajectories = ["lemniscate"]
controllers = ["pid"]
replicates = 2
duration_s = 11.0
[trajectory.lemniscate]
amplitude_m = 1.0
period_s = 4.0
ramp_s = 1.0
[[effect]]
type = "measurement_noise"
position_sd = 0.001
attitude_sd = 0.002
rate_sd = 0.01
accelerometer_sd = 0.05
"""

POSITION, VELOCITY, ATTITUDE = ("px", "py", "pz"), ("vx", "vy", "vz"), ("qw", "qx", "qy", "qz")
RATE, FORCE, INPUT = ("wx", "wy", "wz"), ("ax", "ay", "az"), ("u1", "u2", "u3", "u4")


class Log:
    def __init__(self, path, duration_s=5.0):
        with open(path, newline="") as file:
            head, *rows = list(csv.reader(file))
        self.names = ["time_s", *POSITION, *VELOCITY, *ATTITUDE, *RATE, *FORCE, *INPUT]
        where = [head.index(name) for name in self.names]
        self.rows = [dict(zip(self.names, (float(row[i]) for i in where))) for row in rows]
        self.rows = [row for row in self.rows if row["time_s"] < duration_s]

    def text(self, names=None):
        lines = [",".join(names or self.names)]
        lines += [",".join(str(row[name]) for name in self.names) for row in self.rows]
        return "\n".join(lines) + "\n"

    def change(self, names, function):
        """function(value, row number) for each of the columns"""
        for k, row in enumerate(self.rows):
            row.update({name: function(row[name], k) for name in names})
        return self.text()


def held(log, names, length, first=0, last=10**9):
    before = {name: [row[name] for row in log.rows] for name in names}
    for k, row in enumerate(log.rows):
        if first <= k < last:
            row.update({name: before[name][first + (k - first) // length * length] for name in names})
    return log.text()


def late(log, names, rows, first):
    before = [{name: row[name] for name in names} for row in log.rows]
    for k in range(first, len(log.rows)):
        log.rows[k].update(before[k - rows])
    return log.text()


def scalar_last(log):
    for row in log.rows:
        w, x, y, z = (row[name] for name in ATTITUDE)
        row.update(dict(zip(ATTITUDE, (x, y, z, w))))
    return log.text()


def straight(log, first, last):
    start, end = dict(log.rows[first]), dict(log.rows[last])
    for k in range(first, last):
        share = (k - first) / (last - first)
        log.rows[k].update({name: start[name] + share * (end[name] - start[name]) for name in INPUT})
    return log.text()


def double_rows(log):
    log.rows = log.rows[:500] + [row for row in log.rows[500:520] for _ in (0, 1)] + log.rows[520:]
    return log.text()


def cut(log, first, last):
    del log.rows[first:last]
    return log.text()


# how the log is broken; exit code; a kind of finding, or part of the message
BROKEN = {
    "frozen": (lambda log: held(log, ATTITUDE, 10**9, 500, 900), 0, "frozen"),
    "held": (lambda log: held(log, POSITION, 10), 0, "held"),
    "duplicated": (double_rows, 0, "duplicate"),
    "out of range": (lambda log: log.change(["px"], lambda v, k: 1e6 if k == 700 else v), 0, "out_of_range"),
    "position in millimetres": (lambda log: log.change(POSITION, lambda v, k: 1e3 * v), 3, "is it in metres?"),
    "rate in degrees": (lambda log: log.change(RATE, lambda v, k: math.degrees(v)), 3, "looks like degrees per second"),
    "acceleration in g": (lambda log: log.change(FORCE, lambda v, k: v / 9.81), 0, "unit"),
    "sign of a rate": (lambda log: log.change(["wy"], lambda v, k: -v), 3, "contradicts the body rate"),
    "sign of the accelerometer": (lambda log: log.change(FORCE, lambda v, k: -v), 0, "sign"),
    "gap": (lambda log: cut(log, 900, 1100), 0, "gap"),
    "truncated": (lambda log: log.text()[:100_000], 3, "cells, the header 21"),
    "not a number": (lambda log: log.change(["vx"], lambda v, k: "nan" if k == 400 else v), 3, "is not a finite number"),
    "time that falls": (lambda log: log.change(["time_s"], lambda v, k: v - (0.1 if k > 500 else 0.0)), 3, "time does not rise"),
    "swapped columns": (lambda log: log.text([{"px": "py", "py": "px"}.get(name, name) for name in log.names]), 0, "inconsistent"),
    "swapped rates": (lambda log: log.text([{"wx": "wy", "wy": "wx"}.get(name, name) for name in log.names]), 3, "contradicts"),
    "constant column": (lambda log: log.change(["wz"], lambda v, k: 0.0), 0, "frozen"),
    "constant input": (lambda log: log.change(["u1"], lambda v, k: 1962.0), 3, "1 of 4 inputs never change"),
    "too short": (lambda log: cut(log, 30, 10**9), 3, "fewer than 50 samples"),
    "empty": (lambda log: "", 3, "the file is empty"),
    "scalar-last quaternion": (scalar_last, 3, "looks scalar-last"),
    "clipped": (lambda log: log.change(["wx", "wy"], lambda v, k: max(-0.1, min(0.1, v))), 3, "contradicts the body rate"),
    "delayed stretch": (lambda log: late(log, RATE, 30, len(log.rows) // 2), 0, "delay"),
    "interpolated": (lambda log: straight(log, 900, 1300), 3, "straight line"),
    "mixed unit": (lambda log: log.change(INPUT, lambda v, k: (v - 380.8359) / 0.04076521 if k > 1200 else v), 3, "are outside"),
}


class BadLogs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp(prefix="gustlab_test_"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        (cls.folder / "good.toml").write_text(EXPERIMENT)
        for name, replicate in (("good", "1"), ("other", "2")):
            subprocess.run([PROGRAM, "run", "good.toml", "--trajectory", "lemniscate", "--controller", "pid", "--replicate", replicate,
                            "--out", name, "--quiet"], cwd=cls.folder, check=True)
            cls.write(name, Log(cls.folder / name / "flight.csv").text())

    @classmethod
    def write(cls, name, text, vehicle="crazyflie"):
        (cls.folder / f"{name}.csv").write_text(text)
        meta = (cls.folder / "good" / "flight.meta.toml").read_text()
        (cls.folder / f"{name}.meta.toml").write_text(meta.replace('"crazyflie"', f'"{vehicle}"'))

    def diagnose(self, name):
        out = self.folder / f"{name}_diagnosis"
        said = subprocess.run([PROGRAM, "diagnose", f"{name}.csv", "--holdout", "other.csv", "--out", str(out)], cwd=self.folder,
                              capture_output=True, text=True, timeout=600)
        return said, json.loads((out / "diagnosis.json").read_text()) if said.returncode == 0 else None

    def test_good_one_is_consistent(self):
        said, result = self.diagnose("good")
        self.assertEqual(said.returncode, 0, said.stderr)
        self.assertEqual((result["verdict"], result["log_findings"], result["effects"]), ("consistent", [], []))

    def test_broken_ones_are_said_to_be_so(self):
        for name, (break_it, code, says) in BROKEN.items():
            with self.subTest(name):
                # a delay is compared between stretches of five seconds
                self.write("broken", break_it(Log(self.folder / "good" / "flight.csv", 11.0 if "delayed" in name else 5.0)))
                said, result = self.diagnose("broken")
                self.assertEqual(said.returncode, code, said.stderr)
                if result is None:
                    self.assertIn(says, said.stderr)
                else:
                    self.assertIn(says, [finding["kind"] for finding in result["log_findings"]])
                    self.assertEqual(result["effects"], [])
                shutil.rmtree(self.folder / "broken_diagnosis", ignore_errors=True)

    def test_wrong_vehicle(self):
        self.write("iris", Log(self.folder / "good" / "flight.csv").text(), "iris")
        said = subprocess.run([PROGRAM, "diagnose", "iris.csv", "--out", "d"], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(said.returncode, 3, said.stderr)
        self.assertIn("are outside 0…807", said.stderr)


if __name__ == "__main__":
    unittest.main()
