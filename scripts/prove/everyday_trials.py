#!/usr/bin/env python3
"""Flights as a new user makes them: two runs of this program's own simulator, one effect or none, diagnosed without further options.

    everyday_trials.py --seed 1 --count 60 --out DIR [--effects usual|turning] [--gustlab BIN] [--jobs 1]

Vehicle, two trajectories, controller, log rate, sensor noise and gust are drawn; the first flight is fitted, the second held out. They excite
less than a test flight, two thirds of them are logged slower than the loop, and a third have no sensor noise at all: nothing of this is
chosen so that a diagnosis succeeds. Writes DIR/<trial>/{experiment.toml,<trajectory>/,diagnosis/}, DIR/results.jsonl, and prints tables.
"""

import argparse
import concurrent.futures
import json
import random
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path

from flight_files import HOME
from outcomes import by_effect, by_value, counted, label, means, others, table
from run_trials import run_measured

VEHICLES = ("crazyflie", "crazyflie_21", "crazyflie_real", "imrc_brushed", "imrc_brushless", "iris", "neuralfly_tunnel", "neurobem_racer")
TRAJECTORIES = ("lemniscate", "circle", "multisine", "spiral", "hover")
CONTROLLERS = ("pid", "indi", "geometric", "l1", "mpc")
# of everyone's size: weight N, arm m; a drag comes on top of the vehicle file's
EFFECTS = {
    "none": lambda weight, arm: [],
    "mass": lambda weight, arm: [{"type": "mass", "delta": 0.1}],
    "thrust_scale": lambda weight, arm: [{"type": "thrust_scale", "delta": -0.08}],
    "rotor_drag": lambda weight, arm: [{"type": "rotor_drag", "at_hover": 0.05 * weight}],
    "steady_wind": lambda weight, arm: [{"type": "rotor_drag", "at_hover": 0.05 * weight}, {"type": "steady_wind", "x": 2.0}],
    "motor_lag": lambda weight, arm: [{"type": "motor_lag", "time_constant": 0.06}],
    "actuation_delay": lambda weight, arm: [{"type": "actuation_delay", "delay": 0.03}],
    "center_of_mass": lambda weight, arm: [{"type": "center_of_mass", "x": 0.06 * arm}],
    "rotor_loss": lambda weight, arm: [{"type": "rotor_loss", "rotor": 2, "loss": 0.12}],
}
# what shows in how the vehicle turns, or in its sensors alone
TURNING = {
    "inertia": lambda weight, arm: [{"type": "inertia", "delta_x": 0.3, "delta_y": 0.3, "delta_z": 0.3}],
    "yaw_torque_ratio": lambda weight, arm: [{"type": "yaw_torque_ratio", "delta": -0.3}],
    "gyro_scale": lambda weight, arm: [{"type": "gyro_scale", "delta": 0.04}],
    "attitude_offset": lambda weight, arm: [{"type": "attitude_offset", "x": 0.02, "y": -0.01}],
    "imu_lever": lambda weight, arm: [{"type": "imu_lever", "x": 0.3 * arm, "z": -0.2 * arm}],
}
KINDS = {"usual": EFFECTS, "turning": TURNING}
NOISE = {"type": "measurement_noise", "position_sd": 0.002, "attitude_sd": 0.002, "rate_sd": 0.01, "accelerometer_sd": 0.05}
OUTCOMES = ("exact", "some", "withheld", "nothing", "wrong", "failed")


@cache
def facts(gustlab, vehicle):
    """(weight N, arm m, the vehicle file's own drag of its rotors N s/m)"""
    # exit 1: the paper's iris contradicts itself, and flies
    said = json.loads(subprocess.run([gustlab, "vehicle", "check", vehicle, "--format", "json"], capture_output=True, check=False).stdout)
    file = tomllib.loads((HOME / "models" / vehicle / "vehicle.toml").read_text(encoding="utf-8"))
    return said["weight_N"], said["arm_m"], sum(effect["at_hover"] for effect in file.get("effect", []) if effect["type"] == "rotor_drag")


