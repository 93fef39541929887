#!/usr/bin/env python3
"""The naive way, for comparison: sparse regression (STLSQ) of the equation error on the same catalogue.

    naive_baseline.py FIT.csv... [--holdout FLIGHT.csv]... --out DIR [--gustlab BIN]

Accelerations come from local polynomials, m a − thrust and J dω/dt − torque are regressed on one column per parameter
(equation_error.py), coefficients in natural units below a threshold are dropped and the rest fitted again (Brunton et al.,
PNAS 113, 2016), groups of one effect together. The threshold is the largest whose error on the flight that was left out is
within one standard error of the least (Hastie et al., The Elements of Statistical Learning, 7.10). An effect below our own
reporting tolerance is not named, so that calibration scatter is not held against the method. Writes diagnosis.json in the shape of
ours; with --gustlab the held-out errors are measured by the same `gustlab replay`. Not in its library: effects that are
not linear in a parameter (saturation, slung_load, gust), and those that these equations do not show (imu_lever, gyro_scale).
"""

import argparse
import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np

from equation_error import Equations
from flight_files import read_log, read_vehicle, rotor_speed, sidecar_of, vehicle_path

PER_FLIGHT = {"constant_force", "steady_wind"}
# natural size, reporting tolerance, and what a vehicle's size multiplies them with: those of the catalogue
SCALES = {"one": lambda v: 1.0, "weight": lambda v: v.weight, "arm": lambda v: v.arm, "yaw_inertia": lambda v: v.inertia[2],
          "torque_per_speed": lambda v: v.weight * v.arm / (len(v.hub) * v.hover_speed)}
NATURAL = {
    "rotor_drag": (0.016, 0, "weight", "N s/m"), "quadratic_drag": (0.03, 0, "weight", "m^2"),
    "axial_inflow": (0.05, 0, "weight", "N s/m"), "translational_lift": (0.007, 0, "arm", "kg/m"),
    "flapping_torque": (3e-6, 0, "arm", "N s^2"), "ground_effect": (5, 0, "one", "-"), "ceiling_effect": (5, 0, "one", "-"),
    "wall_effect": (0.02, 0, "one", "-"), "steady_wind": (1, 0, "one", "m/s"), "constant_force": (0.02, 0, "weight", "N"),
    "mass": (0.05, 0.012, "one", "-"), "center_of_mass": (0.02, 0.003, "arm", "m"), "inertia": (0.05, 0.05, "one", "-"),
    "thrust_scale": (0.05, 0.012, "one", "-"), "rotor_loss": (0.05, 0.01, "one", "-"), "rotor_tilt": (0.01, 0, "one", "rad"),
    "motor_lag": (0.01, 0.004, "one", "s"), "actuation_delay": (0.005, 0.003, "one", "s"), "thrust_curve": (0.05, 0, "one", "-"),
    "battery_sag": (0.5, 0, "one", "-"), "yaw_torque_ratio": (0.05, 0.05, "one", "-"),
    "rotor_inertia": (1e-3, 0, "yaw_inertia", "kg m^2"), "attitude_offset": (0.01, 0, "one", "rad"),
    "yaw_offset": (0.01, 0, "one", "rad"), "pose_delay": (0.005, 0.003, "one", "s")}
THRESHOLDS = np.geomspace(0.03, 3.0, 13)  # in natural units


def kind(effect):
    return effect.split("#")[0]


def build(flights, vehicle):
    """Whitened rows (n,), columns (n, p) in natural units, what each is: (effect, parameter, flight), rows of each flight."""
    equations = [Equations(log, vehicle, speed) for log, speed in flights]
    residuals = [e.residual() for e in equations]
    edge = [max(4, round(0.1 / e.dt)) for e in equations]
    noise = np.array([1.4826 * np.median(np.abs(c - np.median(c))) for c in np.concatenate(residuals).T])
    labels, parts = [], []
    per_flight_columns = [e.columns() for e in equations]
    for effect, name in dict.fromkeys(key for columns in per_flight_columns for key in columns):
        copies = range(len(flights)) if effect in PER_FLIGHT else [None]
        natural, _, scale, _ = NATURAL[kind(effect)]
        for flight in copies:
            blocks = [columns.get((effect, name), np.zeros_like(r)) * (flight in (None, n))
                      for n, (columns, r) in enumerate(zip(per_flight_columns, residuals))]
            labels.append((effect, name, flight))
            parts.append([natural * SCALES[scale](vehicle) * b for b in blocks])
    flat = lambda blocks: np.concatenate([(b / noise)[k:-k].ravel() for b, k in zip(blocks, edge)])
    y, X = flat(residuals), np.column_stack([flat(blocks) for blocks in parts])
    finite = np.isfinite(y) & np.isfinite(X).all(1)
    ends = np.cumsum([6 * (len(r) - 2 * k) for r, k in zip(residuals, edge)])
    rows = [np.flatnonzero(finite[begin:end]) + begin for begin, end in zip([0, *ends[:-1]], ends)]
    return y, X, labels, rows


def stlsq(gram, right, groups, threshold):
    """Sequentially thresholded least squares on groups; the kept columns and their coefficients."""
    kept = list(groups)
    while kept:
        columns = [c for g in kept for c in groups[g]]
        coefficient = np.linalg.solve(gram[np.ix_(columns, columns)] + 1e-6 * np.diag(np.diag(gram)[columns] + 1e-12), right[columns])
        value = dict(zip(columns, coefficient))
        stays = [g for g in kept if max(abs(value[c]) for c in groups[g]) >= threshold]
        if stays == kept:
            return columns, coefficient
        kept = stays
    return [], np.zeros(0)


