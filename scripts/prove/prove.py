#!/usr/bin/env python3
"""The whole proof: draws concealed trials from the independent reality, diagnoses them, scores, and writes docs/PROOF.md.

    scripts/prove.sh [--quick] [--count X] [--seed 9000] [--jobs 2] [--flights DIR] [--keep] [--work DIR] [--out docs]

`--count` multiplies the number of trials; `--quick` is a small sample. Trials and answers stay under --work, with their
SHA-256, which are printed before the first diagnosis. `--keep` goes on where an earlier run stopped.
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
    if quick:
        singles = [Draw(f"single_{e}", seed + 100 + effects.index(e), [(1, ["--effect", e, "--strength-factor", "5"])])
                   for e in ("rotor_drag", "mass", "rotor_loss", "motor_lag") if e in effects]
        return [Draw("clean", seed + 1, [(2, ["--kind", "clean"])]), *singles,
                Draw("pair", seed + 300, [(1, ["--kind", "pair", "--strength-factor", "4"])]),
                Draw("outside", seed + 400, [(1, ["--kind", "outside"])])]
    times = lambda n: max(1, math.ceil(scale * n))
    singles = [Draw(f"single_{e}", seed + 100 + i, [(times(1), ["--effect", e, "--strength-factor", f"{s:g}"]) for s in (STRENGTHS if scale >= 1 else STRENGTHS[::2])])
               for i, e in enumerate(effects)]
    return [Draw("clean", seed + 1, [(times(60), ["--kind", "clean"])]), Draw("scatter", seed + 2, [(times(20), ["--kind", "scatter"])]),
            *singles, Draw("pair", seed + 300, [(times(20), ["--kind", "pair", "--strength-factor", f"{s:g}"]) for s in PAIR_STRENGTHS]),
            Draw("outside", seed + 400, [(times(40), ["--kind", "outside"])]),
            Draw("mixed", seed + 500, [(times(100), ["--kind", "mixed"])])]


def draw_sets(sets, reality, work, jobs, keep):
    """Draws what is not there yet; returns [(name, commands, sha256)]. A set that the reality refuses is left out, and said."""
    (work / "answers").mkdir(parents=True, exist_ok=True)
    waiting, drawn = {}, []
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for one in sets:
            if keep and (work / "answers" / f"{one.name}.jsonl").exists():
                continue
            for number, command in enumerate(one.commands(reality, work)):
                waiting[one.name, number] = pool.submit(subprocess.run, command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    for one in sets:
        answers = work / "answers" / f"{one.name}.jsonl"
        commands = list(one.commands("reality", Path("WORK")))
        results = [waiting[key].result() for key in waiting if key[0] == one.name]
        failed = next((r for r in results if r.returncode != 0), None)
        if failed is not None:
            print(f"{one.name}: not drawn: {failed.stderr.strip().splitlines()[0]}", file=sys.stderr)
            continue
        if results:
            parts = [work / "answers" / f"{one.name}.part{number}" for number in range(len(commands))]
            answers.write_bytes(b"".join(part.read_bytes() for part in parts))
            for part in parts:
                part.unlink()
        digest = hashlib.sha256(answers.read_bytes()).hexdigest()
        print(f"{one.name} {digest}", flush=True)
        drawn.append((one.name, [shlex.join(c[:c.index("--out")]) for c in commands], digest))
    return drawn


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


def real_flights(flights, gustlab, work, jobs):
    if flights is None:
        return None
    script = Path(__file__).with_name("real_flights.py")
    result = subprocess.run([sys.executable, script, flights, "--gustlab", gustlab, "--out", work / "real", "--jobs", str(jobs)],
                            stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(result.stdout)


def diagnosable(gustlab):
    rows = json.loads(subprocess.run([gustlab, "list", "effects", "--format", "json"], check=True, stdout=subprocess.PIPE, text=True).stdout)
    return [row["name"] for row in rows["effects"] if row["diagnosable"]]


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
    parser.add_argument("--keep", action="store_true")
    parser.add_argument("--no-baseline", action="store_true")
    options = parser.parse_args()
    work = options.work
    sets = plan(options.seed, options.count, options.quick, diagnosable(options.gustlab))
    drawn = draw_sets(sets, options.reality, work, options.jobs, options.keep)
    if not drawn:
        print("prove: no set could be drawn", file=sys.stderr)
        return 4
    places = [(work / name, work / "answers" / f"{name}.jsonl") for name, _, _ in drawn]

    # two diagnoses at a time with one thread each are faster than one with two
    one_thread = ["--jobs", "1"] if options.jobs > 1 else []
    diagnose_sets(places, "diagnosis", [options.gustlab, "diagnose"], one_thread, options.jobs, options.keep)
    result = {"score": json.loads(score(places, "diagnosis", options.gustlab, "json")), "baseline": None, "sets": drawn}
    if not options.no_baseline:
        program = [sys.executable, str(Path(__file__).with_name("naive_baseline.py"))]
        diagnose_sets(places, "baseline", program, ["--gustlab", options.gustlab], options.jobs, options.keep)
        result["baseline"] = json.loads(score(places, "baseline", options.gustlab, "json"))
    timed = [name for name, _, _ in drawn if name.startswith(("single_", "pair", "clean"))]
    result["timing"] = timing(options.gustlab, work, timed[:3] if options.quick else timed[:10])
    result["real"] = real_flights(options.flights, options.gustlab, work, options.jobs)
    result["quick"] = options.quick
    (work / "proof.json").write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    write_proof(result, options.out)
    print(options.out / "PROOF.md")
    return 0


if __name__ == "__main__":
    sys.exit(main())
