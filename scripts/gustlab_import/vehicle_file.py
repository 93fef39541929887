"""What the importer must know of a vehicle file: its rotors, and which actuator inputs it can read."""

import os
import tomllib
import xml.etree.ElementTree as xml
from dataclasses import dataclass
from pathlib import Path

from .column_map import suggest
from .problems import USAGE, ImportFailure
from .streams import Rotor
from .toml_text import parse_toml

FORMAT = "gustlab-vehicle/1"
MODELS = Path(__file__).resolve().parents[2] / "models"


@dataclass
class Vehicle:
    """reference: what the sidecar says (a name, or a path); rotors in the file's order; inputs: actuator kinds it maps."""

    reference: str
    rotors: list
    inputs: tuple


def find_vehicle(wanted: str, beside: Path = Path()) -> Path:
    """The vehicle.toml of a name under models/, or of a path from `beside` to it or to its folder."""
    if wanted in shipped():
        return MODELS / wanted / "vehicle.toml"
    given = beside / wanted
    for path in (given, given / "vehicle.toml"):
        if wanted and path.is_file():
            return path
    raise ImportFailure(f"--vehicle {wanted}: no vehicle of this name under models/ and no such file; {suggest(wanted, shipped())}",
                        USAGE)


def shipped() -> list:
    """Names of the vehicles under models/."""
    return sorted(folder.name for folder in MODELS.iterdir() if (folder / "vehicle.toml").is_file())


def read_vehicle(wanted: str, beside) -> Vehicle:
    """`beside` is the folder of the flight logs, for a relative path."""
    path = find_vehicle(wanted)
    reference = wanted if wanted in shipped() else Path(os.path.relpath(path.resolve(), Path(beside or ".").resolve())).as_posix()
    try:
        document = parse_toml(path.read_text(encoding="utf-8"))
        if document.get("format") != FORMAT:
            raise ImportFailure(f'{path}:1:1: --vehicle: not a vehicle file ("format" must be "{FORMAT}"); make one with `gustlab vehicle new`', USAGE)
        return Vehicle(reference, _rotors(path, document), _inputs(document))
    except tomllib.TOMLDecodeError as error:
        raise ImportFailure(f"{path}:1:1: --vehicle: not a vehicle file ({error}); give its vehicle.toml", USAGE) from error
    except (OSError, UnicodeDecodeError, xml.ParseError) as error:
        raise ImportFailure(f"{path}:1:1: --vehicle: cannot be read ({error})", USAGE) from error


def _rotors(path: Path, document: dict) -> list:
    """Rotors from the MJCF's sites; [] when the file does not say, which its own reader will report."""
    mjcf = path.parent / str(document.get("mjcf", ""))
    rotors = document.get("rotor")
    if not mjcf.is_file() or not isinstance(rotors, list) or not all(isinstance(rotor, dict) for rotor in rotors):
        return []
    sites = {site.get("name"): site.get("pos", "0 0 0") for site in xml.parse(mjcf).iter("site")}
    out = []
    for rotor in rotors:
        place = sites.get(rotor.get("site"))
        if place is None:
            return []
        out.append(Rotor(*_place(mjcf, rotor["site"], place), 1 if rotor.get("direction") == "ccw" else -1))
    return out


def _place(mjcf: Path, site: str, text: str) -> tuple:
    try:
        x, y, _ = (float(number) for number in text.split())
    except ValueError:
        raise ImportFailure(f'{mjcf}:1:1: --vehicle: pos="{text}" of site "{site}" (three numbers are needed)', USAGE) from None
    return x, y


def _inputs(document: dict) -> tuple:
    """Actuator kinds: those with a map, and throttle where only the hover input is known."""
    table = lambda name: document[name] if isinstance(document.get(name), dict) else {}  # noqa: E731
    maps = {key.split("_")[0] for key in table("actuator")}
    if "hover" in table("thrust"):
        maps.add("throttle")
    return tuple(sorted(maps))
