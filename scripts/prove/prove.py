#!/usr/bin/env python3
"""The whole proof: draws concealed trials from the independent reality, diagnoses them, scores, and writes docs/PROOF.md.

    scripts/prove.sh [--quick] [--count X] [--seed 9000] [--jobs 2] [--flights DIR] [--semi-real N] [--only NAME,NAME] [--work DIR] [--out docs]

`--count` multiplies the number of trials, of each kind and strength at least one; `--quick` is a small sample of every kind.
Trials and answers stay under --work, with their SHA-256, which are printed before the first diagnosis. What is finished is
kept: an ended run goes on where it stopped, as long as plan and program are the same. `--only clean,single_mass,real` does
these sets alone and writes no page, so that several processes can share the work; a last run without it completes the page.
"""

import argparse
import concurrent.futures
import hashlib
import json
import math
import shlex
import subprocess
import sys
from pathlib import Path

from air_trials import AIR_TRIALS, air_parts, scored as scored_by_air
from flight_files import HOME
from proof_page import write_proof
from run_trials import diagnose_sets, run_measured, score

STRENGTHS = (1.5, 2.5, 4.0, 6.0, 10.0)       # of single effects, in detection limits
PAIR_STRENGTHS = (2.0, 4.0, 8.0)


class Draw:
    """One set: several draws of the reality into one folder, told apart by the numbers of their trials."""

    def __init__(self, name, seed, parts):
        self.name, self.seed, self.parts = name, seed, parts  # parts: [(count, arguments)]

    def commands(self, reality, work):
        first = 1
        for number, (count, arguments) in enumerate(self.parts):
            yield [reality, "draw", "--seed", str(self.seed), "--first", str(first), "--count", str(count), *arguments,
                   "--out", str(work / self.name), "--answers", str(work / "answers" / f"{self.name}.part{number}")]
            first += count


def plan(seed, scale, quick, effects):
    times = (lambda n: 1) if quick else (lambda n: max(1, math.ceil(scale * n)))
    strengths, pair_strengths = ((4.0,), (4.0,)) if quick else (STRENGTHS, PAIR_STRENGTHS)
    forced = lambda arguments, n, factors: [(times(n), [*arguments, "--strength-factor", f"{f:g}"]) for f in factors]
    singles = [Draw(f"single_{e}", seed + 100 + i, forced(["--effect", e], 1, strengths))
               for i, e in enumerate(effects) if not quick or e in ("rotor_drag", "mass", "rotor_loss", "motor_lag")]
    return [Draw("clean", seed + 1, [(times(60), ["--kind", "clean"])]), Draw("scatter", seed + 2, [(times(20), ["--kind", "scatter"])]),
            *singles, Draw("pair", seed + 300, forced(["--kind", "pair"], 20, pair_strengths)),
            Draw("outside", seed + 400, [(times(40), ["--kind", "outside"])]),
            Draw("air", seed + 600, air_parts({kind: times(count) for kind, count in AIR_TRIALS.items()})),
            Draw("mixed", seed + 500, [(times(100), ["--kind", "mixed"])])]


def draw_sets(sets, reality, work, jobs):
    """Draws what is not there yet; returns [(name, commands, sha256)]. A set that the reality refuses ends the proof."""
    (work / "answers").mkdir(parents=True, exist_ok=True)
    complete = lambda one: work / "answers" / f"{one.name}.jsonl"
    waiting, drawn = {}, []
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for one in sets:
            if not complete(one).exists():
                waiting[one.name] = [pool.submit(subprocess.run, command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
                                     for command in one.commands(reality, work)]
    for one in sets:
        results = [future.result() for future in waiting.get(one.name, [])]
        failed = next((r for r in results if r.returncode != 0), None)
        if failed is not None:
            sys.exit(f"prove: {one.name} could not be drawn: {failed.stderr.strip().splitlines()[0]}")
        if results:
            parts = [work / "answers" / f"{one.name}.part{number}" for number in range(len(results))]
            joined = work / "answers" / f"{one.name}.joined"
            joined.write_bytes(b"".join(part.read_bytes() for part in parts))
            joined.rename(complete(one))
            for part in parts:
                part.unlink()
        digest = hashlib.sha256(complete(one).read_bytes()).hexdigest()
        print(f"{one.name} {digest}", flush=True)
        drawn.append((one.name, [shlex.join(c[:c.index("--out")]) for c in one.commands("reality", Path("WORK"))], digest))
    return drawn


def same_as_before(work, stamp):
    """Whether the work folder belongs to this plan and program; a new one does from now on."""
    path = work / "stamp.json"
    if not path.exists():
        work.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(stamp, indent=1) + "\n", encoding="utf-8")
    return json.loads(path.read_text(encoding="utf-8")) == stamp


