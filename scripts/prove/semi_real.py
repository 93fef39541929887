#!/usr/bin/env python3
"""Real flights with one thing concealed and the truth known exactly: is it named, and nothing else?

    semi_real.py FLIGHTS --out DIR --gustlab BIN [--sets NAME,NAME] [--asked file|reference] [--times 2] [--limit N] [--jobs 2]
    semi_real.py FLIGHTS --out DIR --list                 the cases, and nothing else

FLIGHTS is what families.py wrote. Motion and air stay as they were recorded. What is concealed:
  file       the vehicle file is wrong (mass, centre of mass, inertia, thrust and torque coefficients)
  removed    the file has all that the untouched flights show, but one effect
  recording  a stream is wrong (pose late, gyroscope's scale, a turned attitude, a lever, one rotor's reading)
  input      the inputs are those that give the same motion with an effect in place (conceal_inputs.py)
  nothing    other parts of the flights, or more noise
Each is asked in two ways: against the vehicle file (what is named beyond the untouched flights), and with untouched flights
as --reference (exactly the effect, its size within 30 %). Its size is 1, 2 or 4 times its limit: the reporting tolerance or
five standard errors on these flights, whatever is more; over five standard errors by thirds of these flights it is counted once more. A finished diagnosis is kept. Writes DIR/truth.jsonl (one case a
line) and DIR/results.jsonl, prints Markdown.
"""

import argparse
import concurrent.futures
import json
import sys
import threading
import tomllib
from collections import Counter, defaultdict
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

import conceal_inputs as physics
from falsify import VehicleFolder
from flight_files import HOME, Log, read_log, read_vehicle, rotor_speed, sidecar_of, vehicle_path, write_log
from outcomes import means, rotor_of
from run_trials import run_measured
from semi_real_outcomes import judge, markdown, over_stated

TIMES = (2.0, 4.0, 1.0)
REMOVABLE = ("rotor_drag", "quadratic_drag", "motor_lag", "axial_inflow", "translational_lift", "flapping_torque", "ground_effect", "rotor_inertia")


@dataclass(frozen=True)
class FlightSet:
    """Parts (recording, from_s, to_s) of one family's flights; `latency_s`: input to thrust."""
    place: str
    reference: tuple
    new: tuple
    holdout: tuple
    latency_s: float = 0.0
    inputs: str = ""                      # "rotor": measured speeds are the inputs; "u": the commands alone
    # what these flights have by their authors, or by measurements that are no diagnosis (docs/DATA.md): true also where the untouched parts do not show it
    reported: tuple = ()


IMRC = ("rotor_drag", "flapping_torque", "rotor_inertia", "battery_sag", "motor_lag", "actuation_delay")
SETS = {
    "nanodrone": FlightSet("nanodrone/train", (("train_random1_run1", 0, 14), ("train_multisine_run1", 0, 14)),
                           (("train_random2_run2", 0, 14), ("train_multisine_run1", 15, 29)), (("train_random1_run2", 0, 14),)),
    "neurobem": FlightSet("neurobem/lemniscate", (("lemniscate_a", 0, 10), ("lemniscate_b", 0, 9)),
                          (("lemniscate_a", 12, 22), ("lemniscate_b", 9, 18)), (("lemniscate_a", 23, 33),),
                          reported=("rotor_drag", "flapping_torque", "translational_lift")),
    "neuralswarm": FlightSet("neuralswarm/large", (("large_ground_01", 2, 20), ("large_ground_02", 2, 20)),
                             (("large_ground_01", 22, 40), ("large_ground_02", 22, 40)), (("large_ground_01", 42, 60),), 0.055,
                             reported=("ground_effect", "motor_lag", "actuation_delay", "rotor_drag", "quadratic_drag")),
    "nanobench": FlightSet("nanobench/fast", (("B2_circle_fast_rep2", 0, 18), ("B3_figure8_fast_rep2", 0, 18)),
                           (("B2_circle_fast_rep2", 20, 38), ("B3_figure8_fast_rep2", 20, 38)), (("B6_linear_ramp_rep2", 0, 20),), 0.07,
                           reported=("rotor_drag", "motor_lag", "battery_sag")),
    "imrc_bare": FlightSet("imrc/bare", (("bare_01", 0, 9), ("bare_22", 0, 9)), (("bare_12", 0, 9), ("bare_17", 0, 9)), (("bare_26", 0, 9),), 0.0, "rotor", IMRC),
    "imrc_brushed": FlightSet("imrc/brushed", (("brushed_10", 0, 12),), (("brushed_02", 0, 9),), (("brushed_03", 0, 9),), 0.045, "u", IMRC),
    "neuralfly": FlightSet("neuralfly/tunnel", (("NF_nowind", 0, 24), ("L1_35wind", 0, 24), ("NF-C_70wind", 0, 24)),
                           (("NF_nowind", 25, 50), ("L1_35wind", 25, 50), ("NF-C_70wind", 25, 50)), (("indi_70wind", 0, 25),), 0.045,
                           reported=("rotor_drag", "quadratic_drag", "steady_wind", "constant_force")),
    "arpl": FlightSet("arpl/vertical", (("log10", 0, 9),), (("log10", 9, 22),), (("log10", 22, 30),), 0.075),
    "crazypad_E8": FlightSet("crazypad/normal_E8", (("normal_flight-E8_log00", 0, 999),), (("normal_flight-E8_log01", 0, 999),), ()),
    "crazypad_E9": FlightSet("crazypad/normal_E9", (("normal_flight-E9_log00", 0, 999),), (("normal_flight-E9_log03", 0, 999),), ()),
}


