"""gustlab import: turns logs into flight logs, and says what is in them and what is wrong with them."""

import json
import sys
from argparse import Namespace
from pathlib import Path

import numpy as np

from .column_map import load_map
from .command_line import Options, seconds
from .from_recording import import_recording
from .from_table import import_table
from .kinds import kind_of, reader_of
from .new_vehicle import add_options, given, make_vehicle, missing, vehicle_there
from .outcome import FORMAT, as_document, as_json, as_text
from .outputs import file_on_the_way, write_outputs
from .problems import DATA, USAGE, ImportFailure, ended, printable, understood, valid_utf8
from .progress import LogProgress
from .segments import reasons
from .vehicle_file import read_vehicle
from .write_log import csv_text

FORMATS = ("PX4 ULog, ArduPilot DataFlash, MAVLink tlog, ROS 1 and 2 bag (.bag, .db3, .mcap), Betaflight blackbox, Crazyflie "
           "uSD, CSV, Parquet")


def arguments(argv: list) -> Namespace:
    parser = Options(prog="gustlab import", description="turns flight computers' logs into flight logs, or says "
                                     "what is in them", epilog="exit codes: 0 there is a flight, 2 usage, vehicle or map, 3 no "
                                     "flight (with the reason), or a file that cannot be read, 4 one that cannot be written")
    parser.add_argument("inputs", nargs="+", type=Path, metavar="LOG", help=FORMATS)
    parser.add_argument("--out", type=Path, metavar="DIR", help="where the flight logs and import.json go; without it nothing is written")
    parser.add_argument("--vehicle", metavar="NAME|PATH", help="vehicle of the flight logs (default: the map's, my_vehicle in DIR if it is "
                        "there, or vehicle.toml beside the flight logs); motors are put into its order")
    parser.add_argument("--map", metavar="NAME|FILE.toml", help="column map: needed for CSV, Parquet, uSD; built in or a file")
    parser.add_argument("--from", dest="from_s", type=seconds, metavar="S", help="first time kept, seconds of the log")
    parser.add_argument("--to", dest="to_s", type=seconds, metavar="S", help="last time kept, seconds of the log")
    parser.add_argument("--whole", action="store_true", help="with a map: keep the time on the ground, and what the map would cut")
    parser.add_argument("--keep-unusable", action="store_true", help="write unusable recordings too, marked usable = false")
    parser.add_argument("--keep-position", action="store_true", help="keep latitude and longitude of the origin in the sidecar")
    parser.add_argument("--format", choices=("text", "json"), default="text", help="of what is printed")
    said = parser.add_mutually_exclusive_group()
    said.add_argument("-q", "--quiet", action="store_true", help="errors only")
    said.add_argument("-v", "--verbose", action="store_true", help="also the noise of each flight, and the topics of logs that hold one")
    add_options(parser)
    return parser.parse_intermixed_args(argv)


def stem(path: Path, by_folder: bool) -> str:
    """File name without its endings; with by_folder, `folder-name`."""
    name = path.name
    for ending in (".gz", ".csv", ".txt", ".parquet", ".ulg", ".bin", ".BIN", ".log", ".tlog", ".bag", ".db3", ".mcap", ".bfl", ".bbl"):
        name = name.removesuffix(ending)
    return valid_utf8(f"{path.resolve().parent.name}-{name}" if by_folder else name)


def recording_of(path: Path):
    with understood(path):
        return reader_of(kind_of(path), path)(path)


def run(argv: list) -> int:
    options = arguments(argv)
    if options.out is not None and (file := file_on_the_way(options.out)):
        raise ImportFailure(f"--out {options.out}: {file} is a file, not a folder (flight logs go into a folder); give a folder", USAGE)
    if options.whole and not options.map:
        raise ImportFailure("--whole: an import without --map has no use for it (it is for column maps); leave it out", USAGE)
    column_map = load_map(options.map) if options.map else None
    made = make_vehicle(options) if given(options) else None
    named = options.vehicle or (None if column_map else vehicle_there(options.out))
    vehicle = made.vehicle if made else read_vehicle(str(named), options.out) if named else None
    outcomes, names = [], {}
    with LogProgress(len(options.inputs), options.quiet) as progress:
        for path in options.inputs:
            name = stem(path, column_map is not None and column_map.get("", "name") == "folder")
            if name in names and options.out is not None:
                raise ImportFailure(f"{path}: would be written over {names[name]} (both give {name}); use two --out", USAGE)
            names[name] = path
            progress.begin(path)
            if column_map is not None:
                outcomes.append(import_table(path, name, column_map, vehicle, options))
            else:
                outcomes.append(import_recording(recording_of(path), name, vehicle, options))
    # -q keeps to errors what is said to people; a document that was asked for is data
    if options.format == "json":
        print(as_json(as_document(outcomes)), end="")
    elif not options.quiet:
        print(as_text(outcomes, options.verbose), end="")
    # one unusable recording holds all back: a set of flights with a silent hole would be worse
    code = refusals(outcomes, options.keep_unusable)
    if options.out is not None and (code == 0 or column_map is None):
        write(options.out, outcomes, options.quiet, made.files if made and any(one.flights for one in outcomes) else {})
        say_of_vehicle(options, made, vehicle is not None or column_map is not None, outcomes)
    return code


