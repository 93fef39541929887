#!/usr/bin/env python3
"""Converts the recorded flights that no column map can describe, and lays every family out for the proof.

    families.py FLIGHTS --out DIR [--only NAME,NAME]

Writes DIR/<family>/<set>/{fit,holdout}_<recording>.csv with sidecars, and the vehicle beside them. World ENU, body FLU,
quaternion scalar first, SI units; every stream at its own times (empty cells between its samples).
"""

import argparse
import csv
import gzip
import json
import shutil
import struct
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from flight_files import HOME

sys.path.insert(0, str(HOME / "scripts"))
from gustlab_import.flight import Flight  # noqa: E402
from gustlab_import.rotations import conjugate, rotate  # noqa: E402
from gustlab_import.usd_log import read_usd  # noqa: E402
from gustlab_import.write_log import csv_text  # noqa: E402

G_MPS2 = 9.80665
POSITION, VELOCITY, ATTITUDE = ("px", "py", "pz"), ("vx", "vy", "vz"), ("qw", "qx", "qy", "qz")
RATE, ACCELERATION = ("wx", "wy", "wz"), ("ax", "ay", "az")
INPUT, ROTOR = ("u1", "u2", "u3", "u4"), ("rotor1", "rotor2", "rotor3", "rotor4")


@dataclass
class Recording:
    """Streams {column names: (time_s (n,), values (n, k))} and what the sidecar says besides the vehicle."""
    streams: dict
    meta: dict
    condition: dict = field(default_factory=dict)
    environment: dict = field(default_factory=dict)


def changed(time_s, values):
    """The samples at which a stream that is repeated between its samples moves, the first included."""
    new = np.r_[True, np.any(np.diff(values, axis=0) != 0, axis=1)]
    return time_s[new], values[new]


def merged(streams):
    """(time_s (n,), {column: (n,) with NaN between its samples}) of streams that each have their own times."""
    ticks = {names: np.round(1e6 * time_s).astype(np.int64) for names, (time_s, _) in streams.items()}
    every = np.unique(np.concatenate(list(ticks.values())))
    columns = {}
    for names, (_, values) in streams.items():
        rows = np.searchsorted(every, ticks[names])
        for k, name in enumerate(names):
            columns[name] = np.full(len(every), np.nan)
            columns[name][rows] = values[:, k]
    return 1e-6 * every, columns


def toml_lines(table):
    return [f"{key} = {json.dumps(value)}" for key, value in table.items()]


def write_flight(target, recording, vehicle):
    """Writes a flight log and its sidecar."""
    time_s, columns = merged(recording.streams)
    target.parent.mkdir(parents=True, exist_ok=True)
    flight = Flight(target.name, time_s, columns, np.arange(len(time_s)), {}, len(time_s))
    target.write_text(csv_text(flight), encoding="utf-8")
    lines = toml_lines({"format": "gustlab-flight/1", "vehicle": vehicle, "source": "recording", **recording.meta})
    for name, table in (("environment", recording.environment), ("condition", recording.condition)):
        if table:
            lines += [f"[{name}]", *toml_lines(table)]
    target.with_suffix(".meta.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")


def upright(q):
    """Unit quaternions (n, 4), scalar first, without sign flips from row to row."""
    q = q / np.linalg.norm(q, axis=1, keepdims=True)
    flips = np.sign(np.sum(q[1:] * q[:-1], axis=1))
    return q * np.cumprod(np.r_[1.0 if q[0, 0] >= 0 else -1.0, np.where(flips == 0, 1, flips)])[:, None]


# ---- imrc: Crazyflie µSD logs, 500 Hz ------------------------------------------------------------------------------