@dataclass
class Case:
    """One case and its exact truth. `parameters`: by how much the flights differ from what the file (or the reference) says."""
    name: str
    set: str
    way: str                              # file | removed | recording | input | nothing
    asked: str                            # file | reference
    effect: str | None = None
    parameters: dict = field(default_factory=dict)
    rotor: int | None = None
    times: float = 0.0                    # of the limit
    limit: float = 0.0                    # of the leading parameter
    seed: int = 0

    @property
    def truth(self):
        """What must be named: a file that is wrong for both kinds of flights is no change."""
        return None if self.effect is None or (self.way == "file" and self.asked == "reference") else self.effect


# ---- parts of recordings ----------------------------------------------------------------------------------------------

def part(log, from_s, to_s):
    time_s = log.column["time_s"] - log.column["time_s"][0]
    keep = (time_s >= from_s) & (time_s <= to_s)
    return Log(log.name, log.meta, {name: values[keep] for name, values in log.column.items()})


def pieces_of(log, number):
    """The log in so many pieces of the same duration."""
    duration_s = log.column["time_s"][-1] - log.column["time_s"][0]
    return [part(log, k * duration_s / number, (k + 1) * duration_s / number) for k in range(number)] if number > 1 else [log]


def with_inputs(log, choice):
    """The log with measured speeds as inputs, or without them."""
    column, meta = dict(log.column), dict(log.meta)
    rotors = [name for name in column if name.startswith("rotor")]
    if choice == "rotor":
        for name in rotors:
            column["u" + name[5:]] = column[name]
        meta["actuator"], meta["hold"] = "rotor_speed", "linear"
    for name in rotors if choice else ():
        del column[name]
    return Log(log.name, meta, column)


class Recordings:
    """The parts of one set and its vehicle, each read once."""

    def __init__(self, flights, flight_set):
        self.set, self.folder, self.read = flight_set, flights / flight_set.place, {}
        first = next(self.folder.glob("*.meta.toml"))
        name = tomllib.loads(first.read_text(encoding="utf-8"))["vehicle"]
        self.vehicle_file = vehicle_path(name, first.parent)
        self.vehicle = read_vehicle(self.vehicle_file)

    def log(self, entry):
        name, from_s, to_s = entry
        if entry not in self.read:
            path = next(p for p in sorted(self.folder.glob("*.csv*")) if p.name.split("_", 1)[1].removesuffix(".gz").removesuffix(".csv") == name)
            log = with_inputs(part(read_log(path), from_s, to_s), self.set.inputs)
            self.read[entry] = log
        return self.read[entry]

    def has_rates(self):
        return self.log(self.set.new[0]).stack("wx") is not None

    def inputs(self, log):
        """(names, rows, time_s (n,), inputs (n, k))."""
        names = [f"u{i + 1}" for i in range(len(self.vehicle.thrust)) if f"u{i + 1}" in log.column]
        rows = np.all(np.isfinite(log.stack(*names)), axis=1)
        return names, rows, log.column["time_s"][rows], log.stack(*names)[rows]

    def motion(self, log):
        """(motion when the thrust acts, thrusts that the file gives to the inputs)."""
        _, _, time_s, inputs = self.inputs(log)
        motion = physics.motion_at(log, self.vehicle, time_s + self.set.latency_s)
        motion.time_s = time_s
        return motion, physics.thrust_of(inputs, log.meta["actuator"], self.vehicle)


