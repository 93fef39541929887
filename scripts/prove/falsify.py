"""Vehicle folders that are wrong on purpose, and logs whose pose is late on purpose."""

import csv
import gzip
import io
import json
import re
import shutil
import tomllib
import xml.etree.ElementTree as xml
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from flight_files import sidecar_of

# what is one value per flight, or no physics of the vehicle, does not go into a vehicle file
NOT_OF_THE_VEHICLE = {"steady_wind", "constant_force", "gust", "measurement_noise"}


def toml_value(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml_value(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    return json.dumps(value) if isinstance(value, (str, bool)) else repr(value)


def vehicle_text(table):
    """A vehicle.toml that reads back as `table`."""
    lines = [f"{key} = {toml_value(value)}" for key, value in table.items() if not isinstance(value, (dict, list))]
    for key, value in table.items():
        if isinstance(value, dict):
            lines += [f"[{key}]"] + [f"{name} = {toml_value(item)}" for name, item in value.items()]
        elif isinstance(value, list):
            for entry in value:
                lines += [f"[[{key}]]"] + [f"{name} = {toml_value(item)}" for name, item in entry.items()]
    return "\n".join(lines) + "\n"


class VehicleFolder:
    """A vehicle as two documents that can be changed and written elsewhere."""

    def __init__(self, path):
        path = Path(path)
        self.table = tomllib.loads(path.read_text(encoding="utf-8"))
        self.mjcf = xml.parse(path.parent / self.table["mjcf"])

    @property
    def inertial(self):
        return next(body.find("inertial") for body in self.mjcf.getroot().iter("body") if body.find("inertial") is not None)

    def effect(self, name):
        return next((e for e in self.table.get("effect", []) if e["type"] == name), None)

    def add_found(self, diagnosis):
        """Puts what a diagnosis found (totals, calibration and turning directions included) into the vehicle."""
        if any(f["kind"] == "sign" and f["column"] == "rotor.direction" for f in diagnosis["log_findings"]):
            for rotor in self.table["rotor"]:
                rotor["direction"] = "cw" if rotor["direction"] == "ccw" else "ccw"
        for found in diagnosis["effects"] + diagnosis.get("calibration", []):
            if found["effect"] in NOT_OF_THE_VEHICLE:
                continue
            entry = {"type": found["effect"]}
            for name, number in found["parameters"].items():
                entry[name] = int(number["value"]) if name == "rotor" else number["value"]
            same = lambda old: old["type"] == entry["type"] and old.get("rotor") == entry.get("rotor")
            self.table["effect"] = [old for old in self.table.get("effect", []) if not same(old)] + [entry]

    def scale_inertial(self, attribute, factor):
        numbers = [factor * float(x) for x in self.inertial.get(attribute).split()]
        self.inertial.set(attribute, " ".join(repr(x) for x in numbers))

    def move_center(self, by):
        position = [float(x) for x in self.inertial.get("pos", "0 0 0").split()]
        self.inertial.set("pos", " ".join(repr(x + d) for x, d in zip(position, by)))

    def write(self, folder):
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "vehicle.toml").write_text(vehicle_text(self.table), encoding="utf-8")
        self.mjcf.write(folder / self.table["mjcf"], encoding="unicode")


@dataclass(frozen=True)
class Falsification:
    """One thing that is wrong on purpose: what it does to the vehicle or the log, and what must then be named."""
    effect: str
    totals: dict                          # parameter → its total against the wrong file, from that against the right one
    change: Callable = lambda vehicle: None
    rotor: int | None = None
    pose_delay_s: float = 0.0


def falsifications(vehicle):
    """{case: Falsification} of what this vehicle allows; drag and lag only where it has them."""
    same = lambda total: total
    scaled = lambda by: lambda delta: (1 + delta) / by - 1
    cases = {}
    for percent in (-10, 10):
        by = 1 + percent / 100
        cases[f"mass_{percent:+}%"] = Falsification("mass", {"delta": scaled(by)}, lambda v, by=by: v.scale_inertial("mass", by))
    for axis, by_m in (("x", 0.002), ("y", -0.002)):
        move = [by_m if axis == own else 0.0 for own in "xyz"]
        totals = {own: lambda total, d=d: total - d for own, d in zip("xyz", move)}
        cases[f"center_of_mass_{axis}_{1e3 * by_m:+g}mm"] = Falsification("center_of_mass", totals, lambda v, move=move: v.move_center(move))
    cases["inertia_-25%"] = Falsification("inertia", dict.fromkeys(("delta_x", "delta_y", "delta_z"), scaled(0.75)),
                                          lambda v: v.scale_inertial("diaginertia", 0.75))
    for rotor in range(1, len(vehicle.table["rotor"]) + 1):
        stronger = lambda v, rotor=rotor: v.table["rotor"][rotor - 1].update(coefficient=1.08 * v.table["thrust"]["coefficient"])
        cases[f"rotor_{rotor}_+8%"] = Falsification("rotor_loss", {"loss": lambda loss: 1 - (1 - loss) / 1.08}, stronger, rotor)
    for name in ("rotor_drag", "motor_lag"):
        own = vehicle.effect(name)
        if own is None:
            continue
        numbers = {key: value for key, value in own.items() if isinstance(value, float)}
        totals = dict.fromkeys(numbers, same)

        def remove(v, name=name):
            v.table["effect"] = [e for e in v.table["effect"] if e["type"] != name]

        def halve(v, name=name, numbers=numbers):
            v.effect(name).update({key: 0.5 * value for key, value in numbers.items()})
        cases[f"{name}_removed"] = Falsification(name, totals, remove)
        cases[f"{name}_halved"] = Falsification(name, totals, halve)
    cases["pose_15ms_late"] = Falsification("pose_delay", {"delay": lambda total: total + 0.015}, pose_delay_s=0.015)
    return cases


def copy_log(source, target, vehicle, pose_delay_s=0.0):
    """Copies a log and its sidecar, which then names `vehicle`; pose and velocity late by pose_delay_s."""
    source, target = Path(source), Path(target)
    target.parent.mkdir(parents=True, exist_ok=True)
    sidecar = re.sub(r'(?m)^vehicle *=.*$', f'vehicle = "{vehicle}"', sidecar_of(source).read_text(encoding="utf-8"), count=1)
    sidecar_of(target).write_text(sidecar, encoding="utf-8")
    if pose_delay_s == 0.0:
        shutil.copyfile(source, target)
        return
    with (gzip.open if source.suffix == ".gz" else open)(source, "rt", encoding="utf-8") as file:
        names, *rows = csv.reader(file)
    time = np.array([float(row[0]) for row in rows])
    late = np.maximum(time - pose_delay_s, time[0])
    for k, name in enumerate(names):
        if not re.fullmatch(r"p[xyz]|v[xyz]|q[wxyz]", name):
            continue
        cells = np.array([float(row[k]) if row[k] else np.nan for row in rows])
        known = np.isfinite(cells)
        moved = CubicSpline(time[known], cells[known])(late)
        for row, value, wanted in zip(rows, moved, known):
            row[k] = f"{value:.9g}" if wanted else ""
    quaternion = [names.index(q) for q in ("qw", "qx", "qy", "qz") if q in names]
    for row in rows:
        if len(quaternion) == 4 and all(row[k] for k in quaternion):
            q = np.array([float(row[k]) for k in quaternion])
            for k, value in zip(quaternion, q / np.linalg.norm(q)):
                row[k] = f"{value:.9g}"
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([names, *rows])
    data = text.getvalue().encode("utf-8")
    target.write_bytes(gzip.compress(data, mtime=0) if target.suffix == ".gz" else data)
