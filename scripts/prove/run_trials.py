#!/usr/bin/env python3
"""Diagnoses every trial of one or more sets of concealed trials, in parallel, and scores them.

    run_trials.py SETDIR ANSWERS [SETDIR ANSWERS ...] --gustlab BIN [--jobs 2]
    run_trials.py --all DIR --gustlab BIN        DIR/answers/<set>.jsonl beside DIR/<set>/

Each trial gets SETDIR/<trial>/<name>/diagnosis.json; a failed one gets none and counts as a failure. Time and memory of
each run go to SETDIR/<trial>/<name>.run.json: they are no part of a diagnosis. The score is printed as Markdown.
"""

import argparse
import concurrent.futures
import json
import os
import subprocess
import sys
import time
from pathlib import Path


def trials_of(answers):
    with open(answers, encoding="utf-8") as file:
        return [json.loads(line)["trial"] for line in file if line.strip()]


def run_measured(command, log):
    """Exit code, seconds and peak MiB of a command; its messages go to `log`."""
    start = time.monotonic()
    with open(log, "wb") as messages:
        process = subprocess.Popen(command, stdout=messages, stderr=subprocess.STDOUT)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    return {"exit_code": process.returncode, "seconds": round(time.monotonic() - start, 3),
            "cpu_seconds": round(usage.ru_utime + usage.ru_stime, 3), "peak_MiB": round(usage.ru_maxrss / 1024, 1)}


def diagnose(folder, name, program, arguments):
    """Diagnoses one trial; returns its exit code, time and memory."""
    recordings = sorted(path for path in folder.glob("*.csv*") if path.name.endswith((".csv", ".csv.gz")))
    fit = [path for path in recordings if path.name.startswith("fit_")]
    holdout = [path for path in recordings if path.name.startswith("holdout_")]
    if not fit:
        return {"exit_code": 3, "seconds": 0.0, "cpu_seconds": 0.0, "peak_MiB": 0.0}
    command = [*program, *map(str, fit), *(text for path in holdout for text in ("--holdout", str(path))),
               "--out", str(folder / name), *arguments]
    figures = run_measured(command, folder / f"{name}.messages.txt")
    if figures["exit_code"] != 0:
        # what an earlier version found must not stand for this one
        (folder / name / "diagnosis.json").unlink(missing_ok=True)
    (folder / f"{name}.run.json").write_text(json.dumps(figures) + "\n", encoding="utf-8")
    return figures


def diagnose_sets(sets, name, program, arguments, jobs, keep):
    """Runs every trial of [(folder, answers)]; returns {(set, trial): figures}."""
    todo = [(Path(folder), trial) for folder, answers in sets for trial in trials_of(answers)]
    if keep:
        todo = [(folder, trial) for folder, trial in todo if not (folder / trial / name / "diagnosis.json").exists()]
    results = {}
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        waiting = {pool.submit(diagnose, folder / trial, name, program, arguments): (folder, trial)
                   for folder, trial in todo}
        for number, future in enumerate(concurrent.futures.as_completed(waiting), 1):
            folder, trial = waiting[future]
            figures = results[folder.name, trial] = future.result()
            failed = "" if figures["exit_code"] == 0 else f"  exit {figures['exit_code']}"
            print(f"[{number}/{len(todo)}] {folder.name}/{trial} {figures['seconds']:.1f} s{failed}",
                  file=sys.stderr, flush=True)
    return results


def score(sets, name, gustlab, form="md"):
    command = [gustlab, "score", "--diagnosis", name, "--format", form]
    for folder, answers in sets:
        command += [str(answers), str(folder)]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sets", nargs="*", metavar="SETDIR ANSWERS")
    parser.add_argument("--all", type=Path, metavar="DIR", help="every set with answers in DIR/answers")
    parser.add_argument("--match", default="", help="only sets of --all whose name contains this")
    parser.add_argument("--gustlab", default="build/release/gustlab")
    parser.add_argument("--program", help="command that diagnoses, instead of 'GUSTLAB diagnose'")
    parser.add_argument("--arguments", default="", help="more arguments for it, in one string")
    parser.add_argument("--name", default="diagnosis", help="folder of the diagnosis in each trial")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--keep", action="store_true", help="keep diagnoses that exist")
    parser.add_argument("--score-only", action="store_true")
    parser.add_argument("--format", choices=["md", "json"], default="md")
    options = parser.parse_args()
    if len(options.sets) % 2:
        parser.error("SETDIR without ANSWERS")
    sets = [(Path(folder), Path(answers)) for folder, answers in zip(options.sets[::2], options.sets[1::2])]
    if options.all:
        sets += [(options.all / path.stem, path) for path in sorted((options.all / "answers").glob("*.jsonl"))
                 if options.match in path.stem and (options.all / path.stem).is_dir()]
    if not sets:
        parser.error("no set of trials")
    program = options.program.split() if options.program else [options.gustlab, "diagnose"]
    if not options.score_only:
        results = diagnose_sets(sets, options.name, program, options.arguments.split(), options.jobs, options.keep)
        seconds = sorted(figures["seconds"] for figures in results.values())
        if seconds:
            print(f"{len(seconds)} diagnoses: median {seconds[len(seconds) // 2]:.1f} s, longest {seconds[-1]:.1f} s, "
                  f"peak {max(figures['peak_MiB'] for figures in results.values()):.0f} MiB", file=sys.stderr)
    sys.stdout.write(score(sets, options.name, options.gustlab, options.format))


if __name__ == "__main__":
    main()
