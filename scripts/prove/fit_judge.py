#!/usr/bin/env python3
"""Fits the judge of the diagnosis: the probability that a name is right, from the evidence record of each candidate.

    fit_judge.py collect --trials DIR ANSWERS [--trials ...] --semi DIR [--name diagnosis] --out records.jsonl
    fit_judge.py fit records.jsonl [--out judge.toml]

`collect` reads the records (`evidence` of diagnosis.json) of trials of the independent reality and of semi-real cases, and
says of each whether the name is true; records of which nobody knows are left out. `fit` is a logistic model on the
record's features, each between 0 (against) and 1 (for the name), with weights that cannot be negative: more evidence never
lowers the probability. Families (a semi-real set; one roughness of the reality's air) are left out in turn for everything
that is printed: log loss, reliability, expected calibration error. Every family has the same weight, and so has every trial in
it. The last line of defence against a separable sample is a ridge, chosen by the same cross-validation.
"""

import argparse
import json
from collections import defaultdict
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

RIDGES = (0.3, 1.0, 3.0, 10.0)
SHOWN = 0.5                   # names below this are neither named nor suspected: calibration is judged from here on


# ---- records with their truth -------------------------------------------------------------------------------------------

def labels_of(effect, rotor):
    return {effect, f"{effect}#{int(rotor)}"} if rotor else {effect}


def record_label(record):
    return record["effect"] + (f"#{record['rotor']}" if record.get("rotor") else "")


def classes_of(diagnosis):
    """{name: its class} of everything that is named or suspected."""
    named = diagnosis["effects"] + diagnosis.get("suspected", [])
    return {effect["effect"]: set(effect["class"]) for effect in named}


def truth_of(record, true, classes):
    """1 if the name, or one of its class, is true; a rotor's name must be that rotor's."""
    name = record_label(record)
    if name in true or (record["effect"] in true and "#" not in name):
        return 1
    return int(bool(classes.get(record["effect"], set()) & true))


def trial_records(folder, answers, name):
    """Records of sealed trials; a gust is nobody's truth in outdoor air."""
    for line in answers.read_text(encoding="utf-8").splitlines():
        answer = json.loads(line)
        path = folder / answer["trial"] / name / "diagnosis.json"
        if not path.exists():
            continue
        diagnosis, air = json.loads(path.read_text(encoding="utf-8")), answer.get("air", {"roughness": 1.0, "kind": "steady"})
        true = set().union(*(labels_of(e["effect"], e["parameters"].get("rotor")) for e in answer["effects"])) if answer["effects"] else set()
        if any("#" in label for label in true):
            true = {label for label in true if label != "rotor_loss"}
        for record in diagnosis.get("evidence", []):
            if record["effect"] == "gust" and air["kind"] == "outdoor":
                continue
            yield {"family": f"reality {air['roughness']:g}", "trial": f"{folder.name}/{answer['trial']}", "kind": answer["kind"],
                   "truth": truth_of(record, true, classes_of(diagnosis)), **record}


def semi_real_records(folder):
    """Records of semi-real cases: all of them against reference flights; against the file only that of what is concealed, since
    nobody knows what else a real flight holds."""
    for path in sorted(folder.glob("*/*/truth.json")):
        case, found = json.loads(path.read_text(encoding="utf-8")), path.parent / "diagnosis" / "diagnosis.json"
        if not found.exists():
            continue
        diagnosis = json.loads(found.read_text(encoding="utf-8"))
        true = {f"{case['truth']}#{case['rotor']}" if case["rotor"] else case["truth"]} if case["truth"] else set()
        for record in diagnosis.get("evidence", []):
            truth = truth_of(record, true, classes_of(diagnosis))
            if case["asked"] == "reference" or truth:
                yield {"family": f"semi-real {case['set']}", "trial": f"{case['set']}/{case['name']}", "kind": case["way"], "truth": truth, **record}


# ---- the model ------------------------------------------------------------------------------------------------------------

class Sample:
    """Features (n, k), truth (n,), families (n,) and weights (n,) of records; a feature that a record lacks counts one half."""

    def __init__(self, records):
        self.names = sorted({name for record in records for name in record["features"]})
        value = lambda record, name: 0.5 if record["features"].get(name) is None else record["features"][name]
        self.x = np.array([[value(record, name) for name in self.names] for record in records])
        self.y = np.array([record["truth"] for record in records], dtype=float)
        self.family = np.array([record["family"] for record in records])
        trials = [(record["family"], record["trial"]) for record in records]
        in_trial, in_family = defaultdict(int), defaultdict(set)
        for family, trial in trials:
            in_trial[family, trial] += 1
            in_family[family].add(trial)
        self.weight = np.array([1 / (in_trial[key] * len(in_family[key[0]])) for key in trials])
        self.weight *= len(self.y) / self.weight.sum()


def probability(model, x):
    return 1 / (1 + np.exp(-(model[0] + x @ model[1:])))


def fit_logistic(x, y, weight, ridge):
    """[intercept, weights ≥ 0] of the least weighted log loss + ridge |weights|²/2."""
    def loss(model):
        z = model[0] + x @ model[1:]
        p = 1 / (1 + np.exp(-z))
        slope = weight * (p - y)
        return np.sum(weight * (np.logaddexp(0, z) - y * z)) + 0.5 * ridge * model[1:] @ model[1:], np.r_[slope.sum(), x.T @ slope + ridge * model[1:]]
    bounds = [(None, None)] + [(0, None)] * x.shape[1]
    return minimize(loss, np.zeros(x.shape[1] + 1), jac=True, bounds=bounds, method="L-BFGS-B").x