def select(y, X, labels, folds):
    groups = {}
    for c, (effect, _, _) in enumerate(labels):
        if np.any(X[:, c]):
            groups.setdefault(effect, []).append(c)
    pieces = [(X[f].T @ X[f], X[f].T @ y[f], y[f] @ y[f], len(f)) for f in folds]
    gram, right, total, n = (sum(piece[k] for piece in pieces) for k in range(4))
    errors = np.empty((len(THRESHOLDS), len(folds)))
    for t, threshold in enumerate(THRESHOLDS):
        for f, (own_gram, own_right, own_total, own_n) in enumerate(pieces):
            columns, coefficient = stlsq(gram - own_gram, right - own_right, groups, threshold)
            # what belongs to the flight that was left out cannot be known from the others
            own = [c for c in columns if labels[c][2] is not None]
            coefficient = np.where(np.isin(columns, own), 0.0, coefficient) if columns else coefficient
            errors[t, f] = (own_total - 2 * coefficient @ own_right[columns]
                            + coefficient @ own_gram[np.ix_(columns, columns)] @ coefficient) / own_n if columns else own_total / own_n
    mean, spread = errors.mean(1), errors.std(1, ddof=1) / math.sqrt(len(folds)) if len(folds) > 1 else 0 * errors[:, 0]
    best = int(np.argmin(mean))
    chosen = max(t for t in range(len(THRESHOLDS)) if mean[t] <= mean[best] + spread[best])
    columns, coefficient = stlsq(gram, right, groups, THRESHOLDS[chosen])
    if not columns:
        return [], np.zeros(0), np.zeros(0)
    rss = total - coefficient @ right[columns]
    return columns, coefficient, np.sqrt(rss / n * np.diag(np.linalg.pinv(gram[np.ix_(columns, columns)])))


def describe(columns, coefficient, spread, labels, vehicle, files):
    """Findings above their tolerance, in the shape of diagnosis.json."""
    own = {e["type"]: e for e in vehicle.effects}
    found = {}
    for column, value, std in zip(columns, coefficient, spread):
        effect, name, flight = labels[column]
        natural, tolerance, scale, unit = NATURAL[kind(effect)]
        size = SCALES[scale](vehicle)
        entry = found.setdefault(effect, {"parameters": {}, "per_flight": {}, "material": False, "z": 0.0})
        entry["z"] = max(entry["z"], abs(value) / max(std, 1e-300))
        entry["material"] |= abs(value) * natural >= tolerance
        total = value * natural * size + own.get(kind(effect), {}).get(name, 0.0)
        number = {"value": total, "std": std * natural * size, "unit": unit}
        names = ["time_constant", "time_constant_down"] if name == "time_constant" else [name]
        for key in names:
            if flight is None:
                entry["parameters"][key] = number
            else:
                entry["per_flight"].setdefault(files[flight], {})[key] = number
    effects = []
    for effect, entry in found.items():
        if not entry["material"]:
            continue
        result = {"effect": kind(effect), "confidence": math.erf(entry["z"] / math.sqrt(2)), "parameters": entry["parameters"],
                  "class": [kind(effect)]}
        if "#" in effect:
            result["parameters"]["rotor"] = {"value": int(effect.split("#")[1]), "std": 0, "unit": "-"}
        if entry["per_flight"]:
            result["per_flight"] = entry["per_flight"]
            for key in next(iter(entry["per_flight"].values())):
                values = [flight[key] for flight in entry["per_flight"].values()]
                result["parameters"][key] = {"value": float(np.mean([v["value"] for v in values])),
                                             "std": float(np.mean([v["std"] for v in values]) / math.sqrt(len(values))),
                                             "unit": values[0]["unit"]}
        effects.append(result)
    return effects


def augmented(effects):
    text = ""
    for effect in effects:
        text += f'[[effect]]\ntype = "{effect["effect"]}"\n'
        for name, number in effect["parameters"].items():
            text += f"{name} = {number['value']!r}\n"
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("flights", nargs="+")
    parser.add_argument("--holdout", action="append", default=[])
    parser.add_argument("--vehicle", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--gustlab", help="measures held-out errors with its `replay`")
    options = parser.parse_args()
    logs = [read_log(path) for path in options.flights]
    path = options.vehicle or vehicle_path(logs[0].meta["vehicle"], sidecar_of(options.flights[0]).parent)
    vehicle = read_vehicle(path)
    flights = [(log, rotor_speed(log, vehicle)) for log in logs]
    if any(speed is None for _, speed in flights) or any("qw" not in log.column or "px" not in log.column for log in logs):
        print("naive_baseline: needs pose, gyroscope and rotor commands", file=sys.stderr)
        return 3
    y, X, labels, folds = build(flights, vehicle)
    columns, coefficient, spread = select(y, X, labels, folds)
    effects = describe(columns, coefficient, spread, labels, vehicle, [log.name for log in logs])
    result = {"format": "gustlab-diagnosis/1", "verdict": "explained" if effects else "consistent", "vehicle": vehicle.name,
              "effects": effects}
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "augmented.toml").write_text(augmented(effects), encoding="utf-8")
    if options.gustlab and options.holdout and effects:
        replay = subprocess.run([options.gustlab, "replay", *options.holdout, "--with", options.out / "augmented.toml",
                                 "--format", "json"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False)
        if replay.returncode == 0:
            result["fit"] = json.loads(replay.stdout)
    (options.out / "diagnosis.json").write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