LAG_BAND_HZ = 60.0           # of measured speeds beyond it a lag would make noise alone, and no motion answers


# ---- what is concealed in a recording -----------------------------------------------------------------------------------

def felt_away(log, time_s, arm):
    """What an accelerometer at `arm` (3,) [m] feels beside one at the origin, m/s², (n, 3): rates below 15 Hz."""
    rates = physics.even(physics.stream(log, "wx", "wy", "wz"), 15)
    w, turn = rates(time_s), rates.derivative()(time_s)
    return np.cross(turn, arm) + np.cross(w, np.cross(w, arm))


def seen_away(log, arm):
    """The log of the same flight whose origin is at `arm` (3,) [m] of the body."""
    column, time_s = dict(log.column), log.column["time_s"]
    more = {"a": felt_away(log, time_s, arm)}
    if physics.stream(log, "qx", "qy", "qz", "qw") is not None:
        turn = Rotation.from_quat(physics.even(attitude_samples(log), 20)(time_s))
        more["p"], more["v"] = turn.apply(arm), turn.apply(np.cross(physics.even(physics.stream(log, "wx", "wy", "wz"), 15)(time_s), arm))
    for names, values in more.items():
        for k, axis in enumerate("xyz"):
            if names + axis in column:
                column[names + axis] = column[names + axis] + values[:, k]
    return Log(log.name, log.meta, column)


def attitude_samples(log):
    """(time_s, quaternions (n, 4)) without changes of sign."""
    time_s, q = physics.stream(log, "qx", "qy", "qz", "qw")
    return time_s, q * np.cumprod(np.r_[1.0, np.where(np.sum(q[1:] * q[:-1], axis=1) < 0, -1.0, 1.0)])[:, None]


def change_inputs(log, recordings, effect, values):
    """The log with the inputs that give the same motion with the effect in place. Rotors push along z only, so that no origin can keep its
    motion about another centre of mass: there the centre of mass keeps it, and the log is that of an origin beside it."""
    names, rows, time_s, inputs = recordings.inputs(log)
    if effect in physics.LATENCY:
        curve = CubicSpline(time_s, inputs) if effect == "actuation_delay" else physics.even((time_s, inputs), LAG_BAND_HZ)
        changed = curve(np.minimum(time_s + values["delay"], time_s[-1])) if effect == "actuation_delay" \
            else curve(time_s) + values["time_constant"] * curve.derivative()(time_s)
    else:
        motion, thrust = recordings.motion(log)
        changed = physics.inputs_of(physics.thrusts_with(recordings.vehicle, motion, thrust, effect, values), log.meta["actuator"], recordings.vehicle)
    column = dict(log.column)
    for k, name in enumerate(names):
        column[name] = column[name].copy()
        column[name][rows] = changed[:, k]
    changed = Log(log.name, log.meta, column)
    return seen_away(changed, -np.array([values.get(axis, 0.0) for axis in "xyz"])) if effect == "center_of_mass" else changed


def change_recording(log, effect, values, rotor):
    """The log as sensors with this fault would have recorded the same flight."""
    column, time_s = dict(log.column), log.column["time_s"]
    q = log.stack("qx", "qy", "qz", "qw")
    if effect == "pose_delay":
        for names in (("px", "py", "pz"), ("vx", "vy", "vz"), ("qx", "qy", "qz", "qw")):
            if (samples := physics.stream(log, *names)) is None:
                continue
            values_at = attitude_samples(log)[1] if len(names) == 4 else samples[1]
            late = CubicSpline(samples[0], values_at)(np.maximum(samples[0] - values["delay"], samples[0][0]))
            late = late / np.linalg.norm(late, axis=1, keepdims=True) if len(names) == 4 else late
            for k, name in enumerate(names):
                column[name] = np.full(len(time_s), np.nan)
                column[name][np.isfinite(log.column[name])] = late[:, k]
    elif effect == "gyro_scale":
        for name in ("wx", "wy", "wz"):
            column[name] = column[name] * (1 + values["delta"])
    elif effect in ("attitude_offset", "yaw_offset"):
        rows = np.isfinite(q).all(axis=1)
        turned = (Rotation.from_quat(q[rows]) * Rotation.from_rotvec([values.get(axis, 0.0) for axis in "xyz"])).as_quat()
        turned *= np.where(np.sum(turned * q[rows], axis=1) < 0, -1.0, 1.0)[:, None]
        for k, name in enumerate(("qx", "qy", "qz", "qw")):
            column[name] = column[name].copy()
            column[name][rows] = turned[:, k]
    elif effect == "imu_lever":
        rows = np.isfinite(column["ax"])
        more = felt_away(log, time_s[rows], np.array([values.get(axis, 0.0) for axis in "xyz"]))
        for k, name in enumerate(("ax", "ay", "az")):
            column[name] = column[name].copy()
            column[name][rows] += more[:, k]
    elif effect == "rotor_loss":
        # the reading of one rotor is wrong by this much thrust: in a log of speeds, by its root
        column[f"u{rotor}"] = column[f"u{rotor}"] / np.sqrt(1 - values["loss"])
    return Log(log.name, log.meta, column)


