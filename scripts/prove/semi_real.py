#!/usr/bin/env python3
"""Real flights against a vehicle file that was falsified on purpose: is exactly the falsification named?

    semi_real.py FLIGHTS --gustlab BIN --out DIR [--variant published|augmented] [--set NAME] [--case TEXT] [--jobs 1]

FLIGHTS holds a folder of flight logs per set (scripts/import_log.py). The baseline is a diagnosis against the right file:
the published one, or (augmented) the published one with all that its diagnosis found put in. Each case changes one thing of
that file, or delays the pose in the logs. A case is right when, against the baseline,
  - the falsification is named (itself, or in the class that is named); where the baseline names that effect already, its total
    has moved by the falsification: to within a quarter of it or the 95 % intervals of both;
  - no other name is new. Names that the baseline has and the case lost are listed; "strictly right" has none.
A finished diagnosis is kept, so several processes may share the cases (--case) and an ended run goes on where it stopped.
Prints a Markdown table of what is there.
"""

import argparse
import concurrent.futures
import json
import math
import sys
from copy import deepcopy
from pathlib import Path

from falsify import VehicleFolder, copy_log, falsifications
from flight_files import HOME
from run_trials import diagnose

VARIANTS = ("published", "augmented")


def sets_of(folders):
    """{name: (fit, holdout, vehicle)} of the sets with pose that are there."""
    sets = {}
    if "nanodrone" in folders:
        log = lambda name: folders["nanodrone"] / f"train_{name}.csv.gz"
        sets["nanodrone"] = ([log("random1_run1"), log("random2_run2"), log("multisine_run1"), log("square_run3")], [log("random1_run2")],
                             HOME / "models" / "crazyflie_brushless" / "vehicle.toml")
    if "nanobench" in folders:
        log = lambda name: next(folders["nanobench"].glob(f"{name}*.csv.gz"))
        sets["nanobench"] = ([log("B2"), log("B3")], [log("B6")], HOME / "models" / "crazyflie_real" / "vehicle.toml")
    return sets


def build(folder, vehicle, fit, holdout, pose_delay_s=0.0):
    """One trial folder: recordings as fit_N and holdout_N, and the vehicle beside them."""
    vehicle.write(folder / "vehicle")
    for role, flights in (("fit", fit), ("holdout", holdout)):
        for number, flight in enumerate(flights, 1):
            ending = ".csv.gz" if str(flight).endswith(".gz") else ".csv"
            copy_log(flight, folder / f"{role}_{number}{ending}", "vehicle/vehicle.toml", pose_delay_s)


def read(folder):
    path = folder / "diagnosis" / "diagnosis.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None


class Bench:
    """Diagnoses each folder once."""

    def __init__(self, gustlab, threads):
        self.program, self.arguments = [gustlab, "diagnose"], ["--jobs", str(threads)]

    def diagnosis(self, folder, vehicle, fit, holdout, pose_delay_s=0.0):
        if read(folder) is None:
            build(folder, vehicle, fit, holdout, pose_delay_s)
            diagnose(folder, "diagnosis", self.program, self.arguments)
        return read(folder)


def rotor_of(effect):
    rotor = effect["parameters"].get("rotor")
    return rotor and int(rotor["value"])


def label(effect):
    return effect["effect"] + (f"#{rotor_of(effect)}" if rotor_of(effect) else "")


def said(effect):
    numbers = ", ".join(f"{name} {p['value']:.4g} ± {1.96 * (p.get('std') or 0.0):.2g}" for name, p in effect["parameters"].items() if name != "rotor")
    return f"{label(effect)} {numbers}"


def alike(a, b):
    """Whether two findings are one name, or each in the other's class of names that the data cannot tell apart."""
    if a["effect"] == b["effect"]:
        return rotor_of(a) == rotor_of(b)
    return a["effect"] in b["class"] or b["effect"] in a["class"]


def means(effect, wrong):
    """Whether a finding names the falsification, itself or in its class."""
    if effect["effect"] == wrong.effect:
        return wrong.rotor in (None, rotor_of(effect))
    return wrong.effect in effect["class"] or f"{wrong.effect}#{wrong.rotor}" in effect["class"]


def pick(effects, wrong):
    """The finding that names the falsification: itself, or else one with it in its class; and all other findings."""
    hits = sorted((e for e in effects if means(e, wrong)), key=lambda e: e["effect"] != wrong.effect)
    return hits[:1], [e for e in effects if not any(e is hit for hit in hits[:1])]


def unpaired(found, base):
    """What is left of both when every name is paired with one of the other: the same name first, then of one class."""
    found, base = list(found), list(base)
    for same in (lambda a, b: label(a) == label(b), alike):
        for effect in list(found):
            partner = next((b for b in base if same(effect, b)), None)
            if partner is not None:
                found.remove(effect)
                base.remove(partner)
    return found, base


def total(diagnosis, vehicle, wrong, name):
    """(value, std) of a parameter against a file: as named, else as trimmed, else what the file says."""
    for effect in diagnosis["effects"] + diagnosis.get("calibration", []):
        if effect["effect"] == wrong.effect and wrong.rotor in (None, rotor_of(effect)):
            return effect["parameters"][name]["value"], effect["parameters"][name].get("std") or 0.0
    return float((vehicle.effect(wrong.effect) or {}).get(name, 0.0)), 0.0


