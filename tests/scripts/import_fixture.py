"""Synthetic recordings for the importer tests: a smooth flight with noise, written as a foreign CSV or uSD log."""

import contextlib
import io
import json
import math
import re
import struct
import sys
import tempfile
import unittest
import zlib
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))

from gustlab_import import cli, progress  # noqa: E402
from gustlab_import.rotations import conjugate, increment, rotate  # noqa: E402

progress.FIRST_s = math.inf  # nothing here depends on how long an import takes; test_import_progress.py has a clock of its own


def without_progress(said: str) -> str:
    """What a program of its own process wrote to stderr, but for how far it was."""
    return re.sub(r"(?m)^(log \d+ of \d+: )?(reading|checking) .*\n", "", said)


MAP = """format = "gustlab-column-map/1"
kind = "csv"
vehicle = "crazyflie"
[time]
column = "t"
[position]
columns = ["x", "y", "z"]
[velocity]
columns = ["vx", "vy", "vz"]
frame = "world"
[attitude]
columns = ["qx", "qy", "qz", "qw"]
order = "xyzw"
[rate]
columns = ["gx", "gy", "gz"]
unit = "rad/s"
[acceleration]
columns = ["ax", "ay", "az"]
unit = "m/s^2"
[actuator]
kind = "pwm"
columns = ["m1", "m2", "m3", "m4"]
[battery]
column = "bat"
"""
NAMES = ["t", "x", "y", "z", "vx", "vy", "vz", "qx", "qy", "qz", "qw", "gx", "gy", "gz", "ax", "ay", "az",
         "m1", "m2", "m3", "m4", "bat"]


def flight(seconds: float = 20.0, rate_hz: float = 100.0, seed: int = 1) -> dict:
    """Columns of a consistent flight with +-2.5 rad of yaw; every column carries white noise."""
    noise = np.random.default_rng(seed)
    t = np.arange(round(seconds * rate_hz)) / rate_hz
    fine = np.arange(len(t) * 10 + 1) / (10 * rate_hz)
    roll, pitch = 0.25 * np.sin(5.1 * fine), 0.2 * np.sin(7.3 * fine + 1.0)
    yaw = 2.5 * np.sin(0.7 * fine)
    q = multiply(multiply(axis(yaw, 2), axis(pitch, 1)), axis(roll, 0))
    rate = increment(q) * 10 * rate_hz
    q, rate = q[:-1:10], 0.5 * (rate[::10] + rate[np.maximum(np.arange(0, len(rate), 10) - 1, 0)])
    p = np.column_stack([np.sin(1.3 * t), 0.8 * np.cos(1.9 * t), 1.2 + 0.3 * np.sin(2.3 * t)])
    v = np.column_stack([1.3 * np.cos(1.3 * t), -1.52 * np.sin(1.9 * t), 0.69 * np.cos(2.3 * t)])
    a = np.column_stack([-1.69 * np.sin(1.3 * t), -2.888 * np.cos(1.9 * t), -1.587 * np.sin(2.3 * t) + 9.81])
    force = rotate(conjugate(q), a)
    motors = 38000 + 2500 * np.sin(2.3 * t)[:, None] + noise.normal(0, 300, (len(t), 4))

    def noisy(values, sigma):
        return values + noise.normal(0, sigma, values.shape)

    q = noisy(q, 2e-4)
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    block = np.column_stack([t, noisy(p, 2e-5), noisy(v, 2e-3), q[:, [1, 2, 3, 0]], noisy(rate, 5e-3), noisy(force, 0.05),
                             np.round(motors), noisy(4.0 - 0.01 * t, 2e-3)])
    return {name: block[:, k] for k, name in enumerate(NAMES)}


def axis(angle: np.ndarray, k: int) -> np.ndarray:
    q = np.zeros((len(angle), 4))
    q[:, 0], q[:, k + 1] = np.cos(angle / 2), np.sin(angle / 2)
    return q


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    scalar = a[:, 0] * b[:, 0] - np.sum(a[:, 1:] * b[:, 1:], axis=1)
    return np.column_stack([scalar, a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:] + np.cross(a[:, 1:], b[:, 1:])])


def csv(columns: dict) -> str:
    rows = np.column_stack(list(columns.values()))
    cells = [["" if np.isnan(value) else f"{value:.9g}" for value in row] for row in rows]
    return ",".join(columns) + "\n" + "\n".join(",".join(row) for row in cells) + "\n"


def usd(version: int, records: list, variables=(("acc.z", "f"), ("gyro.x", "f"), ("motor.m1", "H"), ("motor.m2", "H"),
                                                ("motor.m3", "H"), ("motor.m4", "H"))) -> bytes:
    """A micro-SD log with one event type; records: (ticks, value, value, ...)."""
    out = struct.pack("<BHH", 0xBC, version, 2) + struct.pack("<H", 7) + b"unused\0" + struct.pack("<H", 0)
    out += struct.pack("<H", 65535) + b"fixedFrequency\0" + struct.pack("<H", len(variables))
    out += b"".join(f"{name}({kind})\0".encode() for name, kind in variables)
    layout = "<" + "".join(kind for _, kind in variables)
    for ticks, *values in records:
        out += struct.pack("<HI" if version == 1 else "<HQ", 65535, ticks) + struct.pack(layout, *values)
    return out + struct.pack("<I", zlib.crc32(out))


class ImportCase(unittest.TestCase):
    """Runs the importer in a folder of its own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.map = self.write("test_map.toml", MAP)
        self.out = self.folder / "out"

    def write(self, name: str, content) -> Path:
        path = self.folder / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    def run_import(self, *arguments) -> tuple:
        """(exit code, stdout, stderr); what stderr says of a vehicle that is missing, in self.no_vehicle"""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                code = cli.main([str(argument) for argument in arguments])
            except SystemExit as end:
                code = end.code
        lines = err.getvalue().splitlines(keepends=True)
        self.no_vehicle = "".join(line for line in lines if ": no vehicle file is there" in line)
        return code, out.getvalue(), "".join(line for line in lines if line not in self.no_vehicle)

    def inspect(self, columns: dict, map_text: str = MAP, *more) -> tuple:
        """(exit code, findings, stderr) of a recording made of these columns; writes to self.out."""
        log = self.write("log.csv", csv(columns))
        code, out, err = self.run_import(log, "--map", self.write("m.toml", map_text), "--out", self.out, "--format",
                                         "json", *more)
        return code, json.loads(out)["logs"][0]["findings"] if out else [], err

    def written(self, name: str = "log_1.csv") -> dict:
        """Columns of a flight log that the importer wrote."""
        lines = (self.out / name).read_text().splitlines()
        rows = [[float(cell) if cell else np.nan for cell in line.split(",")] for line in lines[1:]]
        return dict(zip(lines[0].split(","), np.array(rows).T))

    def assertFound(self, findings: list, kind: str, words: str = "", severity: str = None):
        hits = [f for f in findings if f["kind"] == kind and words in f["says"] and severity in (None, f["severity"])]
        self.assertTrue(hits, f"no `{kind}` finding with `{words}` among {findings}")
        return hits[0]
