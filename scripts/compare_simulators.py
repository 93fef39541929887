#!/usr/bin/env python3
"""Flies the same circle with gustlab and with other multirotor simulators, and prints how fast each is, as a table.

usage: scripts/compare_simulators.py --venv DIR [--repeats 7] [--program build/release/gustlab] [--only NAME...]

One quadrotor (a Crazyflie) follows a circle of 1 m in 10 s for 20 s under position control, in each simulator with its own vehicle,
controller and rates. Each simulator gets an environment of its own below DIR, from PyPI, with the versions pinned in
scripts/simulators/*.txt (2 GB, and 6 GB more for RotorPy's batches, which need PyTorch). All of it stays on one core and in one
thread. The simulators take turns, as often as --repeats says. Importing, compiling and the first flight are not counted; gustlab is
timed as a command, so its start, its set-up and the writing of its results are. Counted is processor time, because wall time is also
that of other programs; both are printed. What cannot be installed or flown has a line that says so.
"""

import argparse
import csv
import hashlib
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent / "simulators"
ROOT = HERE.parents[1]
ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")}

# environment (and requirements), its package, what is flown, arguments of gustlab or of scripts/simulators/fly_*.py, physics and
# control in Hz, what a flight includes
ROWS = [
    ("gustlab", "gustlab", "`sweep`, 100 flights", (), "500 / 500 (position 100)",
     "gust, rotor drag, motor lag; the firmware's PID, without feed-forward; metrics of every step; the result store; start of the program"),
    ("gustlab", "gustlab", "`sweep --logs`, 10 flights", ("--logs", "--set", "replicates=10"),
     "500 / 500 (position 100)",
     "the same, and every step written to a CSV file"),
    ("rotorpy", "RotorPy", "`Environment.run`", ("fly_rotorpy.py",), "100 / 100",
     "no wind, rotor drag, motor lag; SE(3) control; adaptive Runge–Kutta; IMU and motion capture with noise; every step kept in memory"),
    ("rotorpy_batched", "RotorPy", "`simulate_batch`, 1000 drones", ("fly_rotorpy.py", "--drones", "1000"), "100 / 100",
     "the same by PyTorch, Runge–Kutta of a fixed step, no motion capture"),
    ("pyflyt", "PyFlyt", "`Aviary`, one QuadX", ("fly_pyflyt.py",), "240 / 120",
     "no wind, drag of the body, motor lag with noise; cascaded PID; PyBullet with contacts; position kept at each control step"),
    ("crazyflow", "crazyflow", "`Sim.step`, 1 world", ("fly_crazyflow.py",), "500 / 500 (position 100)",
     "no wind, drag, rotor lag; Mellinger control; Euler, single precision; position kept at each position command"),
    ("crazyflow", "crazyflow", "compiled flight, 1 world", ("fly_crazyflow.py", "--whole"), "500 / 500 (position 100)",
     "the same, the whole flight one compiled function"),
    ("crazyflow", "crazyflow", "compiled flight, 1000 worlds", ("fly_crazyflow.py", "--whole", "--drones", "1000"),
     "500 / 500 (position 100)", "the same; position of the last world kept"),
]
NOT_ON_PYPI = ("gym-pybullet-drones", "is not on PyPI: not measured")


class Failed(Exception):
    pass


def last_line(text):
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1] if lines else "no message"


def installed(venv, name):
    """The Python of the environment; made anew when its requirements are not those that it was made of."""
    wanted = HERE / f"{name}.txt"
    key = hashlib.sha256(wanted.read_bytes()).hexdigest()
    place, python = venv / name, venv / name / "bin" / "python"
    if python.exists() and (place / "made_of").exists() and (place / "made_of").read_text() == key:
        return python
    for command in ([sys.executable, "-m", "venv", "--clear", place], [python, "-m", "pip", "install", "--quiet", "-r", wanted]):
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise Failed(f"not installed: {last_line(done.stderr)}")
    (place / "made_of").write_text(key)
    return python


def version(name, package):
    """The pinned version of a package."""
    for line in (HERE / f"{name}.txt").read_text(encoding="utf-8").splitlines():
        if line.lower().startswith(package.lower() + "=="):
            return line.split("==")[1]
    raise KeyError(package)


class Flier:
    """A simulator that flies whenever it is asked."""

    def __init__(self, python, arguments):
        self.errors = tempfile.TemporaryFile(mode="w+", encoding="utf-8", errors="replace")
        self.place = tempfile.TemporaryDirectory()  # MuJoCo writes its warnings where it stands
        self.process = subprocess.Popen([str(python), str(HERE / arguments[0]), *arguments[1:]], text=True, stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, stderr=self.errors, env=os.environ | ONE_THREAD,
                                        cwd=self.place.name)
        self.answer()

    def answer(self):
        line = self.process.stdout.readline()
        if not line:
            self.process.wait()
            self.errors.seek(0)
            raise Failed(f"not flown: {last_line(self.errors.read())}")
        return json.loads(line)

    def fly(self):
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        return self.answer()

    def end(self):
        self.process.stdin.close()
        self.process.wait()
        self.process.stdout.close()
        self.errors.close()
        self.place.cleanup()


