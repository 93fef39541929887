"""Runs all checks of one recording in their order: rows, columns, motion, and then what is cut away."""

import numpy as np

from .checks_columns import check_columns
from .checks_motion import check_motion
from .checks_rows import clean_time, gaps, keep_flight, keep_section
from .column_map import ColumnMap
from .flight import Flight
from .problems import ImportFailure, merged
from .tables import Table


def inspect(flight: Flight, column_map: ColumnMap, table: Table, from_s, to_s, whole: bool) -> None:
    """Checks a flight in place: adds findings, repairs what needs no guess, cuts to the part that is wanted."""
    enough(flight)
    clean_time(flight)
    keep_section(flight, column_map, from_s, to_s, whole)
    gaps(flight)
    check_columns(flight, column_map.get("actuator", "kind", "rotor_speed"), table.non_finite)
    if column_map.get("", "trim", "none") == "airborne" and not whole:
        keep_flight(flight)
    check_motion(flight)
    flight.findings = merged(flight.findings)


def check_flight(flight: Flight, actuator: str) -> None:
    """The same for a flight that was cut from a recording whose reader knows units and frames."""
    gaps(flight)
    check_columns(flight, actuator, {})
    check_motion(flight)
    flight.findings = merged(flight.findings)


def enough(flight: Flight) -> None:
    """A flight log needs position, specific force or body rate (FORMATS: flight log)."""
    if not any(name in flight.columns and not np.isnan(flight.columns[name]).all() for name in ("px", "ax", "wx")):
        raise ImportFailure(f"{flight.file}:1:1: neither position nor specific force nor body rate: nothing to compare a "
                            "simulation with")
