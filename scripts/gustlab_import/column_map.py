"""Column maps: which source columns, in which units, order and frame, make a flight log."""

import difflib
import math
import os
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

from .problems import USAGE, ImportFailure, some
from .toml_text import parse_toml

FORMAT = "gustlab-column-map/1"
MAPS = Path(__file__).resolve().parent.parent / "column_maps"

# factor to SI; standard gravity and the inch-free rest are exact by definition (BIPM SI brochure; CGPM 1901)
UNITS = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "velocity": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3},
    "acceleration": {"m/s^2": 1.0, "mm/s^2": 1e-3, "g": 9.80665, "mg": 9.80665e-3},
    "rate": {"rad/s": 1.0, "mrad/s": 1e-3, "deg/s": 0.017453292519943295},
    "angle": {"rad": 1.0, "mrad": 1e-3, "deg": 0.017453292519943295},
    "rotor_speed": {"rad/s": 1.0, "rpm": 0.10471975511965977},
    "thrust": {"N": 1.0, "gf": 9.80665e-3},
    "voltage": {"V": 1.0, "mV": 1e-3},
    "none": {"": 1.0, "1": 1.0},
}
ACTUATORS = {"rotor_speed": "rotor_speed", "thrust": "thrust", "throttle": "none", "pwm": "none",
             "collective_thrust": "thrust"}
ORDERS = ("wxyz", "xyzw", "rpy")

# table of the map -> (keys it may have, keys it must have)
TABLES = {
    "": ({"format", "description", "kind", "event", "vehicle", "source", "hold", "notes", "published", "known_issues",
          "trim", "name"}, {"format", "kind"}),
    "time": ({"column", "unit", "zero"}, {"column"}),
    "position": ({"columns", "unit", "frame", "signs"}, {"columns"}),
    "velocity": ({"columns", "unit", "frame", "signs"}, {"columns", "frame"}),
    "attitude": ({"columns", "order", "rotates", "frame", "body", "unit", "signs"}, {"columns", "order"}),
    "rate": ({"columns", "unit", "frame", "signs"}, {"columns"}),
    "acceleration": ({"columns", "unit", "frame", "signs"}, {"columns"}),
    "actuator": ({"kind", "columns", "unit", "scale", "range"}, {"kind", "columns"}),
    "rotor_speed": ({"columns", "unit"}, {"columns"}),
    "battery": ({"column", "unit"}, {"column"}),
    "reference": ({"position", "velocity", "acceleration", "yaw", "yaw_unit", "frame"}, set()),
    "environment": ({"ground_z_m", "ceiling_z_m", "walls"}, set()),
    "extra": ({"name", "column", "quantity", "unit"}, {"name", "column"}),
    "section": ({"file", "from_s", "to_s", "why"}, {"file"}),
}
CHOICES = {("", "kind"): ("csv", "usd", "parquet", "ros"), ("", "source"): ("recording", "simulation"),
           ("", "hold"): ("zoh", "linear", "unknown"), ("", "trim"): ("none", "airborne"),
           ("", "name"): ("file", "folder"), ("position", "frame"): ("enu", "ned"),
           ("velocity", "frame"): ("world", "body", "enu", "ned", "flu", "frd"),
           ("rate", "frame"): ("body", "world", "flu", "frd"), ("acceleration", "frame"): ("flu", "frd"),
           ("reference", "frame"): ("enu", "ned"), ("attitude", "frame"): ("enu", "ned"), ("attitude", "body"): ("flu", "frd"),
           ("attitude", "order"): ORDERS,
           ("attitude", "rotates"): ("body_to_world", "world_to_body"), ("actuator", "kind"): tuple(ACTUATORS)}
UNIT_OF = {"time": "time", "position": "length", "velocity": "velocity", "rate": "rate", "acceleration": "acceleration",
           "rotor_speed": "rotor_speed", "battery": "voltage", "attitude": "angle"}
LENGTHS = {"position": 3, "velocity": 3, "attitude": 4, "rate": 3, "acceleration": 3}
NAME_LISTS = ("columns", "position", "velocity", "acceleration", "known_issues")
NAMES_COLUMNS = {"column", "columns", "position", "velocity", "acceleration", "yaw"}  # keys
NUMBERS = {"from_s", "to_s", "ground_z_m", "ceiling_z_m", "scale"}
NUMBER_LISTS = {"signs": (-1.0, 1.0), "range": (-1e9, 1e9)}


