"""Reads and writes flight logs (CSV with sidecar), reads vehicles (TOML with MJCF), for the proof; FORMATS.md of the project."""

import gzip
import json
import tomllib
import xml.etree.ElementTree as xml
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

HOME = Path(__file__).resolve().parents[2]


@dataclass
class Vehicle:
    name: str
    mass: float                 # kg
    inertia: np.ndarray         # kg m², diagonal
    center: np.ndarray          # m, of mass, from the body's origin
    hub: np.ndarray             # m, (N, 3), from the centre of mass
    direction: np.ndarray       # +1: counter-clockwise seen from above
    thrust: np.ndarray          # N/(rad/s)², per rotor
    torque_ratio: float         # m
    radius: float               # m
    voltage: float              # V, nominal; 0: unknown
    pwm: dict | None
    pwm_thrust: list | None
    effects: list = field(default_factory=list)

    @property
    def weight(self):
        return 9.81 * self.mass

    @property
    def hover_speed(self):
        return np.sqrt(self.weight / self.thrust.sum())

    @property
    def arm(self):
        return np.hypot(self.hub[:, 0], self.hub[:, 1]).mean()


@dataclass
class Log:
    name: str
    meta: dict
    column: dict                # name → array; NaN: no sample

    def stack(self, *names):
        return np.column_stack([self.column[name] for name in names]) if all(n in self.column for n in names) else None


def vehicle_path(name, beside):
    bare = "/" not in name and "." not in name
    return HOME / "models" / name / "vehicle.toml" if bare else (beside / name)


def read_vehicle(path):
    table = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    root = xml.parse(Path(path).parent / table["mjcf"]).getroot()
    body = next(b for b in root.iter("body") if b.find("inertial") is not None)
    inertial = body.find("inertial")
    numbers = lambda text: np.array([float(x) for x in text.split()])
    center = numbers(inertial.get("pos", "0 0 0"))
    diagonal = inertial.get("diaginertia") or " ".join(inertial.get("fullinertia").split()[:3])
    sites = {s.get("name"): numbers(s.get("pos", "0 0 0")) for s in body.iter("site")}
    thrust, rotors = table["thrust"], table["rotor"]
    actuator = table.get("actuator", {})
    return Vehicle(
        name=table["name"], mass=float(inertial.get("mass")), inertia=numbers(diagonal), center=center,
        hub=np.array([sites[r["site"]] for r in rotors]) - center,
        direction=np.array([1.0 if r["direction"] == "ccw" else -1.0 for r in rotors]),
        thrust=np.array([r.get("coefficient", thrust["coefficient"]) for r in rotors]),
        torque_ratio=thrust["torque_ratio"], radius=thrust["radius_m"], voltage=thrust.get("nominal_voltage_V", 0.0),
        pwm=actuator.get("pwm"), pwm_thrust=actuator.get("pwm_thrust"), effects=table.get("effect", []))


def sidecar_of(path):
    path = Path(path)
    name = path.name.removesuffix(".gz").removesuffix(".csv")
    return path.parent / f"{name}.meta.toml"


def read_log(path):
    path = Path(path)
    opener = gzip.open if path.suffix == ".gz" else open
    with opener(path, "rt", encoding="utf-8") as file:
        names = file.readline().strip().split(",")
        rows = [[float(cell) if cell else np.nan for cell in line.rstrip("\n").split(",")] for line in file if line.strip()]
    data = np.array(rows)
    meta = tomllib.loads(sidecar_of(path).read_text(encoding="utf-8"))
    return Log(path.name, meta, {name: data[:, i] for i, name in enumerate(names)})


def write_log(path, log, vehicle):
    """CSV and sidecar; cells as precise as they were."""
    path.parent.mkdir(parents=True, exist_ok=True)
    names = [name for name in log.column if name != "time_s"]
    block = np.column_stack([log.column[name] for name in names])
    block = block[:, used := ~np.all(np.isnan(block), axis=0)]
    lines = [",".join(["time_s", *(name for name, keep in zip(names, used) if keep)])]
    for time_s, row in zip(log.column["time_s"], block):
        lines.append(f"{time_s:.6f}," + ",".join("" if x != x else f"{x:.9g}" for x in row))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    text = [f"{key} = {json.dumps(value)}" for key, value in {**log.meta, "vehicle": vehicle}.items() if not isinstance(value, (dict, list))]
    for table in ("environment", "condition"):
        if table in log.meta:
            text += [f"[{table}]", *(f"{key} = {json.dumps(value)}" for key, value in log.meta[table].items())]
    sidecar_of(path).write_text("\n".join(text) + "\n", encoding="utf-8")


def rotor_speed(log, vehicle):
    """Ω of each rotor as the log tells it, rad/s, (samples, N); None when only collective thrust is known."""
    count = len(vehicle.thrust)
    measured = log.stack(*(f"rotor{i + 1}" for i in range(count)))
    if measured is not None:
        return measured
    u = log.stack(*(f"u{i + 1}" for i in range(count)))
    kind = log.meta["actuator"]
    if u is None or kind == "collective_thrust":
        return None
    if kind == "rotor_speed":
        return u
    if kind == "thrust":
        return np.sqrt(np.maximum(u, 0) / vehicle.thrust)
    if kind == "pwm" and vehicle.pwm_thrust:
        c = vehicle.pwm_thrust
        return np.sqrt(np.maximum(c[0] + c[1] * u + c[2] * u**2, 0) / vehicle.thrust)
    if kind == "pwm" and vehicle.pwm:
        return np.where(u > 0, vehicle.pwm["slope"] * u + vehicle.pwm["offset"], 0.0)
    return None
