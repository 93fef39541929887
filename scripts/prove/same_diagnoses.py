#!/usr/bin/env python3
"""Diagnoses a kept list of flights with two programs and compares the bytes of diagnosis.json and augmented.toml.

    scripts/same_diagnoses.sh BEFORE AFTER [--full] [--only NAME,NAME] [--jobs 2] [--work DIR] [--flights DIR]

The list (CASES) holds concealed trials of every kind, drawn by the independent reality from development seeds, some of them as a
filtered or an inertial log; with --full also more of each and the recorded flights (GUSTLAB_FLIGHTS or --flights). What BEFORE
said is kept under --work by the program's SHA-256, so a second comparison costs half. Of a program and itself, each case is
diagnosed again. A case that ends with an error must end
with the same exit code and message.
"""

import argparse
import concurrent.futures
import difflib
import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
from flight_files import HOME
from real_flights import import_flights

COMPARED = ("diagnosis.json", "augmented.toml")
ATTITUDE = ("qw", "qx", "qy", "qz")
POSE = ("px", "py", "pz", "vx", "vy", "vz", *ATTITUDE)


def read(path):
    """{column: values}; an empty cell is NaN."""
    names = path.read_text(encoding="utf-8").split("\n", 1)[0].strip().split(",")
    return dict(zip(names, np.genfromtxt(path, delimiter=",", skip_header=1).T))


def write(path, log):
    cells = [[("" if np.isnan(value) else repr(float(value))) for value in column] for column in log.values()]
    path.write_text("\n".join([",".join(log), *map(",".join, zip(*cells))]) + "\n", encoding="utf-8")


def filtered(log):
    """As a recorder would write it that smooths the motion (Gaussian, 25 ms) and not the commands."""
    step_s = np.median(np.diff(log["time_s"]))
    half = round(0.1 / step_s)
    kernel = np.exp(-0.5 * (np.arange(-half, half + 1) * step_s / 0.025) ** 2)
    smooth = lambda values: np.convolve(np.pad(values, half, mode="edge"), kernel / kernel.sum(), mode="valid")
    log = {name: smooth(values) if name in (*POSE, "wx", "wy", "wz", "ax", "ay", "az") else values for name, values in log.items()}
    norm = np.sqrt(sum(log[name] ** 2 for name in ATTITUDE))
    return log | {name: log[name] / norm for name in ATTITUDE}


def inertial(log):
    """Gyro, accelerometer and commands alone."""
    return {name: values for name, values in log.items() if name not in POSE}


# name: (arguments of the draw, how the log is changed, whether it is in the small default list)
CASES = {
    "clean_cf": (["--seed", "31", "--kind", "clean", "--vehicle", "cf"], None, True),
    "pair_ir": (["--seed", "32", "--kind", "pair", "--vehicle", "ir"], None, True),
    "rotor_loss": (["--seed", "33", "--effect", "rotor_loss", "--strength-factor", "4"], None, True),
    "slung_load": (["--seed", "34", "--effect", "slung_load", "--strength-factor", "6"], None, True),
    "outside": (["--seed", "35", "--kind", "outside"], None, True),
    "filtered_drag": (["--seed", "36", "--effect", "rotor_drag", "--strength-factor", "8", "--vehicle", "cf"], filtered, True),
    "inertial_loss": (["--seed", "38", "--effect", "rotor_loss", "--strength-factor", "8"], inertial, True),
    # torques are doubted, and the forces are judged alone
    "inertial_flapping": (["--seed", "60", "--effect", "flapping_torque", "--strength-factor", "10"], inertial, True),
    "scatter": (["--seed", "38", "--kind", "scatter"], None, False),
    "gust": (["--seed", "39", "--effect", "gust", "--strength-factor", "6"], None, False),
    "steady_wind": (["--seed", "40", "--effect", "steady_wind", "--strength-factor", "6"], None, False),
    "saturation": (["--seed", "41", "--effect", "saturation", "--strength-factor", "6"], None, False),
    "motor_lag": (["--seed", "42", "--effect", "motor_lag", "--strength-factor", "4"], None, False),
    "pose_delay": (["--seed", "43", "--effect", "pose_delay", "--strength-factor", "4"], None, False),
    "battery_sag": (["--seed", "44", "--effect", "battery_sag", "--strength-factor", "4"], None, False),
    "noisy_inertia": (["--seed", "45", "--effect", "inertia", "--strength-factor", "4", "--noise", "2"], None, False),
    "mixed": (["--seed", "46", "--kind", "mixed"], None, False),
    "filtered_clean": (["--seed", "47", "--kind", "clean"], filtered, False),
    "inertial_clean": (["--seed", "48", "--kind", "clean"], inertial, False),
}
# recorded flights: family, how the held-out ones are called, most that are fitted
FAMILIES = {"nanodrone": ("train_*_run2*", 6), "nanobench": ("*trefoil*", 3), "arpl": ("*15*", 3), "crazypad": ("*add_weight*", 3)}


