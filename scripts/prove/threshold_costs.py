#!/usr/bin/env python3
"""What thresholds of the table of decisions cost: false names and misses with each a step down and a step up.

    threshold_costs.py [--only NAME,NAME] [--count 12] [--seed 47000] [--flights DIR] [--jobs 2] [--work DIR]

The program is compiled once more, with a table (src/diagnosis/result/decisions.hpp) whose numbers the environment may replace:
GUSTLAB_DECISION_<name>=<value>. Its trials are of two kinds. "air": the first --count trials of the independent reality's mixture
in moving air (air_trials.py) from --seed. "hover": the flights of CrazyPAD (docs/DATA.md), each against a normal flight: normal
ones, the defects that its authors made, and losses of each rotor, concealed in the commands of normal flights. What decides by the
confidence alone ("confidence") is read from the diagnoses of "air" as they are. A line says how
many trials with something there are exact, how many trials have a wrong name, and in how many trials with nothing there (or
nothing that a catalogue holds) the verdict is another one than it should be.
"""

import argparse
import concurrent.futures
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
from air_trials import AIR_TRIALS, air_parts, judge
from flight_files import HOME
from outcomes import means
from prove import Draw, draw_sets
from real_flights import import_flights
from run_trials import diagnose_sets

TABLE = "diagnosis/result/decisions.hpp"
# threshold: (kind of trials, a step down, a step up); several that stand for one decision move together
STEPS = {
    "hover_significance": ("hover", 1e-5, 0.05), "flight_to_flight": ("hover", 0.013, 0.03), "flight_to_flight_counts": ("hover", 2.0, 8.0),
    "number_costs": ("hover", 3.8, 10.8), "other_number_costs": ("hover", 1.0, 4.0), "often_limited": ("hover", 0.1, 0.5),
    "wald_p": ("air", 1e-5, 0.05), "relative_materiality": ("air", 5e-5, 2e-4),
    "scatter_margin": ("air", 1.0, 1.5), "trim_cost": ("air", 4.0, 16.0), "most_lost_to_rival": ("air", 0.25, 0.75),
    "hopeless": ("air", 0.02, 0.1), "named_from": ("confidence", 0.7, 0.9), "surely_needed": ("air", 1.0, 3.0),
    "beyond_chance_sd": ("air", 4.0, 9.0), "most_correlation": ("air", 0.1, 0.2), "most_of_floor": ("air", 1.8, 3.5),
    "explained_share": ("air", 0.05, 0.2), "lasting_correlation": ("air", 0.07, 0.15), "least_share_of_floor": ("air", 0.25, 0.5),
}
LOSSES = (0.10, 0.20, 0.30)
# folder of CrazyPAD: (flights, what is wrong there)
PAD = {"normal_flight": (("E8_log00", "E8_log01", "E9_log00", "E9_log03"), None), "cut_propeller_M3_3mm_3mm_41mm": (("E8_log00", "E8_log01"), "rotor_loss"),
       "add_weight_W3_near_M3": (("E9_log00", "E9_log02"), "center_of_mass")}
PWM_THRUST, MOST_PWM = (2.130295e-11, 1.032633e-6, 5.48e-4), 65535  # N, as the data set publishes it


# ---- a program whose thresholds can be moved ----------------------------------------------------------------------------

def movable(table):
    """The table as text, with every floating-point number replaceable by the environment."""
    def one(match):
        return "inline const double " + re.sub(r"(\w+)\s*=\s*([^,;]+)", r'\1 = moved("GUSTLAB_DECISION_\1", \2)', match[1]) + ";"
    text = re.sub(r"^inline constexpr double ([^;]*);", one, table, flags=re.MULTILINE)
    return text.replace("#include <cstddef>", "#include <cstddef>\n#include <cstdlib>").replace(
        "namespace gustlab::diagnosis::decisions {", "namespace gustlab::diagnosis::decisions {\n\ninline double moved(const char* name, double value) {\n"
        "  const char* text = std::getenv(name);\n  return text == nullptr ? value : std::strtod(text, nullptr);\n}\n", 1)