def more_noise(log, seed):
    """Half of the recording's own noise again, on motion and inertial data (robust third differences)."""
    rng, column = np.random.default_rng(seed), dict(log.column)
    for name in ("px", "py", "pz", "vx", "vy", "vz", "wx", "wy", "wz", "ax", "ay", "az"):
        if name in column:
            rows = np.isfinite(column[name])
            sigma = np.median(np.abs(np.diff(column[name][rows], 3))) / (0.6745 * np.sqrt(20))
            column[name] = column[name].copy()
            column[name][rows] += 0.5 * sigma * rng.standard_normal(rows.sum())
    return Log(log.name, log.meta, column)


def falsify_file(file, effect, values, rotor):
    """Makes the vehicle file wrong, so that the real vehicle differs from it by `values`."""
    number = lambda name: values.get(name, 0.0)
    if effect == "mass":
        file.scale_inertial("mass", 1 / (1 + number("delta")))
    elif effect == "center_of_mass":
        file.move_center([-number(axis) for axis in "xyz"])
    elif effect == "inertia":
        file.scale_inertial("diaginertia", 1 / (1 + number("delta_x")))
    elif effect == "thrust_scale":
        file.table["thrust"]["coefficient"] /= 1 + number("delta")
        if "pwm_thrust" in file.table.get("actuator", {}):
            file.table["actuator"]["pwm_thrust"] = [c / (1 + number("delta")) for c in file.table["actuator"]["pwm_thrust"]]
    elif effect == "rotor_loss":
        file.table["rotor"][rotor - 1]["coefficient"] = file.table["thrust"]["coefficient"] / (1 - number("loss"))
    elif effect == "yaw_torque_ratio":
        file.table["thrust"]["torque_ratio"] /= 1 + number("delta")


# ---- the cases --------------------------------------------------------------------------------------------------------

def units(effect, vehicle, rotor, sign, has_voltage):
    """{parameter: value} of an effect of size one in its leading parameter (the first)."""
    return {"thrust_scale": {"delta": sign}, "mass": {"delta": sign}, "rotor_loss": {"loss": 1.0, "rotor": rotor}, "thrust_curve": {"curvature": sign},
            "battery_sag": {"exponent": 1.0} if has_voltage else {"rate": 1.0}, "axial_inflow": {"at_hover": 1.0},
            "translational_lift": {"coefficient": 1.0}, "ground_effect": {"strength": 1.0}, "yaw_torque_ratio": {"delta": sign},
            "center_of_mass": {"x" if rotor % 2 else "y": sign}, "inertia": dict.fromkeys(("delta_x", "delta_y", "delta_z"), sign),
            "motor_lag": {"time_constant": 1.0, "time_constant_down": 1.0}, "actuation_delay": {"delay": 1.0}, "pose_delay": {"delay": 1.0},
            "gyro_scale": {"delta": sign}, "attitude_offset": {"x" if rotor % 2 else "y": sign}, "yaw_offset": {"z": sign}, "imu_lever": {"x" if rotor % 2 else "y": sign}}[effect]


