#!/usr/bin/env python3
"""Turns foreign flight recordings into gustlab flight logs, and says what is wrong with them.

    scripts/import_log.py INPUT... --map NAME|FILE.toml --out DIR [--vehicle NAME|PATH] [--from S --to S]

Exit code 0 when every input is usable (warnings included), 2 for a wrong command line or map, 3 when an input is not
usable (nothing is written then), 4 when a file cannot be read or written.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from gustlab_import.checks import inspect  # noqa: E402
from gustlab_import.column_map import load_map  # noqa: E402
from gustlab_import.flight import convert  # noqa: E402
from gustlab_import.problems import DATA, IO, USAGE, ImportFailure  # noqa: E402
from gustlab_import.report import as_json, as_text  # noqa: E402
from gustlab_import.tables import read_csv  # noqa: E402
from gustlab_import.usd_log import read_usd  # noqa: E402
from gustlab_import.write_log import csv_text, packed, sidecar_text, write_all  # noqa: E402


def arguments(argv: list) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="import_log.py", description=__doc__.split("\n")[0])
    parser.add_argument("inputs", nargs="+", type=Path, metavar="INPUT", help="recordings: CSV, CSV.gz or Crazyflie uSD log")
    parser.add_argument("--map", required=True, metavar="NAME|FILE.toml", help="built-in column map, or a file")
    parser.add_argument("--out", type=Path, metavar="DIR", help="where the flight logs go; without it, only the report")
    parser.add_argument("--vehicle", metavar="NAME|PATH", help="vehicle of the flight logs (default: the map's)")
    parser.add_argument("--from", dest="from_s", type=float, metavar="S", help="first time kept, flight log seconds")
    parser.add_argument("--to", dest="to_s", type=float, metavar="S", help="last time kept, flight log seconds")
    parser.add_argument("--whole", action="store_true", help="keep the time on the ground, and what the map would cut")
    parser.add_argument("--keep-unusable", action="store_true", help="write unusable recordings too, marked usable = false")
    parser.add_argument("--plain", action="store_true", help="write .csv instead of .csv.gz")
    parser.add_argument("--format", choices=("text", "json"), default="text", help="of the report")
    return parser.parse_args(argv)


def output_name(path: Path, by_folder: bool) -> str:
    """File name without .csv, .csv.gz or .gz; with by_folder, `folder-name`."""
    name = path.name
    for ending in (".gz", ".csv", ".txt"):
        name = name.removesuffix(ending)
    return f"{path.resolve().parent.name}-{name}" if by_folder else name


def run(argv: list) -> int:
    options = arguments(argv)
    column_map = load_map(options.map)
    results, names = [], {}
    for path in options.inputs:
        name = output_name(path, column_map.get("", "name") == "folder")
        if name in names:
            raise ImportFailure(f"{path}: would be written over {names[name]} (both give {name}); use two --out", USAGE)
        names[name] = path
        read = read_usd(path, column_map.get("", "event")) if column_map.get("", "kind") == "usd" else read_csv(path)
        flight = convert(read, column_map)
        inspect(flight, column_map, read, options.from_s, options.to_s, options.whole)
        results.append((name, flight, read.sha256))
    print(as_json(results) if options.format == "json" else as_text(results), end="")
    unusable = [name for name, flight, _ in results if any(f.severity == "error" for f in flight.findings)]
    for name in unusable:
        first = next(f for f in dict((n, flight) for n, flight, _ in results)[name].findings if f.severity == "error")
        print(f"{names[name].name}: not usable: {first.says}", file=sys.stderr)
    if unusable and not options.keep_unusable:
        return DATA
    if options.out is not None:
        files = {}
        for name, flight, sha256 in results:
            ending, text = (".csv", csv_text(flight)) if options.plain else (".csv.gz", csv_text(flight))
            files[name + ending] = text.encode("utf-8") if options.plain else packed(text)
            vehicle = options.vehicle or column_map.get("", "vehicle")
            sidecar = sidecar_text(flight, column_map, sha256, vehicle, name not in unusable)
            files[name + ".meta.toml"] = sidecar.encode("utf-8")
        write_all(options.out, files)
    return 0


def main(argv=None) -> int:
    try:
        return run(sys.argv[1:] if argv is None else argv)
    except ImportFailure as failure:
        print(failure, file=sys.stderr)
        return failure.code
    except BrokenPipeError:
        return IO


if __name__ == "__main__":
    sys.exit(main())