def build(work):
    table, copy = HOME / "src" / TABLE, work / "include" / TABLE
    copy.parent.mkdir(parents=True, exist_ok=True)
    text = movable(table.read_text(encoding="utf-8"))
    if not copy.exists() or copy.read_text(encoding="utf-8") != text:
        copy.write_text(text, encoding="utf-8")
    quiet = {"check": True, "cwd": HOME, "stdout": sys.stderr}
    # what is quoted is looked for there first
    subprocess.run(["cmake", "--preset", "release", "-B", work / "build", f"-DCMAKE_CXX_FLAGS=-iquote {work / 'include'}"], **quiet)
    subprocess.run(["cmake", "--build", work / "build", "--target", "gustlab"], **quiet)
    return work / "build" / "gustlab"


# ---- trials: [(name, what is there: nothing, outside or something, arguments, is it right?)] -------------------------------

def lost(log, rotor, loss, out):
    """The flight as if a rotor had lost a share of its thrust and the loop had commanded that much more."""
    names, *rows = log.read_text(encoding="utf-8").splitlines()
    at = names.split(",").index(f"u{rotor}")
    a, b, c = PWM_THRUST
    cells = [row.split(",") for row in rows]
    for row in cells:
        thrust = a * float(row[at]) ** 2 + b * float(row[at]) + c
        row[at] = repr(min(MOST_PWM, float((-b + np.sqrt(b * b - 4 * a * (c - thrust / (1 - loss)))) / (2 * a))))
    out.mkdir(parents=True, exist_ok=True)
    path = out / f"{log.stem}_rotor{rotor}_{loss:g}.csv"
    path.write_text("\n".join([names, *map(",".join, cells)]) + "\n", encoding="utf-8")
    path.with_suffix(".meta.toml").write_text(log.with_suffix(".meta.toml").read_text(encoding="utf-8"), encoding="utf-8")
    return path


def hover_trials(flights, work):
    with open(work / "import.txt", "w", encoding="utf-8") as messages:
        folder = import_flights(flights, work / "flights", messages)["crazypad"]
    log = lambda condition, flight: folder / f"{condition}-{flight}_1.csv"
    normals, trials = PAD["normal_flight"][0], []
    for condition, (some, effect) in PAD.items():
        for flight in some:
            for reference in normals:
                # another vehicle's normal flight says nothing of a defect
                if (condition, flight) == ("normal_flight", reference) or (effect and flight[:2] != reference[:2]):
                    continue
                there = [(effect, 3 if effect == "rotor_loss" else None)] if effect else []
                trials.append((f"{condition}-{flight}-{reference}", there, log(condition, flight), log("normal_flight", reference)))
    for flight in normals:
        for reference in normals:
            if flight != reference and flight[:2] == reference[:2]:
                for rotor in (1, 2, 3, 4):
                    for loss in LOSSES:
                        path = lost(log("normal_flight", flight), rotor, loss, work / "lost")
                        trials.append((f"{path.stem}-{reference}", [("rotor_loss", rotor)], path, log("normal_flight", reference)))
    return trials


