#!/usr/bin/env python3
"""Runs PySINDy beside gustlab on the same numbers and prints how far apart they are, in coefficients and in time.

usage: scripts/compare_pysindy.py [--preset release]

Builds and runs bench_identification (20,000 samples × 7 terms × 3 targets, two constraints), makes the same numbers here by
the same formulas as tests/identification/synthetic.hpp and tests/bench/identification.cpp, and runs PySINDy's ConstrainedSR3
on them with the same settings. One thread each, best of several runs, the pass over the samples included on both sides.
Needs scripts/setup.sh --test. Exit 1 when coefficients differ by more than 1e-6, or when a row is not 100 times faster; but for
the last, PySINDy's default settings, whose single optimization stops after so few iterations that reading the samples is most of it.
"""

import argparse
import json
import project_python  # noqa: F401, I001 (first: it may start this script again in .venv)
import os
import subprocess
import sys
import time
import warnings
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
SAMPLES = 20000
# as in tests/bench/identification.cpp: penalty, every λ, ν, tolerance, most iterations, runs here
ROWS = {
    "constrained_sr3_l0_small_nu": ("l0", [0.1], 1e-3, 1e-5, 100000, 1),
    "constrained_sr3_l1_small_nu": ("l1", [0.1], 1e-3, 1e-5, 100000, 1),
    "constrained_sr3_l0_40_lambdas": ("l0", [0.005 * 1.2**k for k in range(39, -1, -1)], 1.0, 1e-5, 30, 3),
    "constrained_sr3_l0_default": ("l0", [0.005], 1.0, 1e-5, 30, 20),
}


def spread(prime):
    """Fractional part of i √prime, less one half: a sequence that fills (−½, ½) evenly."""
    x = np.arange(1, SAMPLES + 1) * np.sqrt(prime)
    return x - np.floor(x) - 0.5


def problem():
    """Θ (samples × 7), Y (samples × 3) of a quadrotor that rocks about hover, and constraints C w = d by target."""
    t = 0.01 * np.arange(SAMPLES)
    roll = 0.12 * np.sin(0.7 * t) + 0.1 * spread(2.0)
    pitch = 0.1 * np.cos(1.1 * t) + 0.1 * spread(3.0)
    thrust = 19.4 + 1.0 * np.sin(2.3 * t) + 2.0 * spread(5.0)
    theta = np.column_stack([np.ones(SAMPLES), pitch, roll, thrust * np.sin(pitch), thrust * np.cos(pitch),
                             thrust * np.sin(roll), thrust * np.cos(roll)])
    truth = np.zeros((3, 7))
    truth[0, 0], truth[0, 3], truth[1, 5], truth[2, 0], truth[2, 4] = 0.5, -0.4, 0.35, -0.8, 0.03
    target = theta @ truth.T + 0.2 * np.column_stack([spread(11.0), spread(13.0), spread(15.0)])
    C = np.zeros((2, 21))
    C[0, 3] = C[0, 7 + 5] = C[1, 7] = 1.0
    return theta, target, C, np.zeros(2)


def run_pysindy(settings, theta, target, C, d):
    """Coefficients (3 × 7) for the last λ, iterations and the best time in ms for all, of PySINDy's ConstrainedSR3."""
    from pysindy import ConstrainedSR3

    penalty, lambdas, nu, tolerance, most, runs = settings
    times = []
    for _ in range(runs):
        start, iterations = time.perf_counter(), 0
        for lam in lambdas:
            optimizer = ConstrainedSR3(reg_weight_lam=lam, regularizer=penalty, relax_coeff_nu=nu, tol=tolerance,
                                       max_iter=most, constraint_lhs=C, constraint_rhs=d, equality_constraints=True,
                                       unbias=False)
            optimizer.fit(theta, target)
            iterations += len(optimizer.history_) - 1
        times.append(1e3 * (time.perf_counter() - start))
    return optimizer.coef_, iterations, min(times)


def run_gustlab(preset):
    """Rows of Google Benchmark's JSON by name; the fastest repetition of each."""
    subprocess.run([ROOT / "scripts" / "build.sh", preset, "bench_identification"], check=True, stdout=subprocess.DEVNULL)
    program = next((ROOT / "build" / preset).rglob("bench_identification"))
    out = subprocess.run([program, "--benchmark_format=json", "--benchmark_repetitions=5"], check=True, capture_output=True)
    rows = {}
    for row in json.loads(out.stdout)["benchmarks"]:
        if row["run_type"] == "iteration" and row["real_time"] < rows.get(row["run_name"], row)["real_time"] + 1e-12:
            rows[row["run_name"]] = row
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--preset", default="release")
    preset = parser.parse_args().preset
    warnings.simplefilter("ignore")
    ours = run_gustlab(preset)
    data = problem()
    print(f"{SAMPLES} samples x 7 terms x 3 targets, 2 constraints; milliseconds, best of several runs, one thread")
    print(f"{'':30s}{'iterations':>12s}{'PySINDy':>11s}{'gustlab':>11s}{'ratio':>8s}{'difference':>12s}")
    agree, ratios = True, []
    for name, settings in ROWS.items():
        coefficients, iterations, theirs_ms = run_pysindy(settings, *data)
        row = ours[name]
        ours_ms = row["real_time"]
        difference = max(abs(row[f"c{t}{j}"] - coefficients[t, j]) for t in range(3) for j in range(7))
        agree &= difference < 1e-6 and iterations == int(row["sr3_iterations"])
        ratios.append(theirs_ms / ours_ms)
        print(f"{name:30s}{iterations:12d}{theirs_ms:11.2f}{ours_ms:11.3f}{ratios[-1]:8.0f}{difference:12.1e}")
    if not agree:
        print("coefficients or iterations differ", file=sys.stderr)
    return 0 if agree and min(ratios[:-1]) >= 100.0 else 1


if __name__ == "__main__":
    sys.exit(main())