def imrc(path, motion_capture):
    """Pose of the motion capture (100 Hz), or pose and velocity of the estimator where it moves; inertial data,
    commands and measured speeds at 500 Hz."""
    table = read_usd(path, "fixedFrequency").columns
    pick = lambda prefix, parts, source=table: np.column_stack([source[prefix + part] for part in parts])
    time_s = table["tick_s"] - table["tick_s"][0]
    streams = {}
    if motion_capture:
        pose = read_usd(path, "estPose").columns
        pose_s, places = pose["tick_s"] - table["tick_s"][0], pick("locSrv.", "xyz", pose)
        later = np.r_[True, np.diff(pose_s) > 0] & (pose_s >= 0)
        streams[POSITION] = pose_s[later], places[later]
        streams[ATTITUDE] = pose_s[later], upright(pick("locSrv.q", "wxyz", pose))[later]
    else:
        streams[POSITION] = changed(time_s, pick("stateEstimate.", "xyz"))
        streams[VELOCITY] = changed(time_s, pick("stateEstimate.v", "xyz"))
        estimate_s, q = changed(time_s, pick("stateEstimate.q", "wxyz"))
        streams[ATTITUDE] = estimate_s, upright(q)
    streams[RATE] = time_s, np.radians(pick("gyro.", "xyz"))
    streams[ACCELERATION] = time_s, G_MPS2 * pick("acc.", "xyz")
    streams[INPUT] = time_s, pick("pwm.", [f"m{i}_pwm" for i in (1, 2, 3, 4)])
    streams[ROTOR] = time_s, pick("rpm.", [f"m{i}" for i in (1, 2, 3, 4)]) * np.pi / 30
    streams["vbat",] = changed(time_s, 1e-3 * pick("pm.", ["vbatMV"]))
    return Recording(streams, {"actuator": "pwm", "hold": "zoh",
                               "notes": "pose of the motion capture" if motion_capture else "pose and velocity of the estimator on board"})


# ---- neurobem: CSV, 400 Hz, smoothed ---------------------------------------------------------------------------------

def neurobem(path):
    with gzip.open(path, "rt", encoding="utf-8") as file:
        names = file.readline().strip().split(",")
        table = dict(zip(names, np.loadtxt(file, delimiter=",").T))
    pick = lambda *parts: np.column_stack([table[part] for part in parts])
    speed = pick("m1_radps", "m2_radps", "m3_radps", "m4_radps")
    # the last rows are after the landing: one second before the first rotor is below 500 rad/s for good
    last = np.flatnonzero(speed.min(axis=1) > 500)[-1] - 400
    time_s, q = table["t"] - table["t"][0], upright(pick("qw", "qx", "qy", "qz"))
    streams = {POSITION: pick("px", "py", "pz"), VELOCITY: rotate(q, pick("vx_body", "vy_body", "vz_body")), ATTITUDE: q,
               RATE: pick("wx", "wy", "wz"), ACCELERATION: pick("ax", "ay", "az"), INPUT: speed,
               ("vbat",): 0.1 * pick("vbat_dV")}
    return Recording({names: (time_s[:last], values[:last]) for names, values in streams.items()},
                     {"actuator": "rotor_speed", "hold": "linear", "notes": "measured rotor speeds; every channel was smoothed before publication"})


# ---- neuralfly: CSV with lists in cells, 50 Hz ---------------------------------------------------------------------

NEURALFLY_MASS_KG = 2.645


