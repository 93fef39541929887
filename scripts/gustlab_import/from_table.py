"""A table and a column map become one flight log (the time on the ground may be left out)."""

from pathlib import Path

from .checks import inspect
from .column_map import ColumnMap, suggest
from .flight import convert
from .limits import cannot_tell
from .outcome import Outcome
from .problems import USAGE, ImportFailure
from .progress import stage
from .tables import Table, read_csv, read_parquet
from .usd_log import read_usd
from .vehicle_file import read_vehicle, shipped
from .write_log import sidecar_text


def read_table(path: Path, column_map: ColumnMap) -> Table:
    """Reads a file as its map says."""
    kind = column_map.get("", "kind")
    if kind == "usd":
        return read_usd(path, column_map.get("", "event"))
    if kind == "parquet":
        return read_parquet(path)
    if kind == "ros":
        from .read_ros import table_of  # a second to import
        return table_of(path, column_map.names())
    return read_csv(path)


def fits_rotors(column_map: ColumnMap, vehicle, given: str) -> None:
    """A map for another number of rotors than the vehicle has is refused."""
    for name in ("actuator", "rotor_speed"):
        columns = column_map.get(name, "columns") or []
        if vehicle and vehicle.rotors and columns and column_map.get(name, "kind") != "collective_thrust" and len(columns) != len(vehicle.rotors):
            raise ImportFailure(f"{given.removesuffix('.toml')}.toml:1:1: [{name}] has {len(columns)} columns, and the vehicle {vehicle.reference} has "
                                f"{len(vehicle.rotors)} rotors; give the vehicle that flew", USAGE)


def import_table(path: Path, name: str, column_map: ColumnMap, vehicle, options) -> Outcome:
    table = read_table(path, column_map)
    stage("checking")
    reference = vehicle.reference if vehicle else column_map.get("", "vehicle")
    if reference is None:
        raise ImportFailure(f"{options.map.removesuffix('.toml')}.toml:1:1: `vehicle` is missing, and --vehicle is not given", USAGE)
    # a path may lead to a file that is still to come
    folder = (Path(options.out or ".") / reference / "vehicle.toml").is_file()
    if "/" not in reference and not reference.endswith(".toml") and reference not in shipped() and not folder:
        raise ImportFailure(f'{options.map.removesuffix(".toml")}.toml:1:1: there is no vehicle "{reference}" under models/ (a path ends in .toml); '
                            f"{suggest(reference, shipped())}", USAGE)
    known = vehicle or (read_vehicle(reference, options.out) if reference in shipped() else None)
    fits_rotors(column_map, known, options.map)
    flight = convert(table, column_map)
    inspect(flight, column_map, table, options.from_s, options.to_s, options.whole)
    usable = all(f.severity != "error" for f in flight.findings)
    top = {"vehicle": reference, "actuator": column_map.get("actuator", "kind"),
           "source": column_map.get("", "source", "recording"),
           "hold": column_map.get("", "hold", "unknown"), "notes": column_map.get("", "notes", "")}
    origin = {"file": Path(flight.file).name, "sha256": table.sha256, "map": column_map.name, "published": column_map.get("", "published", ""),
              "rows_read": flight.rows, "source_time_of_zero_s": flight.start_s, "usable": usable,
              "known_issues": column_map.get("", "known_issues", [])}
    sidecar = sidecar_text(flight, top, column_map.tables.get("environment", {}), origin)
    out = Outcome(flight.file, table.sha256, column_map.get("", "kind"), "", "by the column map " + column_map.name,
                  flights=[(f"{name}_1", flight, sidecar)])
    out.limits = cannot_tell([flight], {}) if usable else []
    return out
