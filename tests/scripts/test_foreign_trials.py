"""Trials of foreign_trials.py: the physics balances, the files say it, what is concealed acts, and what counts."""

import json
import os
import subprocess
import sys
import tomllib
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts" / "prove"))

import foreign_trials  # noqa: E402
from flight_files import read_log, read_vehicle, rotor_speed  # noqa: E402
from foreign_trials import (CRAFTS, EFFECTS, G, OUTSIDE, STEP_S, STYLES, Plant, Reality, allowed, built, conceal, draw, draw_outside, draw_setting,  # noqa: E402
                            fly, judge, markdown, plan, record, sizes, write_vehicle)

PROGRAM = os.environ.get("GUSTLAB_PROGRAM", ROOT / "build" / "release" / "gustlab")
each_craft = pytest.mark.parametrize("craft", CRAFTS.values(), ids=CRAFTS)


@pytest.fixture
def short(monkeypatch):
    monkeypatch.setattr(foreign_trials, "SETTLE", 600)
    monkeypatch.setattr(foreign_trials, "draw_setting", lambda *given: replace(draw_setting(*given), seconds=(0.5, 0.6, 0.7, 0.8)))


def ideal(craft, **values):
    return Reality(craft.mass, np.array(craft.inertia), np.zeros(3), np.ones(craft.count), (0.02, 0.02), values)


@each_craft
def test_hover_stands_still(craft):
    plant = Plant(craft, ideal(craft), np.array([[0, 0, 1.0]]))
    for k in range(200):
        specific = plant.step(k, plant.speed, np.ones(1))
    assert specific[0] == pytest.approx([0, 0, G], abs=1e-9)
    assert plant.p[0] == pytest.approx([0, 0, 1], abs=1e-9) and plant.R[0] == pytest.approx(np.eye(3), abs=1e-9)


@each_craft
def test_free_fall_is_weightless_and_falls(craft):
    plant = Plant(craft, ideal(craft), np.array([[0, 0, 100.0]]))
    plant.speed[:] = 0
    for k in range(500):
        specific = plant.step(k, 0 * plant.speed, np.ones(1))
    assert specific[0] == pytest.approx([0, 0, 0], abs=1e-12)
    assert plant.p[0, 2] == pytest.approx(100 - 0.5 * G * 0.5**2, abs=1e-9)


@each_craft
def test_torques_are_those_of_the_vehicle_file(craft, tmp_path):
    write_vehicle(tmp_path, craft, craft.known)
    file = read_vehicle(tmp_path / "vehicle.toml")
    assert file.hover_speed == pytest.approx(craft.hover) and np.linalg.matrix_rank(np.c_[np.ones(craft.count), file.hub[:, :2], file.direction]) == 4
    for rotor in range(craft.count):
        plant = Plant(craft, ideal(craft), np.zeros((1, 3)))
        plant.speed[0, rotor] *= 1.1
        _, torque = plant.wrench(0, plant.R, plant.p, plant.v, plant.w, plant.speed, 0 * plant.speed)
        more = file.thrust[rotor] * 0.21 * file.hover_speed**2
        assert torque[0] == pytest.approx(np.cross(file.hub[rotor], [0, 0, more]) - [0, 0, file.direction[rotor] * file.torque_ratio * more], rel=1e-9)


@each_craft
def test_air_resists_and_wind_pushes(craft):
    def force(speed, **values):
        plant = Plant(craft, ideal(craft, **values), np.zeros((1, 3)))
        specific, torque = plant.wrench(0, plant.R, plant.p, np.array([speed]), plant.w, plant.speed, 0 * plant.speed)
        return craft.mass * specific[0] - [0, 0, craft.weight], torque[0]

    drag = {"at_hover": 0.1}
    assert force((2.0, 0, 0), rotor_drag=drag)[0] == pytest.approx([-0.2, 0, 0], abs=1e-9)
    assert force((0, 0, 0.0), rotor_drag=drag, steady_wind={"y": 2.0})[0] == pytest.approx([0, 0.2, 0], abs=1e-9)
    assert force((0, 0, 1.0), axial_inflow=drag)[0] == pytest.approx([0, 0, -0.1], abs=1e-9)
    assert force((0, -2.0, 0), quadratic_drag={"area_xy": 0.01})[0] == pytest.approx([0, 0.5 * 1.225 * 0.01 * 4, 0])
    # nose up, about −y, when it moves forward
    assert force((1.0, 0, 0), flapping_torque={"coefficient": 1e-6})[1][1] == pytest.approx(-1e-6 * craft.count * craft.hover)


def flown(craft, style, effects, seed=5, **changes):
    """(file's effects, setting, flights) of one calm flight with what is concealed; the same draw whatever is concealed."""
    rng = np.random.default_rng(seed)
    known = {effect: dict(values) for effect, values in craft.known.items()}
    reality = built(craft, known, rng)
    for effect in effects:
        conceal(effect, craft, known, reality, np.random.default_rng(1))
    setting = replace(draw_setting(style, "calm", effects, rng), **changes)
    return reality, setting, fly(craft, reality, setting, rng)