def timing(gustlab, work, names):
    """One diagnosis at a time with both cores, on the first trial of some sets; and whether --jobs changes a byte."""
    figures, same = [], True
    for name in names:
        trial = work / name / "trial001"
        files = [*map(str, sorted(trial.glob("fit_*.csv"))), "--holdout", str(trial / "holdout_1.csv")]
        outputs = []
        for jobs in ("2", "1"):
            out = work / "timing" / f"{name}_{jobs}"
            out.parent.mkdir(parents=True, exist_ok=True)
            measured = run_measured([gustlab, "diagnose", *files, "--out", str(out), "--jobs", jobs], work / "timing" / "messages.txt")
            if measured["exit_code"] == 0:
                outputs.append([(out / file).read_bytes() for file in ("diagnosis.json", "augmented.toml", "report.html")])
            if jobs == "2":
                figures.append(measured)
        same = same and len(outputs) == 2 and outputs[0] == outputs[1]
    return {"seconds": [f["seconds"] for f in figures], "peak_MiB": [f["peak_MiB"] for f in figures], "same_bytes": same}


def real_flights(options, work):
    if options.flights is None:
        return None
    script = Path(__file__).with_name("real_flights.py")
    result = subprocess.run([sys.executable, script, options.flights, "--gustlab", options.gustlab, "--out", work / "real", "--jobs", str(options.jobs),
                             "--semi-real", str(options.semi_real)], stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(result.stdout)


def diagnosable(gustlab):
    rows = json.loads(subprocess.run([gustlab, "list", "effects", "--format", "json"], check=True, stdout=subprocess.PIPE, text=True).stdout)
    return [row["name"] for row in rows["effects"] if row["diagnosable"]]


def sha256_of(path):
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gustlab", default=str(HOME / "build/release/gustlab"))
    parser.add_argument("--reality", default=str(HOME / "build/release/tests/reality/reality"))
    parser.add_argument("--work", type=Path, default=HOME / "build" / "prove")
    parser.add_argument("--out", type=Path, default=HOME / "docs", help="folder of PROOF.md and proof/")
    parser.add_argument("--seed", type=int, default=9000)
    parser.add_argument("--count", type=float, default=1.0)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--flights", type=Path, help="real flights, as docs/DATA.md describes")
    parser.add_argument("--semi-real", type=int, default=260, help="most semi-real cases; any first part of them is a sample of every family")
    parser.add_argument("--only", default="", help="these sets alone, comma-separated ('real': the real flights); no page")
    parser.add_argument("--no-baseline", action="store_true")
    options = parser.parse_args()
    work, only = options.work, [name for name in options.only.split(",") if name]
    stamp = {"seed": options.seed, "count": options.count, "quick": options.quick, "gustlab": sha256_of(options.gustlab),
             "reality": sha256_of(options.reality)}
    if not same_as_before(work, stamp):
        parser.error(f"{work} holds the trials of another plan or program (stamp.json): remove it, or name another --work")
    sets = plan(options.seed, options.count, options.quick, diagnosable(options.gustlab))
    if unknown := set(only) - {one.name for one in sets} - {"real"}:
        parser.error(f"no set is called {', '.join(sorted(unknown))}: there are {', '.join(one.name for one in sets)} and real")
    if only:
        sets = [one for one in sets if one.name in only]
    drawn = draw_sets(sets, options.reality, work, options.jobs)
    places = [(work / name, work / "answers" / f"{name}.jsonl") for name, _, _ in drawn]

    # two diagnoses at a time with one thread each are faster than one with two
    one_thread = ["--jobs", "1"] if options.jobs > 1 else []
    diagnose_sets(places, "diagnosis", [options.gustlab, "diagnose"], one_thread, options.jobs, keep=True)
    if not options.no_baseline:
        program = [sys.executable, str(Path(__file__).with_name("naive_baseline.py"))]
        diagnose_sets(places, "baseline", program, ["--gustlab", options.gustlab], options.jobs, keep=True)
    real = real_flights(options, work) if not only or "real" in only else None
    if only:
        return 0
    scored = lambda name: json.loads(score(places, name, options.gustlab, "json"))
    timed = [name for name, _, _ in drawn if name.startswith(("single_", "pair", "clean"))]
    program = subprocess.run([options.gustlab, "--version"], check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()[0]
    result = {"program": program, "seed": options.seed, "score": scored("diagnosis"), "baseline": None if options.no_baseline else scored("baseline"), "sets": drawn, "real": real,
              "air": list(scored_by_air(work / "air", work / "answers" / "air.jsonl", "diagnosis")),
              "timing": timing(options.gustlab, work, timed[:3] if options.quick else timed[:10]), "quick": options.quick}
    (work / "proof.json").write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    write_proof(result, options.out)
    print(options.out / "PROOF.md")
    return 0


if __name__ == "__main__":
    sys.exit(main())