@dataclass
class ColumnMap:
    """A checked column map; `top` holds the keys outside tables, `tables` the rest, lists for [[extra]], [[section]]."""

    name: str
    top: dict
    tables: dict = field(default_factory=dict)
    file: str = ""
    text: str = ""

    def has(self, table: str) -> bool:
        return table in self.tables

    def get(self, table: str, key: str, default=None):
        return (self.top if table == "" else self.tables.get(table, {})).get(key, default)

    def scale(self, table: str) -> float:
        """Factor from the unit of a table's columns to SI."""
        quantity = ACTUATORS[self.get("actuator", "kind")] if table == "actuator" else UNIT_OF[table]
        return UNITS[quantity][self.get(table, "unit", next(iter(UNITS[quantity])))]

    def names(self) -> set:
        """Every source column that the map names, but the time."""
        out = {extra["column"] for extra in self.tables.get("extra", [])}
        for name, table in self.tables.items():
            if name in ("extra", "section", "time", "environment"):
                continue
            for key, value in table.items():
                if key in NAME_LISTS:
                    out.update(value)
                elif key in ("column", "yaw"):
                    out.add(value)
        return out

    def place(self, column: str) -> str:
        """`file:line:col` of where the map names a column; empty where it is written in another way."""
        key, written = "", re.compile("[\"']" + re.escape(column) + "[\"']")
        for number, line in enumerate(self.text.splitlines(), 1):
            begins = re.match(r"\s*(\w+)\s*=", line)
            key = begins[1] if begins else key
            if key in NAMES_COLUMNS and (found := written.search(line)):
                return f"{self.file}:{number}:{found.start() + 1}"
        return ""

    def section(self, file: str) -> tuple:
        """(from_s, to_s, why) that the map gives for a file; None where it does not say."""
        for entry in self.tables.get("section", []):
            if entry["file"] == file:
                return entry.get("from_s"), entry.get("to_s"), entry.get("why", "")
        return None, None, ""


def find_map(name: str) -> Path:
    """Path of a built-in map's name, or of a file."""
    built_in = MAPS / f"{name}.toml"
    if built_in.is_file():
        return built_in
    if Path(name).is_file():
        return Path(name)
    known = ", ".join(sorted(path.stem for path in MAPS.glob("*.toml")))
    raise ImportFailure(f"--map {name}: no built-in map and no file of this name (built in: {known})", USAGE)


def load_map(name: str) -> ColumnMap:
    """Reads and checks a map. Throws ImportFailure with code 2 and `file:line:col`."""
    path = find_map(name)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ImportFailure(f"{path}:1:1: the map cannot be read ({error})", USAGE) from error
    try:
        document = parse_toml(text)
    except tomllib.TOMLDecodeError as error:
        at = str(error)
        where = [part for part in at.replace(")", "").replace(",", "").split() if part.isdigit()][-2:]
        where = where if len(where) == 2 else [str(text.count("\n") + 1), "1"]
        raise ImportFailure(f"{path}:{where[0]}:{where[1]}: {at.split(' (at')[0]}", USAGE) from error
    top = {key: value for key, value in document.items() if not _is_table(value)}
    tables = {key: value for key, value in document.items() if _is_table(value)}
    checked = _Checker(str(path), text)
    checked.table("", top)
    for key, value in tables.items():
        if key not in TABLES or key == "":
            checked.fail(key, f"unknown table [{key}]", suggest(key, [name for name in TABLES if name]))
        repeated = key in ("extra", "section")
        if repeated != isinstance(value, list):
            checked.fail(key, f"[{key}] must be written as {'[[' + key + ']]' if repeated else '[' + key + ']'}", "")
        for entry in value if repeated else [value]:
            checked.table(key, entry)
    if top["format"] != FORMAT:
        checked.fail("format", f'format is "{top["format"]}"', f'must be "{FORMAT}"')
    if "attitude" in tables and "unit" in tables["attitude"] and tables["attitude"]["order"] != "rpy":
        checked.fail("unit", "[attitude] has a unit and quaternions have none", 'give order = "rpy", or leave the unit out')
    if "time" not in tables or "actuator" not in tables and "rotor_speed" not in tables:
        raise ImportFailure(f"{path}:1:1: a map needs [time] and [actuator] or [rotor_speed]", USAGE)
    if top["kind"] == "usd" and "event" not in top:
        checked.fail("kind", 'kind = "usd" needs `event`', 'for example event = "fixedFrequency"')
    return ColumnMap(path.stem, top, tables, str(path), text)


def suggest(word: str, known) -> str:
    close = difflib.get_close_matches(word, known, 12, cutoff=0.5)
    if not close:
        return f"one of: {some(known)}"

    # of those that are equally near the one that begins alike
    def nearness(name: str) -> tuple:
        return difflib.SequenceMatcher(None, name, word).ratio(), len(os.path.commonprefix([word, name]))

    return f"did you mean `{max(reversed(close), key=nearness)}`?"