def judge(case, wrong, base, found, right_file, wrong_file):
    """One row: what is new, what is lost, and the falsified parameters against what they should read."""
    row = {"case": case, "verdict": found["verdict"], "falsified": label_of(wrong), "base": [label(e) for e in base["effects"]], "named": [label(e) for e in found["effects"]]}
    hits, others = pick(found["effects"], wrong)
    known, base_others = pick(base["effects"], wrong)
    new, lost = unpaired(others, base_others)
    row["new"], row["lost"] = [label(e) for e in new], [label(b) for b in (lost if hits else lost + known)]
    row["as"] = [said(e) for e in hits]
    row["values"], moved = [], True
    for name, then in wrong.totals.items():
        before, before_std = total(base, right_file, wrong, name)
        after, after_std = total(found, wrong_file, wrong, name)
        wanted = then(before)
        # against the wrong file the right vehicle would read `wanted`; a diagnosis that sees nothing new reads `unchanged`
        unchanged = float((wrong_file.effect(wrong.effect) or {}).get(name, 0.0)) if wanted == before else before
        close = max(0.25 * abs(wanted - unchanged), 1.96 * math.hypot(before_std, after_std))
        moved = moved and abs(after - wanted) <= close
        row["values"].append({"name": name, "wanted": wanted, "value": after, "std": after_std, "before": before})
    row["right"] = bool(hits) and not row["new"] and (moved or not known)
    row["strictly"] = row["right"] and not row["lost"]
    rejected = wrong.effect + (f" (rotor {wrong.rotor})" if wrong.rotor else "")
    row["why"] = sorted({r["why"] for r in found["rejected"] if r["effect"] == rejected})
    row["alarms"] = [alarm["says"] for alarm in found["alarms"]]
    row["findings"] = sorted({f["kind"] for f in found["log_findings"]} - {f["kind"] for f in base["log_findings"]})
    return row


def label_of(wrong):
    return wrong.effect + (f"#{wrong.rotor}" if wrong.rotor else "")


def run_set(name, flights, variant, out, bench, jobs, only=""):
    """Rows of one set, or None when the flights cannot be diagnosed."""
    fit, holdout, vehicle_path = flights
    right_file = VehicleFolder(vehicle_path)
    base = bench.diagnosis(out / "published" / f"{name}_as_is", right_file, fit, holdout)
    if base is not None and variant == "augmented":
        right_file.add_found(base)
        base = bench.diagnosis(out / variant / f"{name}_as_is", right_file, fit, holdout)
    if base is None:
        return None

    def one(case, wrong):
        wrong_file = deepcopy(right_file)
        wrong.change(wrong_file)
        found = bench.diagnosis(out / variant / f"{name}_{case}", wrong_file, fit, holdout, wrong.pose_delay_s)
        if found is None:
            return {"case": f"{name} {case}", "verdict": "no diagnosis", "right": False, "strictly": False}
        return judge(f"{name} {case}", wrong, base, found, right_file, wrong_file)
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        cases = [(case, wrong) for case, wrong in falsifications(right_file).items() if only in case]
        return list(pool.map(lambda entry: one(*entry), cases))


def value_text(row):
    """The falsified parameters, or those of the classmate under whose name they stand."""
    wanted = ", ".join(f"{v['name']} {v['wanted']:.4g}" for v in row["values"])
    if row["as"] and not any(name.startswith(row["falsified"]) for name in row["as"]):
        return f"as {', '.join(row['as'])} (wanted {wanted})"
    return "; ".join(f"{v['name']} {v['value']:.4g} ± {1.96 * v['std']:.2g} (wanted {v['wanted']:.4g})" for v in row["values"])


def markdown(rows):
    """The table, and what was rejected where it is not right."""
    lines = ["| case | verdict | named before | named | new | lost | falsified parameter, 95 % | right | strictly |", "|" + " --- |" * 9]
    cell = lambda names: ", ".join(names) or "–"
    for row in rows:
        if "named" not in row:
            lines.append(f"| {row['case']} | {row['verdict']} |  |  |  |  |  | **no** | **no** |")
            continue
        yes = lambda key: "yes" if row[key] else "**no**"
        lines.append(f"| {row['case']} | {row['verdict']} | {cell(row['base'])} | {cell(row['named'])} | {cell(row['new'])} | {cell(row['lost'])} | "
                     f"{value_text(row)} | {yes('right')} | {yes('strictly')} |")
    count = lambda key: sum(bool(row[key]) for row in rows)
    lines += ["", f"right: {count('right')} of {len(rows)}; strictly: {count('strictly')} of {len(rows)}", ""]
    for row in rows:
        if not row["right"] and "named" in row:
            why = "; ".join(row["why"]) or "never fitted alone"
            lines.append(f"- {row['case']}: {row['falsified']} {'named as ' + cell(row['as']) if row['as'] else 'not named'}; rejected: {why}; "
                         f"new log findings: {cell(row['findings'])}; alarms: {cell(row['alarms'])}")
    return "\n".join(lines) + "\n"


def run(folders, out, gustlab, jobs, variant="published", only_set="", only=""):
    """Rows of every set that is there."""
    bench = Bench(gustlab, 1 if jobs > 1 else 2)
    rows = []
    for name, flights in sets_of(folders).items():
        if only_set in name:
            rows += run_set(name, flights, variant, out, bench, jobs, only) or [{"case": name, "verdict": "no diagnosis", "right": False, "strictly": False}]
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("flights", type=Path)
    parser.add_argument("--gustlab", default=str(HOME / "build/release/gustlab"))
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--variant", choices=VARIANTS, default="published")
    parser.add_argument("--set", default="", help="only sets whose name contains this")
    parser.add_argument("--case", default="", help="only cases whose name contains this")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--format", choices=["md", "json"], default="md")
    options = parser.parse_args()
    folders = {path.name: path for path in options.flights.iterdir() if path.is_dir()}
    rows = run(folders, options.out, options.gustlab, options.jobs, options.variant, options.set, options.case)
    sys.stdout.write(markdown(rows) if options.format == "md" else json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
