"""One flight log (docs/FORMATS.md §1) with its sidecar, in groups of columns that are sampled together."""

import tomllib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gustlab_import.tables import read_csv
from gustlab_import.toml_text import parse_toml

from .problems import DATA, Refusal

# name of the group, its columns, unit, meaning
VECTORS = (
    ("position", ("px", "py", "pz"), "m", "position, world"),
    ("velocity", ("vx", "vy", "vz"), "m/s", "velocity, world"),
    ("attitude", ("qw", "qx", "qy", "qz"), "1", "attitude, body to world, scalar first"),
    ("body_rate", ("wx", "wy", "wz"), "rad/s", "body rate, body"),
    ("specific_force", ("ax", "ay", "az"), "m/s^2", "specific force, body"),
    ("reference_position", ("rpx", "rpy", "rpz"), "m", "reference position, world"),
    ("reference_velocity", ("rvx", "rvy", "rvz"), "m/s", "reference velocity, world"),
    ("reference_acceleration", ("rax", "ray", "raz"), "m/s^2", "reference acceleration, world"),
    ("reference_yaw", ("ryaw",), "rad", "reference yaw"),
    ("battery", ("vbat",), "V", "battery voltage"),
    ("disturbance_force", ("fx", "fy", "fz"), "N", "applied disturbance force, world"),
    ("disturbance_torque", ("tx", "ty", "tz"), "N m", "applied disturbance moment, body"),
)
INPUT_UNITS = {"rotor_speed": "rad/s", "thrust": "N", "throttle": "1", "pwm": "1", "collective_thrust": "N"}
MOST_ROTORS = 8


@dataclass
class Group:
    """Columns that belong together, and the rows in which any of them has a sample (NaN: this one has none)."""

    name: str
    columns: tuple
    unit: str
    meaning: str
    time_s: np.ndarray  # (n,)
    values: np.ndarray  # (n, len(columns))

    def complete(self) -> "Group":
        """Only the rows in which every column has a sample."""
        rows = np.all(np.isfinite(self.values), axis=1)
        return replace(self, time_s=self.time_s[rows], values=self.values[rows])


class FlightFile:
    """columns: name -> (rows,) with NaN where there is no sample; sidecar: the parsed NAME.meta.toml, or {}."""

    def __init__(self, path):
        self.path = _csv_of(Path(path))
        table = read_csv(self.path)
        self.columns, self.line = table.columns, table.line
        self.time_s = self.need("time_s")
        if not np.all(np.isfinite(self.time_s)) or np.any(np.diff(self.time_s) <= 0.0):
            raise Refusal(f"{self.path}: time_s does not increase in every row (is it a flight log?)", DATA)
        self.sidecar_text = self._read_sidecar()
        try:
            self.sidecar = parse_toml(self.sidecar_text)
        except tomllib.TOMLDecodeError as error:
            raise Refusal(f"{self.sidecar_path}: {error}", DATA) from None

    @property
    def stem(self) -> str:
        return self.path.name.removesuffix(".gz").removesuffix(".csv")

    @property
    def sidecar_path(self) -> Path:
        return self.path.with_name(self.stem + ".meta.toml")

    def _read_sidecar(self) -> str:
        try:
            return self.sidecar_path.read_text(encoding="utf-8") if self.sidecar_path.is_file() else ""
        except (OSError, UnicodeDecodeError) as error:
            raise Refusal(f"{self.sidecar_path}: cannot be read ({error})") from None

    def need(self, name: str) -> np.ndarray:
        if name not in self.columns:
            raise Refusal(f"{self.path}: no column {name} (is it a flight log?)", DATA)
        return self.columns[name]

    def place(self, row: int, name: str) -> str:
        """`file:line:column` of a cell."""
        return f"{self.path}:{self.line[row]}:{list(self.columns).index(name) + 1}"

    def numbered(self, prefix: str) -> tuple:
        """The columns prefix1, prefix2, … that are there."""
        return tuple(f"{prefix}{i}" for i in range(1, MOST_ROTORS + 1) if f"{prefix}{i}" in self.columns)

    @property
    def input_kind(self) -> str:
        return str(self.sidecar.get("actuator", ""))

    def layout(self) -> list:
        """(name, columns, unit, meaning) of everything in the file, what the contract names first."""
        known = [group for group in VECTORS if any(name in self.columns for name in group[1])]
        known = [(name, tuple(c for c in columns if c in self.columns), unit, meaning) for name, columns, unit, meaning in known]
        if inputs := self.numbered("u"):
            known.append(("actuator_input", inputs, INPUT_UNITS.get(self.input_kind, ""),
                          f"actuator input per rotor ({self.input_kind or 'kind unknown'})"))
        if speeds := self.numbered("rotor"):
            known.append(("rotor_speed", speeds, "rad/s", "measured rotor speed"))
        named = {"time_s"}.union(*(columns for _, columns, _, _ in known))
        return known + [(name, (name,), "", "own column of this file") for name in self.columns if name not in named]

    def groups(self) -> list:
        """Every group that has a sample."""
        found = []
        for name, columns, unit, meaning in self.layout():
            values = np.column_stack([self.columns[column] for column in columns])
            rows = np.any(np.isfinite(values), axis=1)
            if rows.any():
                found.append(Group(name, columns, unit, meaning, self.time_s[rows], values[rows]))
        return found

    def group(self, name: str):
        """One group by name, or None."""
        return next((group for group in self.groups() if group.name == name), None)


def _csv_of(path: Path) -> Path:
    if not path.is_dir():
        return path
    for name in ("flight.csv", "flight.csv.gz"):
        if (path / name).is_file():
            return path / name
    raise Refusal(f"{path}: no flight.csv in this folder; name a flight log, or the --out of `gustlab run`")