@cache
def surveyed(kind, *effects):
    """What is recorded of the survey craft where `effects` are concealed; where nothing is, it is flown once for all of them."""
    craft = CRAFTS["survey"]
    reality, setting, flights = flown(craft, "mocap", effects, kinds=(kind,), seconds=(3.0,), actuator="rotor_speed", loop="pid")
    return record(craft, reality, setting, flights, 0, np.random.default_rng(2)).column


@pytest.mark.parametrize("effect", [effect for effect in EFFECTS if effect != "saturation"])
def test_every_effect_changes_the_record(effect, short):
    kind = "stairs" if effect == "ground_effect" else "steps"
    without, changed = surveyed(kind), surveyed(kind, effect)
    assert max(np.abs(without[name] - changed[name]).max() for name in ("px", "wx", "wz", "ax", "az", "u1", "qx")) > 1e-3


def test_saturation_is_a_ceiling_of_the_rotors():
    craft = CRAFTS["survey"]
    reality = ideal(craft, saturation={"max_speed": 700.0})
    plant = Plant(craft, reality, np.zeros((1, 3)))
    for k in range(500):
        plant.step(k, np.full((1, 4), craft.top), np.ones(1))
    assert plant.speed == pytest.approx(700.0)


@each_craft
def test_nothing_concealed_leaves_only_noise(craft, tmp_path, short):
    reality, setting, flights = flown(craft, "estimator", (), kinds=("circle",), seconds=(4.0,), vibration=0.0, actuator="thrust")
    log = record(craft, reality, setting, flights, 0, np.random.default_rng(2))
    write_vehicle(tmp_path, craft, craft.known)
    file, c = read_vehicle(tmp_path / "vehicle.toml"), log.column
    known = {effect["type"]: effect for effect in file.effects}
    number = lambda effect, name: known.get(effect, {}).get(name, 0.0)
    speed, v_W = rotor_speed(log, file), np.column_stack([c["vx"], c["vy"], c["vz"]])
    w, q = np.column_stack([c["wx"], c["wy"], c["wz"]]), np.column_stack([c["qx"], c["qy"], c["qz"], c["qw"]])
    v = foreign_trials.Rotation.from_quat(q).inv().apply(v_W)
    area, share = np.array([number("quadratic_drag", "area_xy")] * 2 + [number("quadratic_drag", "area_z")]), speed / (len(file.thrust) * file.hover_speed)
    force = -0.5 * 1.225 * area * np.linalg.norm(v, axis=1)[:, None] * v
    force[:, :2] -= number("rotor_drag", "at_hover") * share.sum(axis=1)[:, None] * v[:, :2]
    for i, hub in enumerate(file.hub):
        local = v + np.cross(w, hub)
        force[:, 2] += file.thrust[i] * speed[:, i]**2 - number("axial_inflow", "at_hover") * share[:, i] * local[:, 2] \
            + number("translational_lift", "coefficient") * (local[:, :2]**2).sum(axis=1)
    left = np.column_stack([c["ax"], c["ay"], c["az"]]) - force / file.mass
    # what is left is noise and bias of the accelerometer and the build
    assert left.std(axis=0).max() < 1.15 * setting.accel_mps2 and np.abs(left.mean(axis=0)).max() < 0.16


def test_a_trial_depends_on_seed_and_number_alone(tmp_path, short):
    truth = [draw(3, number, tmp_path / name) for number, name in ((6, "a"), (6, "b"), (7, "b"))]
    assert truth[0] == truth[1] and json.dumps(truth[0])
    files = [{str(p.relative_to(tmp_path / name / "trial_0007")): p.read_bytes() for p in (tmp_path / name / "trial_0007").rglob("*.*")} for name in "ab"]
    assert files[0] == files[1] and len(files[0]) == 10
    assert (tmp_path / "b/trial_0008/fit_1.csv").read_bytes() != files[0]["fit_1.csv"]
    for text in files[0].values():
        assert all(e["effect"].encode() not in text or e["effect"] in CRAFTS[truth[0]["vehicle"]].known for e in truth[0]["effects"])


def test_a_style_and_an_air_for_all_leave_out_what_they_cannot_show(tmp_path, short):
    numbers = {effects[0]: number for number in range(40) for kind, effects in [plan(3, number)] if kind == "single"}
    shown, hidden = (next(numbers[e] for e in EFFECTS if e in numbers and ("collective" in allowed([e])) == shows) for shows in (True, False))
    truth = draw(3, shown, tmp_path, "collective", "calm")
    assert (truth["style"], truth["air"]) == ("collective", "calm")
    assert draw(3, hidden, tmp_path, "collective", "calm") is None


def test_every_block_has_the_same_mixture():
    for seed in (1, 2):
        kinds = [plan(seed, number) for number in range(80)]
        assert [sum(kind == wanted for kind, _ in kinds) for wanted in ("nothing", "outside", "pair", "single")] == [10, 8, 16, 46]
        assert {effects[0] for kind, effects in kinds if kind == "single"} == set(EFFECTS)
        assert {effects[0] for kind, effects in kinds if kind == "outside"} == set(OUTSIDE)
        assert all(allowed(effects) for _, effects in kinds)


