#!/usr/bin/env python3
"""Real flights against a vehicle file that was falsified on purpose: is exactly the falsification named?

    semi_real.py NAME --fit FLIGHT... --holdout FLIGHT... --vehicle vehicle.toml --gustlab BIN --out DIR [--jobs 2]

First the flights are diagnosed with the vehicle as it is, and what is found is put into it. That vehicle (trial `true`) shows
what is left; then each falsification of it must be named on top of that, and nothing else. Writes trials and answers in the
shape that `gustlab score` reads, and prints the score.
"""

import argparse
import json
import sys
from copy import deepcopy
from pathlib import Path

from falsify import VehicleFolder, copy_log, falsifications
from run_trials import diagnose, diagnose_sets, score

POSE_DELAY_s = 0.015


def build(folder, vehicle, fit, holdout, pose_delay_s=0.0):
    """One trial folder: recordings as fit_N and holdout_N, and the vehicle beside them."""
    if vehicle is not None:
        vehicle.write(folder / "vehicle")
    for role, flights in (("fit", fit), ("holdout", holdout)):
        for number, flight in enumerate(flights, 1):
            ending = ".csv.gz" if str(flight).endswith(".gz") else ".csv"
            copy_log(flight, folder / f"{role}_{number}{ending}", "vehicle/vehicle.toml", pose_delay_s)


def read(folder):
    path = folder / "diagnosis" / "diagnosis.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None


def named(diagnosis):
    """Findings as the truths of an answer."""
    truths = []
    for effect in diagnosis["effects"]:
        parameters = {"rotor": int(effect["parameters"]["rotor"]["value"])} if "rotor" in effect["parameters"] else {}
        truths.append({"effect": effect["effect"], "parameters": parameters})
    return truths


def merged(base, falsification):
    """A falsification on top of what is there anyway; the same effect (and rotor) is one truth."""
    same = lambda t: t["effect"] == falsification["effect"] and t["parameters"].get("rotor") == falsification["parameters"].get("rotor")
    return [t for t in base if not same(t)] + [falsification]


def prepare(name, fit, holdout, vehicle_path, out, program, arguments):
    """Trial folders of one set of flights; (names of them, answers), or None when the flights cannot be diagnosed."""
    own = VehicleFolder(vehicle_path)
    build(out / f"{name}_as_is", own, fit, holdout)
    diagnose(out / f"{name}_as_is", "diagnosis", program, arguments)
    first = read(out / f"{name}_as_is")
    if first is None:
        return None
    true = deepcopy(own)
    true.add_found(first)
    build(out / f"{name}_true", true, fit, holdout)
    diagnose(out / f"{name}_true", "diagnosis", program, arguments)
    left = read(out / f"{name}_true")
    if left is None:
        return None
    base, answers = named(left), []
    for case, (change, truth) in falsifications(true).items():
        wrong = deepcopy(true)
        change(wrong)
        build(out / f"{name}_{case}", wrong, fit, holdout)
        answers.append({"trial": f"{name}_{case}", "kind": "semi_real", "vehicle": own.table["name"], "effects": merged(base, truth)})
    build(out / f"{name}_pose_late", true, fit, holdout, POSE_DELAY_s)
    truth = {"effect": "pose_delay", "parameters": {"delay": POSE_DELAY_s}}
    answers.append({"trial": f"{name}_pose_late", "kind": "semi_real", "vehicle": own.table["name"], "effects": merged(base, truth)})
    return {"first": named(first), "left": base, "answers": answers}


def run(sets, out, gustlab, jobs, arguments=()):
    """Sets: [(name, fit, holdout, vehicle)]. Returns what was there anyway per set, and the score of all falsifications."""
    program, answers, left = [gustlab, "diagnose"], [], {}
    for name, fit, holdout, vehicle in sets:
        prepared = prepare(name, fit, holdout, vehicle, out, program, list(arguments))
        left[name] = None if prepared is None else {key: prepared[key] for key in ("first", "left")}
        answers += [] if prepared is None else prepared["answers"]
    path = out / "answers.jsonl"
    path.write_text("".join(json.dumps(answer) + "\n" for answer in answers), encoding="utf-8")
    diagnose_sets([(out, path)], "diagnosis", program, list(arguments), jobs, keep=False)
    return left, json.loads(score([(out, path)], "diagnosis", gustlab, "json")), path


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name")
    parser.add_argument("--fit", nargs="+", type=Path, required=True)
    parser.add_argument("--holdout", nargs="+", type=Path, required=True)
    parser.add_argument("--vehicle", type=Path, required=True)
    parser.add_argument("--gustlab", default="build/release/gustlab")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    left, _, answers = run([(options.name, options.fit, options.holdout, options.vehicle)], options.out, options.gustlab, options.jobs)
    print(json.dumps(left))
    sys.stdout.write(score([(options.out, answers)], "diagnosis", options.gustlab))


if __name__ == "__main__":
    main()