def neuralfly(path):
    with gzip.open(path, "rt", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    table = lambda name: np.array([np.atleast_1d(json.loads(row[name])) for row in rows], dtype=float)
    time_s = table("t")[:, 0]
    # hover_throttle is the running estimate of the thrust set point that carries the weight
    thrust_N = NEURALFLY_MASS_KG * 9.81 * table("T_sp") / table("hover_throttle")
    streams = {POSITION: (time_s, table("p")), VELOCITY: (time_s, table("v")),
               ATTITUDE: (time_s, upright(table("q")[:, [3, 0, 1, 2]])), RATE: (time_s, table("w")), ("u1",): (time_s, thrust_N)}
    wind = {"nowind": 0.0, "35wind": 4.2, "70wind": 8.5, "100wind": 12.1}[path.name.split(".")[0].split("_")[1]]
    return Recording(streams, {"actuator": "collective_thrust", "hold": "unknown", "notes": "wind tunnel, wind along -x"},
                     {"wind_mps": wind})


# ---- neuralswarm: blocks of packed records, 100 Hz -----------------------------------------------------------------

def packed_records(data):
    """{variable: (n,)} of a log of one byte n, n names each "name(type),", 4 bytes, then blocks of one byte k, k packed
    records and 4 bytes."""
    at, names = 1, []
    for _ in range(data[0]):
        end = data.index(b",", at)
        names.append(data[at:end].decode("ascii"))
        at = end + 1
    at, record, rows = at + 4, struct.Struct("<" + "".join(name[-2] for name in names)), []
    while at < len(data):
        count, at = data[at], at + 1
        if at + count * record.size > len(data):
            break
        rows += [record.unpack_from(data, at + k * record.size) for k in range(count)]
        at += count * record.size + 4
    return {name[:-3]: column for name, column in zip(names, np.array(rows, dtype=float).T)}


def smallest_three(packed):
    """Quaternions (n, 4), scalar first, of the Crazyflie's 32-bit packing (quatcompress.h of its firmware): 2 bits for the
    largest component's place in (x, y, z, w), then sign and 9 bits of magnitude / sqrt(1/2) of the others."""
    packed = packed.astype(np.int64)
    largest, left, q = packed >> 30, packed.copy(), np.zeros((len(packed), 4))
    for place in (3, 2, 1, 0):
        small = largest != place
        magnitude = (left & 511) / 511 * np.sqrt(0.5)
        q[small, place] = np.where((left >> 9) & 1, -magnitude, magnitude)[small]
        left = np.where(small, left >> 10, left)
    q[np.arange(len(q)), largest] = np.sqrt(np.maximum(0.0, 1 - np.sum(q**2, axis=1)))
    return q[:, [3, 0, 1, 2]]


def large_frame_thrust_N(pwm, voltage_V):
    """Thrust per rotor of the neuralswarm frame: the published polynomial in gram-force."""
    x, b = pwm / 65536, voltage_V / 4.2
    return 1e-3 * G_MPS2 * (44.104 - 122.51 * x - 36.185 * b + 53.108 * x**2 + 107.68 * b * x)


def neuralswarm(path):
    table = packed_records(path.read_bytes())
    pick = lambda prefix, parts: np.column_stack([table[prefix + part] for part in parts])
    time_s = 1e-6 * (table["tick"] - table["tick"][0])
    q = upright(smallest_three(table["stateEstimateZ.quat"]))
    voltage = 1e-3 * pick("pm.", ["vbatMV"])
    thrust_N = large_frame_thrust_N(pick("pwm.", [f"m{i}_pwm" for i in (1, 2, 3, 4)]), voltage)
    # the estimate's acceleration is in the world frame with gravity; the rates' signs are those of the body frame
    streams = {POSITION: (time_s, 1e-3 * pick("stateEstimateZ.", "xyz")), VELOCITY: (time_s, 1e-3 * pick("stateEstimateZ.v", "xyz")),
               ATTITUDE: (time_s, q), RATE: (time_s, 1e-3 * pick("stateEstimateZ.rate", ("Roll", "Pitch", "Yaw"))),
               ACCELERATION: (time_s, rotate(conjugate(q), 1e-3 * pick("stateEstimateZ.a", "xyz"))),
               INPUT: (time_s, thrust_N), ("vbat",): changed(time_s, voltage)}
    return Recording(streams, {"actuator": "thrust", "hold": "unknown", "notes": "u is the published thrust of pwm and voltage"},
                     environment={"ground_z_m": 0.0})


# ---- the sets --------------------------------------------------------------------------------------------------------

IMRC_BARE = (("bare_01", "bare_12", "bare_17", "bare_22", "bare_35"), ("bare_08", "bare_26"))
IMRC_BRUSHED = (("brushed_02", "brushed_10"), ("brushed_03",))
# family -> set -> (converter, vehicle, (fit, holdout)); recordings without their ending
CONVERTED = {
    "imrc": {"bare": (lambda path: imrc(path, True), "imrc_brushless", IMRC_BARE),
             "bare_estimate": (lambda path: imrc(path, False), "imrc_brushless", IMRC_BARE),
             "brushed": (lambda path: imrc(path, True), "imrc_brushed", IMRC_BRUSHED),
             "brushed_estimate": (lambda path: imrc(path, False), "imrc_brushed", IMRC_BRUSHED)},
    "neurobem": {"lemniscate": (neurobem, "neurobem_racer", (("lemniscate_a",), ("lemniscate_b",)))},
    "neuralfly": {"tunnel": (neuralfly, "neuralfly_tunnel", (("NF_nowind", "L1_35wind", "NF-C_70wind", "indi_70wind", "NF-T_100wind"),
                                                             ("indi_nowind", "baseline_35wind", "L1_100wind")))},
    "neuralswarm": {"large": (neuralswarm, "neuralswarm_large", (("large_ground_01",), ("large_ground_02",)))},
}
# family -> set -> (fit, holdout), through scripts/import_log.py and the column map of the family's name
IMPORTED = {
    "nanodrone": {"train": (("train_random1_run1", "train_random2_run2", "train_multisine_run1", "train_square_run3"), ("train_random1_run2",))},
    "nanobench": {"fast": (("B2_circle_fast_rep2", "B3_figure8_fast_rep2"), ("B6_linear_ramp_rep2",))},
    "arpl": {"vertical": (("log10",), ()), "tilting": (("log15",), ())},
    "crazypad": {"cut_E8": (("normal_flight-E8_log00", "cut_propeller_M3_3mm_3mm_41mm-E8_log00"), ()),
                 "weight_E9": (("normal_flight-E9_log00", "add_weight_W3_near_M3-E9_log00"), ()),
                 "normal_E8": (("normal_flight-E8_log00", "normal_flight-E8_log01"), ()),
                 "normal_E9": (("normal_flight-E9_log00", "normal_flight-E9_log03"), ())},
}


def source_of(folder, name):
    """The published file of a recording's name (folder-name for crazypad)."""
    plain = lambda path: path.name.removesuffix(".gz").removesuffix(".csv")
    for path in sorted(folder.rglob("*")):
        if path.is_file() and name in (plain(path), f"{path.parent.name}-{plain(path)}"):
            return path
    raise SystemExit(f"families: {folder} has no recording {name}")


def convert_family(source, family, out):
    for set_name, (converter, vehicle, roles) in CONVERTED[family].items():
        shutil.copytree(HOME / "models" / vehicle, out / family / set_name / "vehicle", dirs_exist_ok=True)
        for role, names in zip(("fit", "holdout"), roles):
            for name in names:
                target = out / family / set_name / f"{role}_{name}.csv"
                write_flight(target, converter(source_of(source / family, name)), "vehicle/vehicle.toml")


def import_family(source, family, out):
    for set_name, roles in IMPORTED[family].items():
        for role, names in zip(("fit", "holdout"), roles):
            if not names:
                continue
            folder = out / family / set_name / role
            subprocess.run([sys.executable, HOME / "scripts" / "import_log.py", *(source_of(source / family, name) for name in names),
                            "--map", family, "--out", folder, "--keep-unusable"], check=True, stdout=subprocess.DEVNULL)
            for path in sorted(folder.glob("*_1.*")):
                path.rename(folder.parent / f"{role}_{path.name.replace('_1.', '.')}")
            (folder / "import.json").unlink()
            folder.rmdir()


def lay_out(source, out, only=()):
    """Every family that is in `source` under out/<family>/<set>/."""
    for family in [*CONVERTED, *IMPORTED]:
        if (source / family).is_dir() and (not only or family in only):
            (convert_family if family in CONVERTED else import_family)(source, family, out)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("flights", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only", default="", help="these families alone, comma-separated")
    options = parser.parse_args()
    lay_out(options.flights, options.out, [name for name in options.only.split(",") if name])


if __name__ == "__main__":
    main()
