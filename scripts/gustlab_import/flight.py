"""Turns a table and a column map into the columns of a flight log (SI units, world z up, quaternion scalar first)."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from . import frames
from .column_map import UNITS, ColumnMap, suggest
from .motors import pulse_share
from .problems import DATA, ImportFailure, valid_utf8
from .rotations import conjugate, rotate
from .signals import filled
from .streams import ATTITUDE, FORCE, POSITION, RATE, VELOCITY, Recording
from .tables import Table

AXES = "xyz"
MAX_NORM_ERROR = 0.02
MEASURED = ("position", "velocity", "attitude", "rate", "acceleration", "actuator", "rotor_speed")
FASTEST_s, SLOWEST_s = 2e-5, 0.2   # between rows


@dataclass
class Flight:
    """A recording in the units and frames of the flight log.

    file    path of the source as it was given
    time_s  (n,) [s]
    columns name of the flight log column -> (n,) in SI units, NaN where there is no sample, in the order of the file
    line    (n,) line or record of the source
    source  name of the flight log column -> column of the source
    rows    number of rows that the source had
    start_s source time of the flight log's zero [s]
    own_clocks  True when every stream kept its own times: empty cells are then no faults
    """

    file: str
    time_s: np.ndarray
    columns: dict
    line: np.ndarray
    source: dict
    rows: int
    start_s: float = 0.0
    findings: list = field(default_factory=list)
    own_clocks: bool = False

    def block(self, *names: str):
        """(n, len(names)) of the named columns, or None if one of them is not there."""
        if any(name not in self.columns for name in names):
            return None
        return np.column_stack([self.columns[name] for name in names])

    @property
    def actuator_names(self) -> list:
        commands = [name for name in self.columns if name[0] == "u" and name[1:].isdigit()]
        return commands or [name for name in self.columns if name.startswith("rotor") and name[5:].isdigit()]

    def where(self, row: int, column: str) -> str:
        """`file:line: column` of a cell of the source, for findings, which name no folder."""
        return f"{Path(self.file).name}:{self.line[row]}: column `{self.source.get(column, column)}`"

    def series(self, *names: str) -> tuple:
        """(time_s, values) of the rows that hold a sample of any of the named columns: their own clock."""
        values = self.block(*names)
        rows = ~np.isnan(values).all(axis=1)
        return self.time_s[rows], values[rows]

    def keep(self, rows: np.ndarray) -> None:
        """Keeps only the given rows (mask or indices)."""
        self.time_s, self.line = self.time_s[rows], self.line[rows]
        self.columns = {name: values[rows] for name, values in self.columns.items()}

    def step_s(self) -> float:
        return step_of(self.time_s)


def step_of(time_s: np.ndarray) -> float:
    """Median interval [s], 0 of fewer than two samples."""
    return float(np.median(np.diff(time_s))) if len(time_s) > 1 else 0.0


def on_one_clock(recording: Recording, from_s: float, to_s: float) -> Flight:
    """A stretch of a recording as a flight log: a row for every time at which anything was sampled, empty cells elsewhere."""
    parts = [part for part in (stream.between(from_s, to_s) for stream in recording.streams.values()) if len(part.time_s)]
    time_s = np.unique(np.concatenate([part.time_s for part in parts]))
    columns, source = {}, {}
    for part in parts:
        rows = np.searchsorted(time_s, part.time_s)
        for k, name in enumerate(part.columns):
            columns[name] = np.full(len(time_s), np.nan)
            columns[name][rows] = part.values[:, k]
            source[name] = part.source
    inside = [replace(f, from_s=max(f.from_s, from_s), to_s=min(f.to_s, to_s)) for f in recording.findings
              if f.from_s <= to_s and f.to_s >= from_s]
    return Flight(valid_utf8(recording.file), time_s, columns, np.arange(1, len(time_s) + 1), source, len(time_s), 0.0, inside, True)


def convert(table: Table, column_map: ColumnMap) -> Flight:
    """Applies the map. Throws ImportFailure when a column that the map names is not in the table."""
    builder = _Builder(table, column_map)
    time_s = builder.time()
    flight = Flight(valid_utf8(table.file), time_s, {}, table.line, {"time_s": column_map.get("time", "column")}, len(time_s),
                    builder.start_s, [replace(remark, from_s=remark.from_s - builder.start_s,
                                              to_s=remark.to_s - builder.start_s) for remark in table.remarks])
    builder.fill(flight)
    return flight


class _Builder:
    def __init__(self, table: Table, column_map: ColumnMap):
        self.table, self.map, self.start_s = table, column_map, 0.0

    def column(self, name: str) -> np.ndarray:
        if name not in self.table.columns:
            place = self.map.place(name) or f"{self.map.file}:1:1"
            raise ImportFailure(f"{place}: no column `{name}` in {self.table.file}; {suggest(name, self.table.columns)}")
        return self.table.columns[name]

    def time(self) -> np.ndarray:
        name = self.map.get("time", "column")
        if self.map.get("", "kind") == "ros" and name not in self.table.columns:
            raise ImportFailure(f"{self.table.file}:1:1: no column `{name}`, which [time] of the map `{self.map.name}` names; that of a bag is "
                                "called `time`")
        source = self.column(name)
        missing = np.flatnonzero(np.isnan(source))
        if len(missing):
            what = "a time that is no number, or too large for one" if self.map.get("time", "column") in self.table.non_finite else "a row without a time"
            raise ImportFailure(f"{self.table.file}:{self.table.line[missing[0]]}: column "
                                f"`{self.map.get('time', 'column')}`: {what} ({len(missing)} of them)", DATA)
        self.plausible(source * self.map.scale("time"))
        self.start_s = float(source[0] * self.map.scale("time")) if self.map.get("time", "zero", False) else 0.0
        return np.round(source * self.map.scale("time") - self.start_s, 6)

    def plausible(self, time_s: np.ndarray) -> None:
        """A unit that makes rows seconds or microseconds apart is wrong, and telemetry at 2 Hz is no recording."""
        if len(time_s) < 2:
            return
        mean_s, step_s = abs(time_s[-1] - time_s[0]) / (len(time_s) - 1), abs(step_of(time_s))
        where = f"{self.table.file}:{self.table.line[0]}: column `{self.map.get('time', 'column')}`"
        if 0.0 < mean_s < FASTEST_s:
            raise ImportFailure(f"{where}: rows are {1e6 * mean_s:.2g} us apart: [time] unit is too small (is it in s or ms?)", DATA)
        if step_s > SLOWEST_s:
            raise ImportFailure(f"{where}: rows are {step_s:.3g} s apart: cannot be judged at {1.0 / step_s:.2g} Hz (5 Hz are "
                                "needed), or [time] unit is too large (is it in ms or us?)", DATA)

    def block(self, table: str) -> np.ndarray:
        """(n, m) of a table's columns in SI, with the map's signs, still in its frame."""
        values = np.column_stack([self.column(name) for name in self.map.get(table, "columns")])
        return values * np.array(self.map.get(table, "signs", [1.0])) * self.map.scale(table)

    def fill(self, flight: Flight) -> None:
        def put(names, values, table):
            sources = self.map.get(table, "columns")
            for k, name in enumerate(names):
                flight.columns[name] = values[:, k]
                flight.source[name] = sources[min(k, len(sources) - 1)]

        for table in MEASURED:
            self.sampled(table)
        attitude = self.attitude() if self.map.has("attitude") else None
        if self.map.has("position"):
            position = self.block("position")
            put(POSITION, frames.enu(position) if self.map.get("position", "frame") == "ned" else position, "position")
        if self.map.has("velocity"):
            put(VELOCITY, self.in_frame("velocity", attitude, "world"), "velocity")
        if attitude is not None:
            put(ATTITUDE, attitude, "attitude")
            if self.map.get("attitude", "order") != "rpy":
                for name, letter in zip(self.map.get("attitude", "columns"), self.map.get("attitude", "order")):
                    flight.source["q" + letter] = name
        if self.map.has("rate"):
            put(RATE, self.in_frame("rate", attitude, "body"), "rate")
        if self.map.has("acceleration"):
            put(FORCE, self.in_frame("acceleration", attitude, "body"), "acceleration")
        for table, name in (("actuator", "u"), ("rotor_speed", "rotor")):
            if self.map.has(table):
                put([f"{name}{k + 1}" for k in range(len(self.map.get(table, "columns")))], self.inputs(table), table)
        if self.map.has("battery"):
            flight.columns["vbat"] = self.column(self.map.get("battery", "column")) * self.map.scale("battery")
            flight.source["vbat"] = self.map.get("battery", "column")
        self.references(flight)
        for extra in self.map.tables.get("extra", []):
            flight.columns[extra["name"]] = self.column(extra["column"]) * \
                UNITS[extra.get("quantity", "none")][extra.get("unit", next(iter(UNITS[extra.get("quantity", "none")])))]
            flight.source[extra["name"]] = extra["column"]

    def sampled(self, table: str) -> None:
        """A column that the map names and that is empty from its first row to its last was not logged."""
        for name in self.map.get(table, "columns", []):
            if np.isnan(self.column(name)).all():
                line = self.table.non_finite.get(name)
                raise ImportFailure(f"{self.table.file}:{line or 1}: column `{name}` holds no number{' that could be meant' if line else ''}, and [{table}] "
                                    f"of the map names it; leave [{table}] out, or name the column that has the samples", DATA)

    def inputs(self, table: str) -> np.ndarray:
        values = self.block(table)
        if "range" in self.map.tables[table]:
            low, high = self.map.get(table, "range")
            values = pulse_share(values, low, high)
        return values * self.map.get(table, "scale", 1.0)

    def attitude(self) -> np.ndarray:
        """Quaternion FLU body to z-up world, scalar first, not yet normalised."""
        order = self.map.get("attitude", "order")
        values = np.column_stack([self.column(name) for name in self.map.get("attitude", "columns")])
        values = values * np.array(self.map.get("attitude", "signs", [1.0]))
        if order == "rpy":
            q = frames.from_euler(*(values * self.map.scale("attitude")).T)
        else:
            q = np.column_stack([values[:, order.index(letter)] for letter in "wxyz"])
        q = conjugate(q) if self.map.get("attitude", "rotates", "body_to_world") == "world_to_body" else q
        world = self.map.get("attitude", "frame", "enu")
        q = frames.attitude_enu(q) if world == "ned" else q
        return frames.attitude_flu(q) if self.map.get("attitude", "body", "frd" if world == "ned" else "flu") == "frd" else q

    def in_frame(self, table: str, attitude, wanted: str) -> np.ndarray:
        """A table's vectors in the wanted frame, world or body."""
        given, values = self.map.get(table, "frame", wanted), self.block(table)
        if given == "ned":
            given, values = "world", frames.enu(values)
        if given == "frd":
            given, values = "body", frames.flu(values)
        given = {"enu": "world", "flu": "body"}.get(given, given)
        if given == wanted:
            return values
        if attitude is None:
            raise ImportFailure(f"{self.table.file}:1:1: [{table}] is in the {given} frame and the map `{self.map.name}` has "
                                "no [attitude] to turn it")
        # the attitude may be slower than what it turns
        q = filled(attitude)
        unit = q / np.maximum(np.linalg.norm(q, axis=1, keepdims=True), 1e-12)
        return rotate(unit if wanted == "world" else conjugate(unit), values)

    def references(self, flight: Flight) -> None:
        ned = self.map.get("reference", "frame") == "ned"
        for key, name in (("position", "rp"), ("velocity", "rv"), ("acceleration", "ra")):
            sources = self.map.get("reference", key, [])
            if not sources:
                continue
            values = np.column_stack([self.column(source) for source in sources])
            for k, axis in enumerate(AXES):
                flight.columns[name + axis] = (frames.enu(values) if ned else values)[:, k]
                flight.source[name + axis] = sources[k]
        yaw = self.map.get("reference", "yaw")
        if yaw:
            angle = self.column(yaw) * UNITS["angle"][self.map.get("reference", "yaw_unit", "rad")]
            flight.columns["ryaw"] = frames.yaw_enu(angle) if ned else angle
            flight.source["ryaw"] = yaw
