"""The circle that every simulator flies, and the loop that times it. Runs in the environments of the simulators."""

import argparse
import json
import math
import os
import sys
import time

RADIUS_M, PERIOD_S, HEIGHT_M, DURATION_S = 1.0, 10.0, 1.0, 20.0
START = (RADIUS_M, 0.0, HEIGHT_M)


def point(time_s):
    """Position, velocity and acceleration of the reference."""
    rate = 2.0 * math.pi / PERIOD_S
    x, y = RADIUS_M * math.cos(rate * time_s), RADIUS_M * math.sin(rate * time_s)
    return (x, y, HEIGHT_M), (-rate * y, rate * x, 0.0), (-rate * rate * x, -rate * rate * y, 0.0)


def mean_error_m(times_s, positions_m):
    """Mean distance from the reference in the second half of the flight; positions: one (x, y, z) for each time."""
    distances = [math.dist(point(t)[0], position) for t, position in zip(times_s, positions_m) if t >= DURATION_S / 2]
    return sum(distances) / len(distances)


def serve(prepare, description):
    """prepare(drones, whole) imports, sets up and gives fly(), which flies once and returns (steps of the physics, times, positions
    of the last drone). The first flight compiles and is not timed. Then each line of stdin is a flight, each line of stdout a time."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--drones", type=int, default=1, help="flown at once")
    parser.add_argument("--whole", action="store_true", help="a whole flight as one compiled function (crazyflow)")
    options = parser.parse_args()
    drones = options.drones
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what a library prints is no answer
    fly = prepare(drones, options.whole)
    fly()
    print(json.dumps({"ready": True}), file=answers, flush=True)
    for _ in sys.stdin:
        wall, cpu = time.perf_counter(), time.process_time()
        steps, times, positions = fly()
        cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
        print(json.dumps({"wall_s": wall, "cpu_s": cpu, "simulated_s": drones * DURATION_S, "steps": drones * steps,
                          "error_m": float(mean_error_m(times, positions))}), file=answers, flush=True)
