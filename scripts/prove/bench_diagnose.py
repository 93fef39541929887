#!/usr/bin/env python3
"""Time and memory of `gustlab diagnose` on sets of flights, beside those of another build in the same run.

    bench_diagnose.py [--gustlab BIN] [--against OLD_BINARY] [--jobs N] [SET...]

Flies the trial "pair" of experiments/trials_demo.toml, 4 flights of 25 s, logged at 100, 250 and 500 Hz, and diagnoses it; then
every SET, a folder with fit_*.csv and holdout_*.csv. Builds take turns, so that their ratio holds on a busy machine. Prints a
table in Markdown: seconds from start to end, seconds of CPU, peak of memory.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from flight_files import HOME
from run_trials import run_measured


def fly(gustlab, rate_hz, out, jobs):
    """A trial of the simulator, logged at a rate; returns its folder."""
    command = [gustlab, "conceal", HOME / "experiments" / "trials_demo.toml", "--set", f"log_rate_hz={rate_hz}", "--out", out,
               "--answers", out / "answers.jsonl", "--jobs", str(jobs)]
    out.mkdir(parents=True)
    subprocess.run([str(part) for part in command], check=True, stdout=subprocess.DEVNULL)
    return next(out.rglob("pair"))


def recordings(folder, role):
    return sorted(path for path in folder.glob(f"{role}_*.csv*") if path.name.endswith((".csv", ".csv.gz")))


def measure(gustlab, folder, out, jobs):
    holdout = [text for path in recordings(folder, "holdout") for text in ("--holdout", str(path))]
    command = [str(gustlab), "diagnose", *map(str, recordings(folder, "fit")), *holdout, "--out", str(out), "--jobs", str(jobs)]
    figures = run_measured(command, out.with_suffix(".messages.txt"))
    if figures["exit_code"] != 0:
        sys.exit(f"{gustlab} ends with {figures['exit_code']} on {folder}:\n{out.with_suffix('.messages.txt').read_text(encoding='utf-8')}")
    return figures


def cells(figures):
    return f"{figures['seconds']:.1f} | {figures['cpu_seconds']:.1f} | {figures['peak_MiB']:.0f} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sets", nargs="*", type=Path, metavar="SET")
    parser.add_argument("--gustlab", type=Path, default=HOME / "build/release/gustlab")
    parser.add_argument("--against", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    against = options.against
    print("| set | s | s of CPU | MiB |" + (" s, before | s of CPU, before | MiB, before | CPU, before over now |" if against else ""))
    print("|---|---:|---:|---:|" + ("---:|---:|---:|---:|" if against else ""))
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        sets = [(f"simulated, 4 × 25 s, {rate} Hz", fly(options.gustlab, rate, work / f"sets_{rate}", options.jobs)) for rate in (100, 250, 500)]
        sets += [("/".join(path.resolve().parts[-2:]), path) for path in options.sets]
        for number, (name, flights) in enumerate(sets):
            line, now = f"| {name} |", measure(options.gustlab, flights, work / f"now_{number}", options.jobs)
            line += f" {cells(now)}"
            if against:
                before = measure(against, flights, work / f"before_{number}", options.jobs)
                line += f" {cells(before)} {before['cpu_seconds'] / now['cpu_seconds']:.1f} |"
            print(line, flush=True)


if __name__ == "__main__":
    main()