class Command:
    """gustlab, timed as people start it: `gustlab sweep` in one thread."""

    def __init__(self, program, arguments):
        self.program, self.arguments = program, arguments

    def fly(self):
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "out"
            command = [str(self.program), "sweep", str(HERE / "circle.toml"), "--jobs", "1", "--out", str(out), *self.arguments]
            before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
            if done.returncode != 0:
                raise Failed(f"not flown: {last_line(done.stderr)}")
            with open(out / "runs.csv", encoding="utf-8") as file:
                runs = list(csv.DictReader(file))
        experiment = tomllib.loads((HERE / "circle.toml").read_text(encoding="utf-8"))
        simulated = sum(float(run["duration_s"]) for run in runs)
        return {"wall_s": wall, "cpu_s": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
                "simulated_s": simulated, "steps": round(simulated / experiment["step_s"]),
                "error_m": statistics.mean(float(run["mae_xy_m"]) for run in runs)}

    def end(self):
        pass


def three(value):
    """Three digits, thousands apart."""
    if value < 100.0:
        return f"{value:.3g}"
    digits = len(str(int(value)))
    return f"{round(value, 3 - digits):,.0f}".replace(",", " ")


def spread(values):
    """Median and range."""
    return f"{three(statistics.median(values))} ({three(min(values))} to {three(max(values))})"


def table(measured, versions):
    """measured: of each row of ROWS that was tried, its flights, or the reason why there are none."""
    lines = ["| simulator | flown by | physics / control [Hz] | simulated s per s of one core | physics steps per s of one core "
             "| simulated s per s of wall time | mean error [m] |", "|---|---|--:|--:|--:|--:|--:|"]
    for (name, package, what, _, rates, _), flights in measured:
        head = f"| {package} {versions.get(name, '')}".rstrip() + f" | {what} | {rates} |"
        if isinstance(flights, str):
            lines.append(f"{head} {flights} | | | |")
            continue
        rate = [[one[top] / one[bottom] for one in flights]
                for top, bottom in (("simulated_s", "cpu_s"), ("steps", "cpu_s"), ("simulated_s", "wall_s"))]
        error = statistics.median(one["error_m"] for one in flights)
        lines.append(f"{head} {' | '.join(map(spread, rate))} | {error:.2f} |")
    lines.append(f"| {NOT_ON_PYPI[0]} | | | {NOT_ON_PYPI[1]} | | | |")
    lines.append("")
    lines += [f"* {package}, {what}: {includes}." for (_, package, what, _, _, includes), _ in measured]
    return "\n".join(lines) + "\n"


def measure(rows, fliers, repeats, note):
    """One flight of each in turn, so often; what fails once is not asked again."""
    flights = {row: [] for row in rows}
    failed = {row: flier for row, flier in fliers.items() if isinstance(flier, str)}
    for turn in range(repeats):
        for row in rows:
            if row in failed:
                continue
            try:
                flights[row].append(fliers[row].fly())
                note(f"{turn + 1}/{repeats} {row[1]}, {row[2]}: {flights[row][-1]}")
            except Failed as reason:
                failed[row] = str(reason)
    return [(row, failed.get(row, flights[row])) for row in rows]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--venv", type=Path, required=True, help="folder of the environments; what is there already is used")
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--program", type=Path, default=ROOT / "build" / "release" / "gustlab")
    parser.add_argument("--only", nargs="+", choices=sorted({row[0] for row in ROWS}), help="these environments only")
    options = parser.parse_args()
    if options.repeats < 1:
        parser.error("--repeats: at least 1")
    if not options.program.exists():
        parser.error(f"{options.program} is missing (--program, or scripts/build.sh)")

    def note(text):
        print(text, file=sys.stderr, flush=True)

    rows = [row for row in ROWS if options.only is None or row[0] in options.only]
    pythons, fliers = {}, {}
    for name in dict.fromkeys(row[0] for row in rows if row[0] != "gustlab"):
        note(f"environment of {name}")
        try:
            pythons[name] = installed(options.venv, name)
        except Failed as reason:
            pythons[name] = str(reason)
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    try:
        for row in rows:
            name, _, what, arguments, _, _ = row
            note(f"ready to fly: {name}, {what}")
            try:
                if name == "gustlab":
                    fliers[row] = Command(options.program, arguments)
                else:
                    fliers[row] = pythons[name] if isinstance(pythons[name], str) else Flier(pythons[name], arguments)
            except Failed as reason:
                fliers[row] = str(reason)
        measured = measure(rows, fliers, options.repeats, note)
    finally:
        for flier in fliers.values():
            if not isinstance(flier, str):
                flier.end()
    said = subprocess.run([str(options.program), "--version"], capture_output=True, text=True, check=True).stdout
    versions = {name: version(name, package) for name, package, *_ in rows if name != "gustlab"}
    print(f"{said.splitlines()[0]}; Python {sys.version.split()[0]}; {options.repeats} repeats, median and range\n")
    print(table(measured, versions), end="")


if __name__ == "__main__":
    sys.exit(main())
