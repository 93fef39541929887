"""The vehicle file of an import that has none: `gustlab vehicle new` writes it, from the log and from what is given."""

import os
import shutil
import subprocess
import tempfile
from argparse import Namespace
from dataclasses import dataclass, replace
from pathlib import Path

from .kinds import kind_of
from .problems import IO, USAGE, ImportFailure
from .vehicle_file import Vehicle, read_vehicle

FOLDER = "my_vehicle"  # in --out, and so the vehicle's name
SAY_THEIR_VEHICLE = ("ulog", "dataflash")  # kinds of logs
OPTIONS = {
    "mass": ("1.2kg", "of the whole vehicle, with its unit; with it, a vehicle file is written to DIR/" + FOLDER),
    "arm": ("0.25m", "from the centre to a motor, with its unit (not needed where the log tells it)"),
    "prop": ("10in", "diameter of a propeller, with its unit"),
    "thrust-to-weight": ("X", "thrust of all rotors at full throttle over the weight (not needed where the log tells the hover)"),
    "hover": ("X", "throttle in hover, 0 to 1, in place of --thrust-to-weight"),
    "throttle-curve": ("F", "f of thrust ~ f u^2 + (1 - f) u"),
    "layout": ("NAME", "places and turns of the rotors, where the log does not tell them"),
}


@dataclass
class NewVehicle:
    """files: name in --out -> bytes; said: warnings of the command that wrote them."""

    vehicle: Vehicle
    files: dict
    said: str


def add_options(parser) -> None:
    group = parser.add_argument_group("vehicle", "in place of --vehicle: the numbers that `gustlab vehicle new` takes beside the log; what is "
                                      "neither given nor logged is estimated, and the file says of each number where it comes from")
    for name, (metavar, says) in OPTIONS.items():
        group.add_argument(f"--{name}", metavar=metavar, help=says)


def given(options: Namespace) -> list:
    """The words of the command line that describe the vehicle."""
    values = {name: getattr(options, name.replace("-", "_")) for name in OPTIONS}
    return [f"--{name}={value}" for name, value in values.items() if value is not None]


def vehicle_there(out) -> Path | None:
    """The vehicle that an earlier import wrote."""
    path = Path(out or ".") / FOLDER / "vehicle.toml"
    return path if out is not None and path.is_file() else None


def make_vehicle(options: Namespace) -> NewVehicle:
    words = given(options)
    first = words[0].partition("=")[0]
    if options.vehicle:
        raise ImportFailure(f"{first}: --vehicle {options.vehicle} says it already; leave one of them out", USAGE)
    if options.out is None:
        raise ImportFailure(f"{first}: a vehicle is written only beside flight logs; give --out DIR", USAGE)
    log = next((path for path in options.inputs if path.exists() and kind_of(path) in SAY_THEIR_VEHICLE), None)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / FOLDER
        done = _program(["vehicle", "new", *words, *([f"--from-log={log}"] if log else []), f"--out={folder}"])
        if done.returncode != 0:
            raise ImportFailure(done.stderr.strip().replace("gustlab vehicle new --help", "gustlab import --help"), done.returncode)
        files = {f"{FOLDER}/{path.name}": path.read_bytes() for path in folder.iterdir()}
        vehicle = replace(read_vehicle(str(folder), None), reference=f"{FOLDER}/vehicle.toml")
    for name, content in files.items():
        path = options.out / name
        if path.exists() and path.read_bytes() != content:
            raise ImportFailure(f"{path}: is there already, and otherwise (a vehicle is never overwritten); leave {first} out to use it, or "
                                "give another --out", USAGE)
    return NewVehicle(vehicle, files, done.stderr)


def missing(options: Namespace, log: Path) -> str:
    """What is said where flight logs were written and no vehicle: what of it this log does not say."""
    from log_vehicle import said_of  # the script behind `vehicle new --from-log`, whose libraries take a second
    try:
        said = said_of(log)
    except ImportFailure:  # its flights are written: what it says of the vehicle is too damaged
        said = None
    said = said or {"metres": False, "hover": None}
    lacks = ["what the vehicle weighs (--mass 1.2kg)"]
    if not said["metres"]:
        lacks.append("how far its motors are from its centre (--arm 0.25m)")
    if said["hover"] is None:
        lacks.append("how strong they are (--thrust-to-weight 2)")
    return (f"{options.out}: no vehicle file is there, and {log.name} does not say {' nor '.join(lacks)}; import again with "
            f"{'these' if len(lacks) > 1 else 'this'}, or with --vehicle; nothing can be diagnosed without")


def _program(words: list):
    program = os.environ.get("GUSTLAB_PROGRAM") or shutil.which("gustlab")
    if program is None:
        raise ImportFailure("--mass and the other numbers of a vehicle need the program: run `gustlab import`", USAGE)
    try:
        return subprocess.run([program, *words], capture_output=True, text=True, check=False)
    except OSError as error:
        raise ImportFailure(f"{program}: cannot be run ({error.strerror})", IO) from error