def left_out(sample, ridge):
    """Probability of every record by a model that has not seen its family."""
    p = np.empty(len(sample.y))
    for family in np.unique(sample.family):
        out = sample.family == family
        p[out] = probability(fit_logistic(sample.x[~out], sample.y[~out], sample.weight[~out], ridge), sample.x[out])
    return p


def log_loss(p, y, weight):
    p = np.clip(p, 1e-6, 1 - 1e-6)
    return float(-np.sum(weight * (y * np.log(p) + (1 - y) * np.log(1 - p))) / weight.sum())


def reliability(p, y, bins=10, low=SHOWN):
    """[(n, mean stated, share right)] of equally filled bins of p ≥ low, and the expected calibration error over them."""
    shown = np.flatnonzero(p >= low)
    parts = [part for part in np.array_split(shown[np.argsort(p[shown], kind="stable")], bins) if len(part)]
    rows = [(len(part), float(p[part].mean()), float(y[part].mean())) for part in parts]
    error = sum(n * abs(said - right) for n, said, right in rows) / max(1, len(shown))
    return rows, error


def fit(records):
    """The model on all records, its ridge, and what cross-validation by family says of it."""
    sample = Sample(records)
    if len(np.unique(sample.family)) < 2:
        raise SystemExit("fit_judge: one family alone cannot be left out")
    tried = {ridge: left_out(sample, ridge) for ridge in RIDGES}
    ridge = min(RIDGES, key=lambda r: log_loss(tried[r], sample.y, sample.weight))
    return sample, ridge, fit_logistic(sample.x, sample.y, sample.weight, ridge), tried[ridge]


def report(sample, ridge, model, p):
    rows, error = reliability(p, sample.y)
    named, suspected = p >= 0.8, (p >= SHOWN) & (p < 0.8)
    lines = [f"{len(sample.y)} records, {int(sample.y.sum())} true names, {len(np.unique(sample.family))} families; ridge {ridge:g}",
             f"left out by family: log loss {log_loss(p, sample.y, sample.weight):.4f}, expected calibration error from {SHOWN} on {error:.3f}",
             f"at 0.8: {int(np.sum(named & (sample.y == 1)))} of {int(sample.y.sum())} true named, {int(np.sum(named & (sample.y == 0)))} wrong; "
             f"suspected {int(np.sum(suspected & (sample.y == 1)))} true, {int(np.sum(suspected & (sample.y == 0)))} wrong",
             "", "| stated | right | N |", "| --- | --- | --- |", *(f"| {said:.3f} | {right:.3f} | {n} |" for n, said, right in rows),
             "", "| family | records | true | log loss | true named | wrong named |", "|" + " --- |" * 6]
    for family in np.unique(sample.family):
        own = sample.family == family
        lines.append(f"| {family} | {own.sum()} | {int(sample.y[own].sum())} | {log_loss(p[own], sample.y[own], sample.weight[own]):.3f} | "
                     f"{int(np.sum(own & named & (sample.y == 1)))} | {int(np.sum(own & named & (sample.y == 0)))} |")
    lines += ["", "| feature | weight |", "| --- | --- |", f"| (intercept) | {model[0]:.3f} |",
              *(f"| {name} | {weight:.3f} |" for name, weight in sorted(zip(sample.names, model[1:]), key=lambda pair: -pair[1]))]
    return "\n".join(lines) + "\n"


def judge_toml(sample, model, error):
    lines = ["# written by scripts/prove/fit_judge.py: logistic on the features of an evidence record, weights not negative",
             f"# {len(sample.y)} records of {len(np.unique(sample.family))} families; expected calibration error by family {error:.3f}",
             f"intercept = {model[0]:.4f}", "", "[weights]"]
    return "\n".join(lines + [f"{name} = {weight:.4f}" for name, weight in zip(sample.names, model[1:])]) + "\n"


def read_records(path):
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines() if line.strip()]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    collecting = commands.add_parser("collect")
    collecting.add_argument("--trials", nargs=2, action="append", type=Path, default=[], metavar=("DIR", "ANSWERS"))
    collecting.add_argument("--semi", action="append", type=Path, default=[], metavar="DIR")
    collecting.add_argument("--name", default="diagnosis", help="folder of the diagnosis in each trial")
    collecting.add_argument("--out", type=Path, required=True)
    fitting = commands.add_parser("fit")
    fitting.add_argument("records", type=Path)
    fitting.add_argument("--out", type=Path)
    options = parser.parse_args()
    if options.command == "collect":
        records = [record for folder, answers in options.trials for record in trial_records(folder, answers, options.name)]
        records += [record for folder in options.semi for record in semi_real_records(folder)]
        options.out.write_text("".join(json.dumps(record) + "\n" for record in records), encoding="utf-8")
        print(f"{len(records)} records, {sum(record['truth'] for record in records)} true")
        return
    sample, ridge, model, p = fit([record for record in read_records(options.records) if record.get("features")])
    print(report(sample, ridge, model, p), end="")
    if options.out:
        options.out.write_text(judge_toml(sample, model, reliability(p, sample.y)[1]), encoding="utf-8")


if __name__ == "__main__":
    main()