# sensors' faults without a reporting tolerance, and bounds beyond which a size is no longer this effect
SENSOR_LIMIT = {"attitude_offset": 0.01, "yaw_offset": 0.02, "imu_lever": 0.005}
MOST = {"mass": 0.25, "thrust_scale": 0.25, "rotor_loss": 0.35, "thrust_curve": 0.4, "inertia": 0.5, "yaw_torque_ratio": 0.6, "battery_sag": 4.0,
        "motor_lag": 0.04, "actuation_delay": 0.04, "pose_delay": 0.04, "gyro_scale": 0.2, "ground_effect": 20.0,
        "attitude_offset": 0.2, "yaw_offset": 0.35, "imu_lever": 0.1}
MOST_PER_KG = {"axial_inflow": 2.0, "translational_lift": 0.1}
# what the untouched flights show of it already gets larger, never smaller: what is asked is the total
SIGNED = ("thrust_scale", "mass", "center_of_mass", "gyro_scale")


def possible(recordings):
    """{way: effects} that this set can conceal."""
    log = recordings.log(recordings.set.new[0])
    has = lambda *names: all(name in log.column and np.isfinite(log.column[name]).any() for name in names)
    actuator, full = log.meta["actuator"], len(recordings.inputs(log)[0]) > 1
    if not has("wx"):
        return {"file": ["rotor_loss"], "recording": [], "input": ["rotor_loss"]}
    inputs = ["thrust_scale", "thrust_curve"]
    if full:
        inputs += ["rotor_loss", "center_of_mass", "inertia", "yaw_torque_ratio", "actuation_delay"]
    if has("px", "qw"):
        inputs += ["axial_inflow", "translational_lift"] + (["ground_effect"] if "ground_z_m" in log.meta.get("environment", {}) else [])
    if actuator != "rotor_speed" and has("vbat") and recordings.vehicle.voltage > 0:
        inputs += ["battery_sag"]
    if actuator == "rotor_speed" and not has("vbat"):
        inputs += ["battery_sag"]
    if actuator == "rotor_speed":
        inputs += ["motor_lag"]
    file = ["mass", "thrust_scale"] if actuator != "thrust" and actuator != "collective_thrust" else ["mass"]
    if full:
        file += ["center_of_mass", "inertia", "yaw_torque_ratio"] + (["rotor_loss"] if actuator == "rotor_speed" else [])
    recording = ["gyro_scale", "pose_delay", "attitude_offset", "yaw_offset"] if has("qw") else []
    if has("qw", "ax"):
        recording += ["imu_lever"]
    if full and actuator == "rotor_speed":
        recording += ["rotor_loss"]
    return {"file": file, "recording": recording, "input": inputs}


def shown(recordings, effect, values, pieces=1):
    """[(size, weight)] of an effect that each untouched flight, or each of so many pieces of it, shows by itself, in units of `values`; empty where
    that is not asked."""
    entries = recordings.set.new + recordings.set.reference + recordings.set.holdout
    logs = [piece for entry in entries for piece in pieces_of(recordings.log(entry), pieces)]
    if effect in physics.SEEN_BY_SENSORS:
        axis, unit = next(iter(values.items()))
        sizes = [(physics.SEEN_BY_SENSORS[effect](log, recordings.vehicle, axis) / unit, 1.0) for log in logs]
    else:
        sizes = physics.sizes_shown(recordings.vehicle, [recordings.motion(log) for log in logs], effect, values)
    return [size for size in sizes if np.isfinite(size).all()]


def mean_shown(recordings, effect, values):
    """Mean of the sizes that the untouched flights show, in units of `values`; 0 where that is not asked."""
    return np.mean([size for size, _ in shown(recordings, effect, values)] or [0.0])


def hover_difference(recordings):
    """By how much the mean thrusts of the rotors in hover, as shares of their mean, differ between two untouched flights (rms)."""
    thrusts = [recordings.motion(recordings.log(entry))[1].mean(axis=0) for entry in recordings.set.new + recordings.set.reference]
    return float(np.sqrt(2 * np.var([t / t.mean() for t in thrusts], axis=0, ddof=1).mean()))


def small_of(effect, values):
    """(size, the values at it), small enough that all grows in proportion."""
    natural = 1e-3 if effect in ("center_of_mass", "translational_lift") else 0.01
    return natural, {name: value if name == "rotor" else natural * value for name, value in values.items()}


def sides(recordings, asked):
    """The flights whose errors count: the new ones, and beside reference flights those, too."""
    return (recordings.set.new, recordings.set.reference)[: 1 if asked == "file" else 2]