def draw(name, work, reality):
    """Flights to fit and to hold out of a case; drawn once."""
    arguments, change, _ = CASES[name]
    trial = work / "trials" / name / "trial001"
    if not trial.exists():
        subprocess.run([reality, "draw", "--count", "1", *arguments, "--out", trial.parent, "--answers", work / f"{name}.jsonl"],
                       check=True, stdout=subprocess.DEVNULL)
        for path in sorted(trial.glob("*.csv")) if change else ():
            write(path, change(read(path)))
    return sorted(trial.glob("fit_*.csv")), sorted(trial.glob("holdout_*.csv"))


def recorded(flights, work):
    """{name: (fit, holdout)} of the recorded families that are there."""
    with open(work / "import.txt", "w", encoding="utf-8") as messages:
        folders = import_flights(flights, work / "flights", messages)
    cases = {}
    for family, (held_out, most) in FAMILIES.items():
        paths = sorted(folders[family].glob("*.csv*")) if family in folders else []
        held = [p for p in paths if p.match(f"{held_out}.csv*")][:2]
        fit = [p for p in paths if p not in held][:most]
        if paths and not (fit and held):
            sys.exit(f"same_diagnoses: {family}: none of its flights is called {held_out}, or all are")
        if paths:
            cases[f"recorded_{family}"] = (fit, held)
    return cases


def diagnose(program, flights, out):
    """Bytes of what is compared, or exit code and message."""
    done = out / "ended"
    if not done.exists():
        fit, held = flights
        held = [text for path in held for text in ("--holdout", str(path))]
        out.mkdir(parents=True, exist_ok=True)
        ended = subprocess.run([program, "diagnose", "-q", *map(str, fit), *held, "--jobs", "1", "--out", str(out / "diagnosis")],
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        done.write_text(f"{ended.returncode}\n{ended.stderr if ended.returncode else ''}", encoding="utf-8")
    texts = {"exit code": done.read_text(encoding="utf-8")}
    for name in COMPARED:
        path = out / "diagnosis" / name
        texts[name] = path.read_text(encoding="utf-8") if path.exists() else ""
    return texts


def differences(name, before, after):
    lines = []
    for part, text in before.items():
        if text != after[part]:
            lines += difflib.unified_diff(text.splitlines(), after[part].splitlines(), f"before/{name}/{part}", f"after/{name}/{part}", lineterm="", n=2)
    return lines


def sha256_of(path):
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()[:16]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before"), parser.add_argument("after")
    parser.add_argument("--full", action="store_true", help="every case, and the recorded flights")
    parser.add_argument("--only", default="", help="names of cases")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--work", type=Path, default=HOME / "build" / "same_diagnoses")
    parser.add_argument("--reality", default=str(HOME / "build/release/tests/reality/reality"))
    parser.add_argument("--flights", type=Path, default=os.environ.get("GUSTLAB_FLIGHTS"))
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)
    os.environ.setdefault("GUSTLAB_HOME", str(HOME))

    wanted = [n for n in options.only.split(",") if n] or [n for n, case in CASES.items() if options.full or case[2]]
    cases = {name: draw(name, options.work, options.reality) for name in wanted if name in CASES}
    if options.flights and (options.full or any(n.startswith("recorded_") for n in wanted)):
        cases |= {n: c for n, c in recorded(Path(options.flights), options.work).items() if options.full or n in wanted}
    if unknown := [name for name in wanted if name not in cases]:
        sys.exit(f"same_diagnoses: {', '.join(unknown)}: no such case (or its flights are not there)")

    programs = {which: (program, options.work / sha256_of(program)) for which, program in (("before", options.before), ("after", options.after))}
    if programs["before"][1] == programs["after"][1]:  # the same program: it runs twice
        again = options.work / f"{sha256_of(options.after)}_again"
        shutil.rmtree(again, ignore_errors=True)
        programs["after"] = options.after, again
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        runs = {(which, name): pool.submit(diagnose, program, flights, out / name)
                for name, flights in cases.items() for which, (program, out) in programs.items()}
    differ = 0
    for name in cases:
        lines = differences(name, runs["before", name].result(), runs["after", name].result())
        differ += bool(lines)
        print(f"{name}: {'differs' if lines else 'same'}", *lines, sep="\n", flush=True)
    print(f"{len(cases) - differ} of {len(cases)} diagnoses are the same")
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
