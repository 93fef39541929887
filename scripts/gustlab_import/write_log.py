"""Writes a flight log (CSV with its sidecar): the same input gives the same bytes."""

import io

import numpy as np

from . import VERSION
from .flight import Flight


def csv_text(flight: Flight) -> str:
    """The flight log: time to a microsecond, everything else to nine digits, empty where there is no sample."""
    names = list(flight.columns)
    text = io.StringIO()
    text.write(",".join(["time_s"] + names) + "\n")
    block = np.column_stack([flight.columns[name] for name in names])
    holes = np.isnan(block)
    for k, time_s in enumerate(flight.time_s):
        cells = ["" if hole else f"{value:.9g}" for value, hole in zip(block[k], holes[k])]
        text.write(f"{time_s:.6f}," + ",".join(cells) + "\n")
    return text.getvalue()


def _text(value: str) -> str:
    return '"' + value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'


def _value(value) -> str:
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return "[" + ", ".join(_value(part) for part in value) + "]"
    return repr(float(value)) if isinstance(value, float) else str(value)


def sidecar_text(flight: Flight, top: dict, environment: dict, origin: dict) -> str:
    """NAME.meta.toml: what the contract asks for, and under [origin] where it came from and what is wrong with it."""
    origin = {**origin, "rows_written": len(flight.time_s), "importer": "gustlab import", "importer_version": VERSION}
    lines = [f"{key} = {_value(value)}" for key, value in {"format": "gustlab-flight/1", **top}.items() if value is not None]
    if environment:
        lines += ["", "[environment]"] + [f"{key} = {_value(value)}" for key, value in environment.items()]
    lines += ["", "[origin]"] + [f"{key} = {_value(value)}" for key, value in origin.items()]
    for finding in flight.findings:
        lines += ["", "[[origin.finding]]"] + [f"{key} = {_value(value)}" for key, value in finding.as_dict().items()]
    return "\n".join(lines) + "\n"