def limit_of(recordings, effect, values, asked):
    """The larger of the tolerance and five standard errors on the new flights, in the leading parameter; beside reference flights, of the
    difference to those. Flights that differ among themselves tell no more than their spread allows."""
    vehicle = recordings.vehicle
    tolerance = physics.TOLERANCE.get(effect, SENSOR_LIMIT.get(effect, 0.0)) * (vehicle.arm if effect == "center_of_mass" else 1.0)
    if not recordings.has_rates():
        return 5 * hover_difference(recordings)
    natural, small = small_of(effect, values)
    spread, variance = natural * physics.spread(shown(recordings, effect, small)), 0.0
    for entries in sides(recordings, asked):
        variance += spread**2 / len(entries)
        if effect not in physics.SEEN_BY_SENSORS:
            flights = [recordings.motion(recordings.log(entry)) for entry in entries]
            variance += (natural * physics.standard_error(vehicle, flights, effect, small)) ** 2
    return max(tolerance, 5 * float(np.sqrt(variance)))


def limit_of_thirds(recordings, effect, values, asked):
    """Five standard errors by how much thirds of the flights differ: what flights that differ within themselves more than among themselves tell."""
    natural, small = small_of(effect, values)
    share = sum(1 / (3 * len(entries)) for entries in sides(recordings, asked))
    return 5 * natural * physics.spread(shown(recordings, effect, small, pieces=3)) * float(np.sqrt(share))


def in_range(log, recordings, effect, values):
    """Whether there are inputs that conceal the effect, and this actuator takes them."""
    if effect not in physics.LATENCY and not physics.conceals(recordings.vehicle, *recordings.motion(log), effect, values):
        return False
    changed = recordings.inputs(change_inputs(log, recordings, effect, values))[3]
    return log.meta["actuator"] != "pwm" or bool(np.all((changed >= 0) & (changed <= 65535)))


def cases_of(name, recordings):
    """Every case of one set, the middle size first."""
    cases, number = [], 0
    voltage = np.isfinite(recordings.log(recordings.set.new[0]).column.get("vbat", np.array([np.nan]))).any()
    for way, effects in possible(recordings).items():
        for effect in effects:
            number += 1
            rotor, sign = 1 + number % len(recordings.vehicle.thrust), 1.0 if number % 2 else -1.0
            unit = units(effect, recordings.vehicle, rotor, sign, voltage)
            if effect in SIGNED and recordings.has_rates() and mean_shown(recordings, effect, unit) < 0:
                unit = units(effect, recordings.vehicle, rotor, -sign, voltage)
            # a gyroscope that is later than the pose would take a late pose back
            if effect == "pose_delay" and mean_shown(recordings, effect, unit) < -0.5 * physics.TOLERANCE[effect]:
                continue
            if way == "recording" and effect == "rotor_loss":
                unit = {"loss": -1.0, "rotor": rotor}
            most = MOST.get(effect, MOST_PER_KG.get(effect, np.inf) * recordings.vehicle.mass)
            for asked in ("file", "reference"):
                limit = limit_of(recordings, effect, unit, asked)
                for times in (times for times in TIMES if times * limit <= most):
                    size = times * limit
                    parameters = {key: value if key == "rotor" else size * value for key, value in unit.items()}
                    logs = [recordings.log(entry) for entry in recordings.set.new + recordings.set.holdout] if way == "input" else []
                    if all(in_range(log, recordings, effect, parameters) for log in logs):
                        cases.append(Case(f"{way}_{effect}_x{times:g}_{asked}", name, way, asked, effect, parameters,
                                          rotor if effect == "rotor_loss" else None, times, limit))
    cases += [Case(f"noise_{seed}_file", name, "nothing", "file", seed=seed) for seed in (1, 2)]
    cases += [Case(f"{what}_reference", name, "nothing", "reference", seed=seed) for what, seed in (("untouched", 0), ("noise_1", 1), ("exchanged", 2))]
    return cases


def table(flights, sets):
    """Cases of all sets, mixed evenly: any first part is a sample of every set, the size twice the limit first."""
    lists = [cases_of(name, Recordings(flights, SETS[name])) for name in sets if (flights / SETS[name].place).is_dir()]
    place = {id(case): (TIMES.index(case.times) if case.times else 0, (k + 0.5) / len(cases)) for cases in lists for k, case in enumerate(
        sorted(cases, key=lambda c: (c.name.split("_x")[0][::-1], c.asked)))}
    return sorted((case for cases in lists for case in cases), key=lambda case: (place[id(case)], case.set, case.name))