def draw(seed, number, effects=EFFECTS):
    choose = random.Random(f"{seed} {number}")
    return {"trial": f"trial_{number:04}", "seed": 1000 * seed + number, "vehicle": choose.choice(VEHICLES),
            "trajectories": choose.sample(TRAJECTORIES, 2), "controller": choose.choice(CONTROLLERS), "effect": choose.choice(sorted(effects)),
            "log": choose.choice(("at the loop's rate", "50 Hz", "100 Hz")), "noise": "noise" if choose.random() < 2 / 3 else "no noise",
            "gust": "gust" if choose.random() < 0.5 else "calm"}


def inline(effect):
    return "{" + ", ".join(f"{key} = {json.dumps(value)}" for key, value in effect.items()) + "}"


def experiment(drawn, weight, arm, drag):
    """(the TOML, the effects that are concealed)"""
    # an effect of an experiment replaces that of the vehicle file
    hidden = [{**effect, "at_hover": drag + effect["at_hover"]} if effect["type"] == "rotor_drag" else effect
              for effect in (EFFECTS | TURNING)[drawn["effect"]](weight, arm)]
    around = [NOISE] if drawn["noise"] == "noise" else []
    if drawn["gust"] == "gust":
        around.append({"type": "gust", "sigma_xy": 0.02 * weight, "sigma_z": 0.01 * weight})
    lines = ['format = "gustlab-experiment/1"', 'name = "everyday"', f'vehicle = "{drawn["vehicle"]}"', f"trajectories = {json.dumps(drawn['trajectories'])}",
             f'controllers = ["{drawn["controller"]}"]', "duration_s = 15", f"effect = [{', '.join(map(inline, hidden + around))}]"]
    if drawn["vehicle"] == "iris":
        lines.append("step_s = 0.0025")   # its loop runs at 400 Hz
    if drawn["log"] != "at the loop's rate":
        lines.append(f"log_rate_hz = {drawn['log'].split()[0]}")
    return "\n".join(lines) + "\n", hidden


def judge(drawn, hidden, found):
    names = [(effect["type"], effect.get("rotor")) for effect in hidden]
    allowed = names + ([("gust", None)] if drawn["gust"] == "gust" else [])
    row = counted(found, names, lambda finding: any(means(finding, *name) for name in allowed), label, "some", "nothing")
    return {**drawn, "truth": [drawn["effect"]], **row}


def trial(number, options):
    drawn = draw(options.seed, number, KINDS[options.effects])
    place = options.out / drawn["trial"]
    place.mkdir(parents=True, exist_ok=True)
    text, hidden = experiment(drawn, *facts(options.gustlab, drawn["vehicle"]))
    (place / "experiment.toml").write_text(text, encoding="utf-8")
    found = place / "diagnosis" / "diagnosis.json"
    if not found.exists():
        for name in drawn["trajectories"]:
            run_measured([options.gustlab, "run", str(place / "experiment.toml"), "--trajectory", name, "--seed", str(drawn["seed"]),
                          "--out", str(place / name)], place / "messages.txt")
        logs = [str(place / name / "flight.csv") for name in drawn["trajectories"]]
        run_measured(["timeout", "600", options.gustlab, "diagnose", logs[0], "--holdout", logs[1], "--out", str(found.parent), "--jobs", "1"],
                     place / "messages.txt")
    return judge(drawn, hidden, json.loads(found.read_text(encoding="utf-8")) if found.exists() else None)


def markdown(rows):
    def told(chosen):
        return str(sum(row.get("verdict") == "insufficient_data" for row in chosen))

    lines = table("all", [("all", rows)], OUTCOMES, "said to be too little", told)
    for key in ("noise", "log", "gust", "controller", "vehicle"):
        lines += table(key, by_value(rows, key), OUTCOMES, "said to be too little", told)
    lines += table("concealed", by_effect(rows), OUTCOMES, "said to be too little", told)
    return "\n".join(lines + others(rows, ("vehicle", "controller", "log", "noise", "gust"), ("named", "suspected"), lambda name, row, k: name)) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--effects", choices=KINDS, default="usual", help="what is concealed: the usual suspects, or what shows in turning and sensors alone")
    parser.add_argument("--gustlab", default=str(HOME / "build/release/gustlab"))
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        rows = list(pool.map(lambda number: trial(number, options), range(1, options.count + 1)))
    (options.out / "results.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="utf-8")
    sys.stdout.write(markdown(rows))


if __name__ == "__main__":
    main()
