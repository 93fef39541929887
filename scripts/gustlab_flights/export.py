"""gustlab export: a flight log as Parquet, as MCAP, or as one CSV per topic with PX4's names and frames."""

from argparse import Namespace
from pathlib import Path

from gustlab_import.command_line import Options
from gustlab_import.outputs import STDOUT, write_outputs

from .flight_file import FlightFile
from .problems import USAGE, Refusal

KINDS = ("parquet", "mcap", "csv")


def arguments(argv: list) -> Namespace:
    parser = Options(prog="gustlab export", description="writes a flight log for other programs: Parquet, MCAP "
                                     "(Foxglove, PlotJuggler), or one CSV per topic with the names, units and frames of PX4's ulog2csv",
                                     epilog="exit codes: 0 written, 2 usage, 3 the log cannot be used, 4 a file cannot be read or written")
    parser.add_argument("flight", type=Path, metavar="FLIGHT", help="a flight log NAME.csv[.gz], or the --out of `gustlab run`")
    parser.add_argument("--to", choices=KINDS, help="kind (default: by the ending of --out)")
    parser.add_argument("--out", type=Path, required=True, metavar="PATH", help="the file (-: stdout); with csv a folder")
    options = parser.parse_args(argv)
    ending = options.out.suffix.removeprefix(".")
    if options.to is None:
        if ending not in ("parquet", "mcap"):
            raise Refusal(f"--out {options.out}: its ending names no kind; give --to {', '.join(KINDS)}", USAGE)
        options.to = ending
    if options.to == "csv" and options.out == STDOUT:
        raise Refusal("--out -: csv is a file for each topic, and stdout is one; give a folder", USAGE)
    return options


def contents(flight: FlightFile, options: Namespace) -> dict:
    """path -> bytes"""
    if options.to == "csv":
        from .to_topics import topic_text, topics
        return {options.out / f"{flight.stem}_{name}_0.csv": topic_text(table).encode("utf-8") for name, table in topics(flight).items()}
    if options.to == "parquet":
        from .to_parquet import parquet_bytes
        return {options.out: parquet_bytes(flight)}
    from .to_mcap import mcap_bytes
    return {options.out: mcap_bytes(flight)}


def run(argv: list) -> int:
    options = arguments(argv)
    flight = FlightFile(options.flight)
    write_outputs(contents(flight, options), (flight.path, flight.sidecar_path))
    return 0