def say_of_vehicle(options: Namespace, made, known: bool, outcomes: list) -> None:
    log = next((Path(one.file) for one in outcomes if one.flights), None)
    if options.quiet or log is None:
        return
    if made:
        print(printable(f"{options.out / made.vehicle.reference}: written, and says of each number where it comes from"), file=sys.stderr)
        print(made.said, end="", file=sys.stderr)
    elif not known and not (options.out / "vehicle.toml").is_file():
        print(printable(missing(options, log)), file=sys.stderr)


def refusals(outcomes: list, keep_unusable: bool) -> int:
    """Says on stderr why logs gave no flight; the exit code."""
    unusable = False
    for one in outcomes:
        wrong = next((f for _, f in one.all_findings() if f.severity == "error"), None)
        if wrong is not None and one.flights:
            print(printable(f"{one.file}: not usable: {wrong.says}"), file=sys.stderr)
            unusable = True
        elif not one.flights:
            print(printable(f"{one.file}: no flight: {'; '.join(reasons(one.refused))}"), file=sys.stderr)
    if unusable and not keep_unusable:
        return DATA
    return 0 if any(one.flights for one in outcomes) else DATA


def write(folder: Path, outcomes: list, quiet: bool, vehicle: dict) -> None:
    """Adds to what earlier imports wrote there, replaces what is imported again, and nothing that others wrote. `vehicle`: its files."""
    files = {}
    for one in outcomes:
        for name, flight, sidecar in one.flights:
            files[name + ".csv"] = csv_text(flight).encode("utf-8")
            files[name + ".meta.toml"] = sidecar.encode("utf-8")
    document, before = as_document(outcomes), former_import(folder)
    for one in outcomes:
        refuse_to_lose(folder, one, before)
    ours = {name for log in before for flight in log["flights"] for name in _names(flight)}
    for name in sorted(set(files) - ours):
        if (folder / name).exists():
            raise ImportFailure(f"{folder / name}: is there already, and no import wrote it; give another --out", USAGE)
    again = {one.name for one in outcomes}
    document["logs"] = [log for log in before if log["file"] not in again] + document["logs"]
    stale = {name for log in before if log["file"] in again for flight in log["flights"] for name in _names(flight)} - set(files)
    replaced = [name for name in sorted(files) if (folder / name).exists() and (folder / name).read_bytes() != files[name]]
    files["import.json"] = as_json(document).encode("utf-8")
    write_outputs({folder / name: content for name, content in (files | vehicle).items()})
    for name in stale:
        (folder / name).unlink(missing_ok=True)
    flights = [name for name in sorted(stale | set(replaced)) if name.endswith(".csv")]
    if flights and not quiet:
        print(printable(f"{folder}: imported again, and otherwise than before: {', '.join(flights)} replaced or removed"), file=sys.stderr)


def refuse_to_lose(folder: Path, one, before: list) -> None:
    """Another log's flights are not written over; those of the same log, by name and bytes, are."""
    mine = {name + ".csv" for name, _, _ in one.flights}
    for log in before:
        if log["file"] == one.name and log["sha256"] == one.sha256:
            continue
        if log["file"] == one.name and log["flights"]:
            raise ImportFailure(f"{one.file}: another log of this name was imported into {folder} before, and its flights would be lost; "
                                "give another --out, or rename the log", USAGE)
        if taken := sorted(mine & {flight["log"] for flight in log["flights"]}):
            raise ImportFailure(f"{one.file}: {taken[0]} in {folder} is a flight of {log['file']}; give another --out, or rename the log",
                                USAGE)


def _names(flight: dict) -> tuple:
    return flight["log"], flight["log"].removesuffix(".csv") + ".meta.toml"


def former_import(folder: Path) -> list:
    """The logs of an import.json that stands there already."""
    path = folder / "import.json"
    if not path.exists():
        return []
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        if document["format"] == FORMAT:
            return [{**log, "flights": list(log["flights"])} for log in document["logs"]]
    except (OSError, ValueError, KeyError, TypeError):
        pass
    raise ImportFailure(f"{path}: is there already, and no import wrote it; give another --out", USAGE)


def main(argv=None) -> int:
    # numbers of a damaged log may be of any size: the checks say so, numpy's warnings are no lines for people
    with np.errstate(all="ignore"):
        return ended(run, sys.argv[1:] if argv is None else argv)
