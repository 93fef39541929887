#!/usr/bin/env python3
"""Real flights: does the diagnosis name what is known of them, and does the model that it finds fly better?

    real_flights.py FLIGHTS --gustlab BIN --out DIR [--jobs 2] [--only SET]

FLIGHTS is the folder that docs/DATA.md describes (recordings as published) or its flight logs after scripts/import_log.py.
Prints one JSON object: {"cases": [...], "nanodrone": {...}, "semi_real": [...]}.
"""

import argparse
import json
import shutil
import subprocess
import sys
from pathlib import Path

import semi_real
from families import lay_out
from flight_files import HOME
from outcomes import label, means
from run_trials import run_measured

# mean errors over every window that the benchmark publishes for its test flights, 50 steps (0.5 s) ahead
PUBLISHED = {"hold": (0.6797, 1.4749, 0.3041, 0.8837), "physics": (0.1269, 0.5781, 0.2544, 0.8837), "MLP": (0.1712, 0.5720, 0.2268, 0.9005),
             "physics + network": (0.1119, 0.5556, 0.2306, 0.5979), "LSTM": (0.2572, 0.7407, 0.2325, 1.2407)}
QUANTITIES = ("position_m", "velocity_mps", "attitude_rad", "body_rate_radps")
GOAL = {"position_m": 0.090, "velocity_mps": 0.33, "attitude_rad": 0.15, "body_rate_radps": 0.43}


def import_flights(source, out, jobs_log):
    """{set: folder} of flight logs: as they are, or imported under `out`; a set that was imported is kept."""
    done = {}
    for name in ("nanodrone", "nanobench", "arpl", "crazypad"):
        if list((source / name).glob("*.meta.toml")):
            done[name] = source / name
            continue
        if not (source / name).is_dir():
            continue
        inputs = sorted(path for path in (source / name).rglob("*") if path.is_file() and path.suffix in (".gz", ".csv", "")
                        and path.name not in ("LICENSE", "README"))
        if not (out / name).exists():
            unfinished = out / f"{name}.part"
            shutil.rmtree(unfinished, ignore_errors=True)
            subprocess.run([sys.executable, HOME / "scripts" / "import_log.py", *inputs, "--map", name, "--out", unfinished,
                            "--keep-unusable"], check=True, stdout=jobs_log, stderr=jobs_log)
            unfinished.rename(out / name)
        done[name] = out / name
    corrupt = source / "nanobench_corrupt"
    if corrupt.is_dir():
        done["nanobench_corrupt"] = corrupt
    return done


class Bench:
    def __init__(self, gustlab, out):
        self.gustlab, self.out = gustlab, out

    def diagnose(self, name, fit, holdout, arguments=()):
        """The diagnosis and its time and memory; a finished one is kept."""
        path, run = self.out / name / "diagnosis.json", self.out / f"{name}.run.json"
        if path.exists() and run.exists():
            return json.loads(path.read_text(encoding="utf-8")), json.loads(run.read_text(encoding="utf-8"))
        command = [self.gustlab, "diagnose", *map(str, fit), *(text for path in holdout for text in ("--holdout", str(path))),
                   "--out", str(self.out / name), *arguments]
        figures = run_measured(command, self.out / f"{name}.messages.txt")
        run.write_text(json.dumps(figures) + "\n", encoding="utf-8")
        return (json.loads(path.read_text(encoding="utf-8")) if figures["exit_code"] == 0 and path.exists() else None), figures

    def replay(self, flights, model, vehicle):
        command = [self.gustlab, "replay", *map(str, flights), "--vehicle", vehicle, "--with", str(model), "--horizon", "0.5",
                   "--stride", "1", "--format", "json"]
        result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
        return json.loads(result.stdout) if result.returncode == 0 else {"failed": result.stderr.strip()}


def names(diagnosis):
    return [label(effect) for effect in diagnosis["effects"]]


def named(diagnosis, wanted):
    """Whether a name is `wanted`; to be one of its class is not enough."""
    return wanted in names(diagnosis)


def among(diagnosis, wanted):
    """Whether a name, or one of its class, is `wanted` (rotor_loss#3 for a rotor)."""
    effect, _, rotor = wanted.partition("#")
    return any(means(found, effect, int(rotor) if rotor else None) for found in diagnosis["effects"])


def findings(diagnosis, kind):
    return [finding for finding in diagnosis["log_findings"] if finding["kind"] == kind]