def _is_number(value) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _is_table(value) -> bool:
    return isinstance(value, dict) or isinstance(value, list) and value and isinstance(value[0], dict)


class _Checker:
    def __init__(self, file: str, text: str):
        self.file, self.lines = file, text.splitlines()

    def fail(self, key: str, what: str, suggestion: str):
        """Points at the first line that names the key."""
        at = next(((n, line.index(key) + 1) for n, line in enumerate(self.lines, 1) if key in line.split("#")[0]), (1, 1))
        raise ImportFailure(f"{self.file}:{at[0]}:{at[1]}: {what}" + (f"; {suggestion}" if suggestion else ""), USAGE)

    def type_of(self, key: str, value):
        """The kinds of values that the code relies on."""
        if key in NAME_LISTS:
            if not (isinstance(value, list) and all(isinstance(part, str) for part in value)):
                self.fail(key, f"`{key}` must be a list of names", 'for example ["a", "b", "c"]')
        elif key in NUMBER_LISTS:
            low, high = NUMBER_LISTS[key]
            if not (isinstance(value, list) and all(isinstance(part, (int, float)) and low <= part <= high for part in value)):
                self.fail(key, f"`{key}` must be a list of numbers from {low:g} to {high:g}", "")
        elif key in NUMBERS:
            if not _is_number(value):
                self.fail(key, f"`{key}` must be a number", "")
        elif key == "walls":
            if not (isinstance(value, list) and all(isinstance(wall, list) and len(wall) == 4 and all(map(_is_number, wall)) for wall in value)):
                self.fail(key, "`walls` must be a list of walls", "each is [px, py, nx, ny]")
        elif key == "zero":
            if not isinstance(value, bool):
                self.fail(key, "`zero` must be true or false", "")
        elif not isinstance(value, str):
            self.fail(key, f"`{key}` must be a text in quotes", "")

    def table(self, name: str, entry: dict):
        allowed, required = TABLES[name]
        for key, value in entry.items():
            if key not in allowed:
                self.fail(key, f"unknown key `{key}`" + (f" in [{name}]" if name else ""), suggest(key, allowed))
            self.type_of(key, value)
            choices = CHOICES.get((name, key))
            if choices and value not in choices:
                self.fail(key, f'{key} = "{value}" is not known', f"one of: {', '.join(choices)}")
        for key in sorted(required - entry.keys()):
            self.fail(name, f"[{name}] has no `{key}`" if name else f"`{key}` is missing", "")
        if name == "extra" and not re.fullmatch(r"\w[\w.-]*", entry["name"], re.ASCII):
            self.fail("name", f'"{entry["name"]}" is no name of a column', "letters, digits, _, - and . make one")
        count = 3 if entry.get("order") == "rpy" else LENGTHS.get(name)
        if "signs" in entry and (len(entry["signs"]) != count or any(abs(sign) != 1.0 for sign in entry["signs"])):
            self.fail("signs", f"[{name}] signs = {entry['signs']}", f"must be {count} numbers, each 1 or -1")
        if "range" in entry and (len(entry["range"]) != 2 or not entry["range"][0] < entry["range"][1]):
            self.fail("range", f"[{name}] range = {entry['range']}", "must be [off, full], for example [1000, 2000]")
        if count and len(entry["columns"]) != count:
            self.fail("columns", f"[{name}] needs {count} columns, not {len(entry['columns'])}", "")
        twice = next((column for column in entry.get("columns", []) if entry["columns"].count(column) > 1), None)
        if twice is not None and name in ("attitude", "actuator", "rotor_speed"):
            self.fail(twice, f"[{name}] names column `{twice}` twice", "each is a quantity of its own")
        if name == "actuator" and entry["kind"] != "collective_thrust" and not 3 <= len(entry["columns"]) <= 8:
            self.fail("columns", f"[actuator] has {len(entry['columns'])} columns", "a vehicle has 3 to 8 rotors")
        quantity = entry.get("quantity", "none") if name == "extra" else \
            ACTUATORS.get(entry.get("kind"), "none") if name == "actuator" else UNIT_OF.get(name)
        if quantity not in UNITS and quantity is not None:
            self.fail(quantity, f'quantity = "{quantity}" is not known', f"one of: {', '.join(UNITS)}")
        if quantity and "unit" in entry and entry["unit"] not in UNITS[quantity]:
            self.fail(entry["unit"] or "unit", f'unit = "{entry["unit"]}" is not a unit of {quantity}',
                      f"one of: {', '.join(UNITS[quantity])}")
