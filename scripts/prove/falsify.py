"""Vehicle folders that can be made wrong on purpose."""

import json
import tomllib
import xml.etree.ElementTree as xml
from pathlib import Path

# what is one value per flight, or no physics of the vehicle, does not go into a vehicle file
NOT_OF_THE_VEHICLE = {"steady_wind", "constant_force", "gust", "measurement_noise"}


def toml_value(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml_value(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    return json.dumps(value) if isinstance(value, (str, bool, int)) else repr(float(value))


def vehicle_text(table):
    """A vehicle.toml that reads back as `table`."""
    lines = [f"{key} = {toml_value(value)}" for key, value in table.items() if not isinstance(value, (dict, list))]
    for key, value in table.items():
        if isinstance(value, dict):
            lines += [f"[{key}]"] + [f"{name} = {toml_value(item)}" for name, item in value.items()]
        elif isinstance(value, list):
            for entry in value:
                lines += [f"[[{key}]]"] + [f"{name} = {toml_value(item)}" for name, item in entry.items()]
    return "\n".join(lines) + "\n"


class VehicleFolder:
    """A vehicle as two documents that can be changed and written elsewhere."""

    def __init__(self, path):
        path = Path(path)
        self.table = tomllib.loads(path.read_text(encoding="utf-8"))
        self.mjcf = xml.parse(path.parent / self.table["mjcf"])

    @property
    def inertial(self):
        return next(body.find("inertial") for body in self.mjcf.getroot().iter("body") if body.find("inertial") is not None)

    def effect(self, name):
        return next((e for e in self.table.get("effect", []) if e["type"] == name), None)

    def add_found(self, diagnosis):
        """Puts what a diagnosis found (totals, calibration and turning directions included) into the vehicle."""
        if any(f["kind"] == "sign" and f["column"] == "rotor.direction" for f in diagnosis["log_findings"]):
            for rotor in self.table["rotor"]:
                rotor["direction"] = "cw" if rotor["direction"] == "ccw" else "ccw"
        for found in diagnosis["effects"] + diagnosis.get("calibration", []):
            if found["effect"] in NOT_OF_THE_VEHICLE:
                continue
            entry = {"type": found["effect"]}
            for name, number in found["parameters"].items():
                entry[name] = int(number["value"]) if name == "rotor" else number["value"]
            same = lambda old: old["type"] == entry["type"] and old.get("rotor") == entry.get("rotor")
            self.table["effect"] = [old for old in self.table.get("effect", []) if not same(old)] + [entry]

    def remove(self, name):
        self.table["effect"] = [effect for effect in self.table["effect"] if effect["type"] != name]

    def scale_inertial(self, attribute, factor):
        numbers = [factor * float(x) for x in self.inertial.get(attribute).split()]
        self.inertial.set(attribute, " ".join(repr(float(x)) for x in numbers))

    def move_center(self, by):
        position = [float(x) for x in self.inertial.get("pos", "0 0 0").split()]
        self.inertial.set("pos", " ".join(repr(float(x + d)) for x, d in zip(position, by)))

    def write(self, folder):
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "vehicle.toml").write_text(vehicle_text(self.table), encoding="utf-8")
        self.mjcf.write(folder / self.table["mjcf"], encoding="unicode")