def value(diagnosis, effect, parameter, flight=None):
    """A parameter of a name, or what it is in one flight; None: not named."""
    for found in diagnosis["effects"]:
        if found["effect"] == effect:
            return (found["per_flight"][flight] if flight else found["parameters"])[parameter]["value"]
    return None


def row(case, wanted, diagnosis, good):
    found = "no diagnosis" if diagnosis is None else ", ".join(names(diagnosis)) or diagnosis["verdict"]
    return {"case": case, "wanted": wanted, "found": found, "verdict": diagnosis and diagnosis["verdict"], "good": bool(diagnosis and good(diagnosis))}


def nanodrone(bench, folder):
    flights = sorted(folder.glob("train_*.csv*"))
    held = [path for path in flights if "_run2" in path.name]
    fit = [path for path in flights if path not in held]
    diagnosis, figures = bench.diagnose("nanodrone", fit, held)
    rows = [row("nanodrone", wanted, diagnosis, good) for wanted, good in (
        ("rotor_drag", lambda d: among(d, "rotor_drag")), ("flapping_torque", lambda d: among(d, "flapping_torque")),
        ("rotor_inertia", lambda d: among(d, "rotor_inertia")), ("yaw torque of the wrong size", lambda d: among(d, "yaw_torque_ratio")),
        ("yaw torque of the wrong sign", lambda d: findings(d, "sign")))]
    result = {"seconds": figures["seconds"], "peak_MiB": figures["peak_MiB"], "published": PUBLISHED, "goal": GOAL}
    if diagnosis is not None:
        augmented = bench.out / "nanodrone" / "augmented.toml"
        test = bench.replay(sorted(folder.glob("test_*.csv*")), augmented, diagnosis["vehicle"])
        result["test"] = test
        if "failed" not in test:
            result["after"] = {q: test[q]["after"][0] for q in QUANTITIES}
            result["physics_after"] = {q: test[q].get("after_physics", test[q]["after"])[0] for q in QUANTITIES}
            result["habit"] = "habit" in diagnosis
            rows += [{"case": "nanodrone test, 0.5 s", "wanted": f"{q} at most {GOAL[q]}", "found": f"{result['after'][q]:.4f}",
                      "verdict": diagnosis["verdict"], "good": result["after"][q] <= GOAL[q]} for q in QUANTITIES]
    return rows, result


def nanobench(bench, folder, corrupt):
    flights = sorted(path for path in folder.glob("B[236]*.csv*"))
    bad = sorted(corrupt.glob("B9*.csv*"))
    diagnosis, _ = bench.diagnose("nanobench", [*flights[:2], *bad], flights[2:])
    rows = [row("nanobench", wanted, diagnosis, lambda d, wanted=wanted: named(d, wanted))
            for wanted in ("battery_sag", "motor_lag", "rotor_drag")]
    aside = lambda d: any(f["role"] == "set_aside" and f["file"].startswith("B9") for f in d["flights"])
    return rows + [row("nanobench", "corrupt file set aside, with the reason", diagnosis,
                       lambda d: aside(d) and any(f["file"].startswith("B9") for f in d["log_findings"]))]


def arpl(bench, folder):
    diagnosis, _ = bench.diagnose("arpl", [next(folder.glob("log10*.csv*"))], [])
    lag = diagnosis and value(diagnosis, "motor_lag", "time_constant")
    result = row("arpl log10 (no pose)", "motor_lag of 75 ms within 10 %", diagnosis, lambda d: lag is not None and abs(lag / 0.075 - 1) <= 0.1)
    if lag is not None:
        result["found"] += f" ({1e3 * lag:.1f} ms)"
    return [result]


def crazypad(bench, folder):
    rows = []
    log = lambda name: next(folder.glob(f"{name}*.csv*"))
    silent = lambda d: not d["effects"]
    # the second flight is another one of the same vehicle, against which the first is judged
    for case, flight, normal, wanted, good in (
            ("cut propeller", "cut_propeller_M3_3mm_3mm_41mm-E8_log00", "normal_flight-E8_log00", "rotor_loss of M3", lambda d: among(d, "rotor_loss#3")),
            ("cut propeller, 2nd", "cut_propeller_M3_3mm_3mm_41mm-E8_log01", "normal_flight-E8_log01", "rotor_loss of M3", lambda d: among(d, "rotor_loss#3")),
            ("added weight", "add_weight_W3_near_M3-E9_log00", "normal_flight-E9_log00", "center_of_mass toward M3", lambda d: among(d, "center_of_mass")),
            ("added weight, 2nd", "add_weight_W3_near_M3-E9_log02", "normal_flight-E9_log03", "center_of_mass toward M3", lambda d: among(d, "center_of_mass")),
            ("normal flight E8", "normal_flight-E8_log01", "normal_flight-E8_log00", "nothing", silent),
            ("normal flight E9", "normal_flight-E9_log03", "normal_flight-E9_log00", "nothing", silent)):
        diagnosis, _ = bench.diagnose("crazypad_" + flight, [log(normal), log(flight)], [])
        acceptable = lambda d, good=good: good(d) or d["verdict"] == "insufficient_data"
        rows.append(row(f"crazypad {case}", wanted + ", or insufficient_data", diagnosis, acceptable))
    return rows