def hover(trials, program, out, jobs):
    """Rows of what was found: is something there, is it exact, is a name wrong, is the verdict right."""
    def one(trial):
        name, there, flight, reference = trial
        found = out / name / "diagnosis.json"
        if not found.exists():
            subprocess.run([*program, "diagnose", "-q", flight, "--reference", reference, "--out", out / name, "--jobs", "1"],
                           check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        effects = json.loads(found.read_text(encoding="utf-8"))["effects"]
        right = [[means(effect, *wanted) for wanted in there] for effect in effects]
        wrong = not all(map(any, right))
        exact = not wrong and all(map(any, zip(*right))) and len(effects) >= len(there)
        return {"trial": name, "kind": "something" if there else "nothing", "exact": exact, "wrong": wrong, "verdict": bool(effects) == bool(there)}
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        return list(pool.map(one, trials))


def air(folder, answers, program, name, jobs, named_from=None):
    diagnose_sets([(folder, answers)], name, [*program, "diagnose"], ["--jobs", "1"], jobs, keep=True)
    for line in answers.read_text(encoding="utf-8").splitlines():
        answer = json.loads(line)
        path = folder / answer["trial"] / name / "diagnosis.json"
        found = json.loads(path.read_text(encoding="utf-8")) if path.exists() else None
        if found and named_from is not None:
            found["effects"] = [effect for effect in found["effects"] + found.get("suspected", []) if effect["confidence"] >= named_from]
        exact, wrong = judge(answer, found)
        kind = {"clean": "nothing", "scatter": "nothing", "outside": "outside"}.get(answer["kind"], "something")
        alarmed = found is not None and found["verdict"] not in ("consistent", "explained")
        yield {"trial": answer["trial"], "kind": kind, "exact": exact, "wrong": bool(wrong), "verdict": alarmed == (kind == "outside")}


# ---- the table -------------------------------------------------------------------------------------------------------------

def line(name, value, rows, before):
    part = lambda kinds, key: (sum(row[key] for row in rows if row["kind"] in kinds), sum(row["kind"] in kinds for row in rows))
    cell = lambda some: f"{some[0]} of {some[1]}" if some[1] else "–"
    changed = sum(row != old for row, old in zip(rows, before))
    return (f"| {name} | {value} | {cell(part(('something',), 'exact'))} | {cell(part(('something', 'nothing', 'outside'), 'wrong'))} | "
            f"{cell(part(('nothing',), 'verdict'))} | {cell(part(('outside',), 'verdict'))} | {changed} |")


def value_of(name):
    return re.search(rf"\b{name} = ([^,;]+)[,;]", (HOME / "src" / TABLE).read_text(encoding="utf-8"))[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="thresholds, or air or hover")
    parser.add_argument("--count", type=int, default=12)
    parser.add_argument("--seed", type=int, default=47000)
    parser.add_argument("--flights", type=Path, default=os.environ.get("GUSTLAB_FLIGHTS"))
    parser.add_argument("--reality", default=str(HOME / "build/release/tests/reality/reality"))
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--work", type=Path, default=HOME / "build" / "thresholds")
    options = parser.parse_args()
    work, only = options.work, [name for name in options.only.split(",") if name]
    wanted = {name: step for name, step in STEPS.items() if not only or name in only or step[0] in only}
    if unknown := set(only) - set(STEPS) - {"air", "hover"}:
        parser.error(f"no step is known of {', '.join(sorted(unknown))}")
    work.mkdir(parents=True, exist_ok=True)
    program = str(build(work))
    kinds = {step[0] for step in wanted.values()}
    if "hover" in kinds:
        if not options.flights:
            parser.error("hover needs --flights")
        pad = hover_trials(options.flights, work)
    if kinds & {"air", "confidence"}:
        whole = sum(AIR_TRIALS.values())
        draw_sets([Draw("air", options.seed, air_parts(AIR_TRIALS)[:min(options.count, whole)])], options.reality, work, options.jobs)

    def rows(kind, name, value):
        place = work / "air", work / "answers" / "air.jsonl"
        if kind == "confidence":
            return list(air(*place, [program], "as_it_is", options.jobs, value))
        moved = ["env", f"GUSTLAB_DECISION_{name}={value}", program] if name else [program]
        said = f"{name}_{value}" if name else "as_it_is"
        if kind == "hover":
            return hover(pad, moved, work / "hover" / said, options.jobs)
        return list(air(*place, moved, said, options.jobs))

    print("| threshold | value | exact | a wrong name | nothing there: right | outside: right | trials that change |\n" + "|" + " --- |" * 7)
    for kind in sorted(kinds):
        before = rows(kind, None, None)
        print(line(f"({kind})", "as it is", before, before), flush=True)
        for name, (of, *steps) in wanted.items():
            for value in steps if of == kind else ():
                print(line(f"{name} ({value_of(name)})", f"{value:g}", rows(kind, name, value), before), flush=True)


if __name__ == "__main__":
    main()