# ---- building and asking ------------------------------------------------------------------------------------------------

def concealed(case, log, recordings, index):
    if case.way == "input":
        return change_inputs(log, recordings, case.effect, case.parameters)
    if case.way == "recording":
        return change_recording(log, case.effect, case.parameters, case.rotor)
    return more_noise(log, 100 * case.seed + index) if case.way == "nothing" and case.name.startswith("noise") else log


def build(case, recordings, folder, found=None):
    """Writes DIR/<role>_N.csv, the vehicle (with what a diagnosis found) beside them, and truth.json."""
    file = VehicleFolder(recordings.vehicle_file)
    if found is not None:
        file.add_found(found)
    if case.way == "removed":
        file.remove(case.effect)
    if case.way == "file":
        falsify_file(file, case.effect, case.parameters, case.rotor)
    file.write(folder / "vehicle")
    roles = {"reference": recordings.set.reference, "fit": recordings.set.new, "holdout": recordings.set.holdout}
    if case.name.startswith("exchanged"):
        roles["reference"], roles["fit"] = roles["fit"], roles["reference"]
    # without angular rates only the balance against another flight is left
    if case.asked == "file" and not recordings.has_rates():
        roles["fit"] = roles["reference"] + roles["fit"]
    for role, entries in roles.items():
        for index, entry in enumerate(entries):
            if role == "reference" and case.asked == "file":
                continue
            log = recordings.log(entry)
            if role != "reference" and not (entry in recordings.set.reference and role == "fit" and case.asked == "file"):
                log = concealed(case, log, recordings, index)
            write_log(folder / f"{role}_{index + 1}.csv", log, "vehicle/vehicle.toml")
    (folder / "truth.json").write_text(json.dumps({**asdict(case), "truth": case.truth}) + "\n", encoding="utf-8")


def ask(folder, gustlab, seconds):
    """The diagnosis of a built case; a finished one, or one that failed, is kept."""
    out, run = folder / "diagnosis", folder / "run.json"
    if not run.exists():
        files = lambda role: sorted(map(str, folder.glob(f"{role}_*.csv")))
        option = lambda role: [text for path in files(role) for text in (f"--{role}", path)]
        command = ["nice", "-n", "4", "timeout", str(seconds), gustlab, "diagnose", *files("fit"), *option("holdout"), *option("reference"),
                   "--out", str(out), "--jobs", "1"]
        figures = run_measured(command, folder / "messages.txt")
        run.write_text(json.dumps(figures) + "\n", encoding="utf-8")
        for path in folder.glob("*.csv"):
            path.unlink()
    path = out / "diagnosis.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None


# ---- sizes -------------------------------------------------------------------------------------------------------------

def totals(diagnosis, effect, rotor, file):
    """{parameter: value} of an effect against the file: as named, as trimmed, or as the file has it."""
    for found in diagnosis["effects"] + diagnosis.get("suspected", []) + diagnosis.get("calibration", []):
        if found["effect"] == effect and rotor in (None, rotor_of(found)):
            return {name: number["value"] for name, number in found["parameters"].items()}
    own = file.effect(effect) or {}
    return {name: value for name, value in own.items() if isinstance(value, float)}


def sizes_before(base, case, recordings):
    """{parameter: value} of what is concealed, in the untouched flights against the file: as named there, or, where an equal of it is named (a
    mass for a thrust scale), as their own equation error shows it."""
    there = [effect for effect in base["effects"] if means(effect, case.effect, case.rotor)]
    sizes = []
    if there and all(effect["effect"] != case.effect for effect in there) and case.effect not in physics.SEEN_BY_SENSORS:
        motions = [recordings.motion(recordings.log(entry)) for entry in recordings.set.new]
        small = {name: value if name == "rotor" else 0.01 * value for name, value in case.parameters.items()}
        sizes = physics.sizes_shown(recordings.vehicle, motions, case.effect, small)
    if not sizes:
        return totals(base, case.effect, case.rotor, VehicleFolder(recordings.vehicle_file))
    size, weight = np.array(sizes).T
    return {name: 0.01 * value * float(np.average(size, weights=weight)) for name, value in case.parameters.items() if name != "rotor"}


# ---- all of it ------------------------------------------------------------------------------------------------------------

