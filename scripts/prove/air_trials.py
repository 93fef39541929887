#!/usr/bin/env python3
"""Trials of the independent reality in air of every roughness: their plan, and what is named exactly.

    air_trials.py DIR ANSWERS [--name diagnosis]

A trial is exact when every effect above its detection limit is named, itself or in the class that is named, and nothing that is
not there. An effect below its limit may be named or not; so may a gust in outdoor air, whose turbulence is as slow as one.
"""

import argparse
import json
from collections import defaultdict
from pathlib import Path

from outcomes import label, means

ROUGHNESS = (1.0, 1.8, 4.0, 10.0)            # of the air, over the quiet room
AIR_KINDS = ("steady", "gusty", "outdoor")
AIR_STRENGTHS = (1.5, 2.5, 4.0)              # of single effects and pairs, in limits in this air
AIR_TRIALS = {"clean": 20, "scatter": 10, "single": 40, "pair": 30, "outside": 20}
KINDS = {"single": "one effect", "pair": "two", "nothing": "nothing", "outside": "outside the catalogue"}


def air_parts(counts):
    """Trials of each kind over all roughnesses and kinds of air, mixed evenly, so that any first part of them is a sample."""
    order = sorted(((n + 0.5) / count, kind, n) for kind, count in counts.items() for n in range(count))
    air = lambda n: ["--roughness", f"{ROUGHNESS[n % 4]:g}", "--air", AIR_KINDS[(n // 4 + n) % 3]]
    strength = lambda kind, n: ["--strength-factor", f"{AIR_STRENGTHS[n // 2 % 3]:g}"] if kind in ("single", "pair") else []
    return [(1, ["--kind", kind, *air(n), *strength(kind, n)]) for _, kind, n in order]


def judge(answer, diagnosis):
    """(exact, wrong names) of one trial; without a diagnosis nothing is exact."""
    if diagnosis is None:
        return False, []
    there = [(e["effect"], e["parameters"].get("rotor"), e["strength_over_limit"] is None or e["strength_over_limit"] >= 1) for e in answer["effects"]]
    if answer["air"]["kind"] == "outdoor":
        there.append(("gust", None, False))
    missed = [name for name, rotor, needed in there if needed and not any(means(found, name, rotor) for found in diagnosis["effects"])]
    wrong = [label(found) for found in diagnosis["effects"] if not any(means(found, name, rotor) for name, rotor, _ in there)]
    return not missed and not wrong, wrong


def scored(folder, answers, name):
    """One row a trial: kind (nothing: clean and scatter), roughness, kind of air, exact, wrong names."""
    for line in answers.read_text(encoding="utf-8").splitlines():
        answer = json.loads(line)
        if "air" not in answer:
            continue
        path = folder / answer["trial"] / name / "diagnosis.json"
        diagnosis = json.loads(path.read_text(encoding="utf-8")) if path.exists() else None
        exact, wrong = judge(answer, diagnosis)
        yield {"trial": answer["trial"], "kind": "nothing" if answer["kind"] in ("clean", "scatter") else answer["kind"],
               "roughness": answer["air"]["roughness"], "air": answer["air"]["kind"], "exact": exact, "wrong": wrong,
               "diagnosed": diagnosis is not None}


def table(rows, key, says):
    counts = defaultdict(lambda: [0, 0])
    for row in rows:
        for group in (row[key], "all"):
            counts[group, row["kind"]][0] += row["exact"]
            counts[group, row["kind"]][1] += 1
    lines = [f"| {says} | " + " | ".join(KINDS.values()) + " |", "|" + " --- |" * (1 + len(KINDS))]
    groups = sorted({row[key] for row in rows}) + ["all"]
    lines += [f"| {group:g} × |" if isinstance(group, float) else f"| {group} |" for group in groups]
    cell = lambda group, kind: f"{counts[group, kind][0]} of {counts[group, kind][1]}"
    return lines[:2] + [line + "".join(f" {cell(group, kind)} |" for kind in KINDS) for line, group in zip(lines[2:], groups)]


def markdown(rows):
    return "\n".join([*table(rows, "roughness", "air, over a quiet room"), "", *table(rows, "air", "kind of air")]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("answers", type=Path)
    parser.add_argument("--name", default="diagnosis")
    options = parser.parse_args()
    rows = list(scored(options.folder, options.answers, options.name))
    print(markdown(rows))
    for row in rows:
        if not row["exact"]:
            what = f"wrong {', '.join(row['wrong']) or '–'}" if row["diagnosed"] else "no diagnosis"
            print(f"- {row['trial']} {row['kind']}, {row['roughness']:g} × {row['air']}: {what}")


if __name__ == "__main__":
    main()