@each_craft
def test_sizes_are_those_of_a_vehicle(craft):
    for effect, (low, high, _) in sizes(craft).items():
        assert 0 < low < high, effect
    assert set(sizes(craft)) == set(EFFECTS)
    known = {"rotor_drag": {"at_hover": 1.0}, "motor_lag": craft.known["motor_lag"]}
    found = [conceal("rotor_drag", craft, file := {k: dict(v) for k, v in known.items()}, built(craft, file, np.random.default_rng(1)), np.random.default_rng(s))
             for s in range(20)]
    # what the file says is no part of the change
    assert {bool(f["file"]) for f in found} == {True, False} and all(f["parameters"]["at_hover"] > f["file"].get("at_hover", 0.0) for f in found)
    assert all(set(draw_outside(name, craft, np.random.default_rng(1))) for name in OUTSIDE)


@pytest.mark.skipif(not Path(PROGRAM).exists(), reason="no gustlab is built")
@pytest.mark.parametrize("style", STYLES)
def test_gustlab_reads_every_style(style, tmp_path, short):
    craft = CRAFTS["hexa"]
    reality, setting, flights = flown(craft, style, (), kinds=("eight",), seconds=(6.0,))
    write_vehicle(tmp_path / "vehicle", craft, craft.known)
    foreign_trials.write_log(tmp_path / "fit_1.csv", record(craft, reality, setting, flights, 0, np.random.default_rng(2)), "vehicle/vehicle.toml")
    assert tomllib.loads((tmp_path / "fit_1.meta.toml").read_text(encoding="utf-8"))["actuator"] == setting.actuator
    time_s = read_log(tmp_path / "fit_1.csv").column["time_s"]
    assert time_s[0] == 0 and np.all(np.diff(time_s) > 0.5 * STEP_S)
    done = subprocess.run([PROGRAM, "replay", tmp_path / "fit_1.csv", "--horizon", "0.2", "--format", "json"], capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr
    fit = json.loads(done.stdout)
    fit = fit.get("fit", fit)
    assert fit["windows"] > 5 and fit["position_m"]["before"][0] < 0.1 * fit["position_m"]["hold"][0]


# ---- scores -------------------------------------------------------------------------------------------------------------

def truth_of(*effects, kind="single"):
    return {"trial": "trial_0001", "kind": kind, "vehicle": "tiny", "style": "imu", "air": "calm",
            "effects": [{"effect": name, "rotor": rotor, "size": "0.1 of it"} for name, rotor in effects]}


def finding(name, *others, rotor=None):
    return {"effect": name, "confidence": 0.9, "class": [name, *others], "parameters": {"rotor": {"value": rotor}} if rotor else {}}


def outcome(truth, named=(), suspected=(), blind=(), verdict="explained"):
    return judge(truth, {"effects": list(named), "suspected": list(suspected), "verdict": verdict, "not_identifiable": [{"effect": name} for name in blind]}, {})["outcome"]


def test_outcomes():
    mass, loss = truth_of(("mass", None)), truth_of(("rotor_loss", 2))
    assert outcome(mass, [finding("mass")]) == outcome(mass, [finding("thrust_scale", "mass")]) == "exact"
    assert outcome(mass, [finding("mass"), finding("gust")]) == outcome(mass, [finding("gust")]) == "wrong"
    assert outcome(mass, suspected=[finding("mass")]) == "withheld" and outcome(mass, suspected=[finding("gust")]) == "nothing"
    assert outcome(mass, blind=["mass"]) == outcome(mass, verdict="insufficient_data") == "not_told"
    assert outcome(loss, [finding("rotor_loss", rotor=2)]) == "exact" and outcome(loss, [finding("rotor_loss", rotor=3)]) == "wrong"
    pair = truth_of(("mass", None), ("gyro_scale", None), kind="pair")
    assert outcome(pair, [finding("mass")]) == "part" and outcome(pair, [finding("mass"), finding("gyro_scale")]) == "exact"
    assert outcome(truth_of(kind="nothing")) == "exact" and outcome(truth_of(kind="nothing"), [finding("mass")]) == "wrong"
    load, thread = truth_of(("slosh", None), kind="outside"), truth_of(("tether", None), kind="outside")
    assert outcome(load) == outcome(load, [finding("slung_load")]) == outcome(thread) == "exact" and outcome(thread, [finding("slung_load")]) == "wrong"
    assert judge(mass, None, {"cpu_seconds": 3})["outcome"] == "failed"


def test_the_table_names_what_is_not_exact():
    text = markdown([judge(truth_of(("mass", None)), {"effects": [finding("gust")], "verdict": "explained"}, {"cpu_seconds": 12})])
    assert "trial_0001 tiny, imu, calm: wrong; there mass (0.1 of it); named gust (0.90)" in text and "| single | 1 | 0 | 1 |" in text


def test_a_group_without_processor_times_keeps_its_counts():
    assert "| all | 1 | 0 | 0 | 0 | 0 | 0 | 0 | 1 | – |" in markdown([judge(truth_of(("mass", None)), None, {})])