# family/set -> what is known of it: names, and sizes where they are published (parameter, value)
KNOWN = {
    "imrc/bare": {"rotor_drag": None, "flapping_torque": None, "rotor_inertia": None, "battery_sag": None, "motor_lag": ("time_constant", 0.0375)},
    "imrc/brushed": {"rotor_drag": None, "battery_sag": None, "motor_lag": None},
    "neurobem/lemniscate": {"rotor_drag": ("at_hover", 0.1875), "flapping_torque": None, "translational_lift": None},
    "neuralfly/tunnel": {"steady_wind": None, "quadratic_drag": None},
    "neuralswarm/large": {"ground_effect": None, "motor_lag": ("time_constant", 0.057), "rotor_drag": None},
}


def tunnel_wind(diagnosis):
    """Neural-Fly's fan at its full speed against the flight in still air, which an offset of the attitude shifts alike."""
    still, full = (diagnosis and value(diagnosis, "steady_wind", "x", f"fit_{flight}.csv") for flight in ("NF_nowind", "NF-T_100wind"))
    speed_mps = None if still is None else still - full
    result = row("neuralfly/tunnel", "wind of 100wind 12.1 m/s more than of nowind, within 30 %", diagnosis,
                 lambda d: speed_mps is not None and abs(speed_mps / 12.1 - 1) <= 0.3)
    if speed_mps is not None:
        result["found"] += f" ({speed_mps:.1f} m/s)"
    return result


def families(bench, folder):
    rows = []
    for place, known in KNOWN.items():
        if not (folder / place).is_dir():
            continue
        diagnosis, figures = bench.diagnose(place.replace("/", "_"), sorted((folder / place).glob("fit_*.csv")), sorted((folder / place).glob("holdout_*.csv")))
        for wanted, size in known.items():
            def good(d, wanted=wanted, size=size):
                return among(d, wanted) and (size is None or (v := value(d, wanted, size[0])) is None or abs(v / size[1] - 1) <= 0.3)
            rows.append(row(f"{place} ({figures['cpu_seconds']:.0f} s of CPU)", wanted + (f", {size[0]} {size[1]:g} within 30 %" if size else ""), diagnosis, good))
        if place == "neuralfly/tunnel":
            rows.append(tunnel_wind(diagnosis))
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("flights", type=Path)
    parser.add_argument("--gustlab", default="build/release/gustlab")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", choices=["nanodrone", "nanobench", "arpl", "crazypad", "families", "semi_real"])
    parser.add_argument("--semi-real", type=int, default=260, help="number of semi-real cases")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    with open(options.out / "import.messages.txt", "wb") as log:
        folders = import_flights(options.flights, options.out / "flights", log)
    bench, result = Bench(options.gustlab, options.out), {"cases": []}
    wants = lambda name: options.only in (None, name)
    if wants("nanodrone") and "nanodrone" in folders:
        rows, result["nanodrone"] = nanodrone(bench, folders["nanodrone"])
        result["cases"] += rows
    if wants("nanobench") and "nanobench" in folders:
        result["cases"] += nanobench(bench, folders["nanobench"], folders.get("nanobench_corrupt", folders["nanobench"]))
    if wants("arpl") and "arpl" in folders:
        result["cases"] += arpl(bench, folders["arpl"])
    if wants("crazypad") and "crazypad" in folders:
        result["cases"] += crazypad(bench, folders["crazypad"])
    if wants("families") or wants("semi_real"):
        lay_out(options.flights, options.out / "families")
    if wants("families"):
        result["cases"] += families(bench, options.out / "families")
    if wants("semi_real"):
        cases = semi_real.table(options.out / "families", semi_real.SETS)[:options.semi_real]
        result["semi_real"] = semi_real.run(options.out / "families", options.out / "semi_real", options.gustlab, options.jobs, cases)
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