class Bench:
    """Builds and asks the cases of all sets; keeps what is finished."""

    def __init__(self, flights, out, gustlab, seconds):
        self.flights, self.out, self.gustlab, self.seconds, self.recordings = flights, out, gustlab, seconds, {}
        self.locks = defaultdict(threading.Lock)

    def of(self, name):
        return self.recordings.setdefault(name, Recordings(self.flights, SETS[name]))

    def diagnosis(self, case, found=None):
        folder = self.out / case.set / case.name
        with self.locks[folder]:
            if not (folder / "run.json").exists():
                build(case, self.of(case.set), folder, found)
            return ask(folder, self.gustlab, self.seconds)

    def base(self, name, asked="file"):
        return self.diagnosis(Case(f"untouched_{asked}", name, "nothing", asked))

    def removals(self, name):
        """One case for each effect that the untouched flights show and a vehicle file can hold."""
        base = self.base(name)
        return [Case(f"removed_{effect['effect']}", name, "removed", "file", effect["effect"],
                     {key: number["value"] for key, number in effect["parameters"].items()}, None, 1.0)
                for effect in (base["effects"] if base else []) if effect["effect"] in REMOVABLE]

    def row(self, case):
        base = self.base(case.set)
        shown = base if case.way == "removed" else None
        if shown is not None:
            base = self.diagnosis(Case("complete_file", case.set, "nothing", "file"), shown)
        found = self.diagnosis(case, shown)
        if found is None or (case.asked == "file" and base is None):
            return {"case": case.name, "set": case.set, "way": case.way, "asked": case.asked, "truth": case.truth, "times": case.times, "outcome": "failed"}
        from_file = base and case.effect and shown is None and case.asked == "file"
        before = sizes_before(base, case, self.of(case.set)) if from_file else {}
        row = judge(case, found, base, before, SETS[case.set].reported)
        if case.truth and case.limit and self.of(case.set).has_rates():
            unit = {name: value if name == "rotor" else value / (case.times * case.limit) for name, value in case.parameters.items()}
            row["over_thirds"] = case.times * case.limit / max(case.limit, limit_of_thirds(self.of(case.set), case.effect, unit, case.asked))
        if case.truth and shown is None and (untouched := base if case.asked == "file" else self.base(case.set, case.asked)):
            row["over_stated"] = over_stated(case, untouched)
        return row


def run(flights, out, gustlab, jobs, chosen, seconds=600, removals=True):
    """Rows of the chosen cases, in their order; also DIR/truth.jsonl and DIR/results.jsonl."""
    bench, rows = Bench(flights, out, gustlab, seconds), []
    out.mkdir(parents=True, exist_ok=True)
    if removals:
        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            chosen = chosen + sum(pool.map(bench.removals, sorted({case.set for case in chosen if case.asked == "file"})), [])
    (out / "truth.jsonl").write_text("".join(json.dumps({**asdict(case), "truth": case.truth}) + "\n" for case in chosen), encoding="utf-8")
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for row in pool.map(bench.row, chosen):
            rows.append(row)
            print(f"[{len(rows)}/{len(chosen)}] {row['set']} {row['case']}: {row['outcome']}", file=sys.stderr, flush=True)
    (out / "results.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="utf-8")
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("flights", type=Path)
    parser.add_argument("--gustlab", default=str(HOME / "build/release/gustlab"))
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--sets", default=",".join(SETS))
    parser.add_argument("--asked", choices=["file", "reference"])
    parser.add_argument("--way", choices=["file", "recording", "input", "nothing"])
    parser.add_argument("--times", type=float, help="only this size, and what conceals nothing")
    parser.add_argument("--limit", type=int, help="only this many cases; they are mixed evenly")
    parser.add_argument("--seconds", type=int, default=600, help="a diagnosis that takes longer has failed")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--list", action="store_true")
    options = parser.parse_args()
    cases = [case for case in table(options.flights, options.sets.split(",")) if options.asked in (None, case.asked)
             and options.way in (None, case.way) and options.times in (None, case.times or options.times)][:options.limit]
    if options.list:
        for case in cases:
            print(json.dumps({**asdict(case), "truth": case.truth}))
        print(len(cases), "cases", Counter(case.set for case in cases), file=sys.stderr)
        return
    sys.stdout.write(markdown(run(options.flights, options.out, options.gustlab, options.jobs, cases, options.seconds,
                                  options.way is None)))


if __name__ == "__main__":
    main()
