"""gustlab export: a flight log as Parquet, as MCAP, or as one CSV per topic with PX4's names and frames."""

from argparse import Namespace
from pathlib import Path

from gustlab_import.command_line import Options

from .flight_file import FlightFile
from .problems import USAGE, Refusal
from .write import STDOUT, replace_file, replace_files

KINDS = ("parquet", "mcap", "csv")


def arguments(argv: list) -> Namespace:
    parser = Options(prog="gustlab export", description="writes a flight log for other programs: Parquet, MCAP "
                                     "(Foxglove, PlotJuggler), or one CSV per topic with the names, units and frames of PX4's ulog2csv",
                                     epilog="exit codes: 0 written, 2 usage, 3 the log cannot be used, 4 a file cannot be read or written")
    parser.add_argument("flight", type=Path, metavar="FLIGHT", help="a flight log NAME.csv[.gz], or the --out of `gustlab run`")
    parser.add_argument("--to", choices=KINDS, help="kind (default: by the ending of --out)")
    parser.add_argument("--out", type=Path, required=True, metavar="PATH", help="the file; with csv a folder")
    options = parser.parse_args(argv)
    ending = options.out.suffix.removeprefix(".")
    if options.to is None:
        if ending not in ("parquet", "mcap"):
            raise Refusal(f"--out {options.out}: its ending names no kind; give --to {', '.join(KINDS)}", USAGE)
        options.to = ending
    if options.to == "csv" and options.out == STDOUT:
        raise Refusal("--out -: one CSV per topic is a folder of files, which stdout cannot hold; name a folder", USAGE)
    return options


def run(argv: list) -> int:
    options = arguments(argv)
    flight = FlightFile(options.flight)
    inputs = (flight.path, flight.sidecar_path)
    if options.to == "csv":
        from .to_topics import topics, topic_text
        replace_files({options.out / f"{flight.stem}_{name}_0.csv": lambda path, columns=columns: path.write_bytes(topic_text(columns).encode("utf-8"))
                       for name, columns in topics(flight).items()}, inputs)
    elif options.to == "parquet":
        from .to_parquet import write_parquet
        replace_file(options.out, inputs, lambda path: write_parquet(flight, path))
    else:
        from .to_mcap import write_mcap
        replace_file(options.out, inputs, lambda path: write_mcap(flight, path))
    return 0
