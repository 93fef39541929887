"""Trials of rotorpy's vehicles: the file that says what they are, what is concealed, and what counts. Nothing here needs rotorpy."""

import sys
import tomllib
import xml.etree.ElementTree as xml
from collections import Counter
from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts" / "prove"))

from falsify import vehicle_text  # noqa: E402
from rotorpy_trials import (EFFECTS, HELD, SAMPLE_S, VEHICLES, Reality, Setting, balance, conceal, draw_effect, hover_speed, judge,  # noqa: E402
                            limit, markdown, nominal, plan, recorded, residual, rotorpy_of, size_error, speeds_of, vehicle_file)
from flight_files import Log  # noqa: E402

# a quadrotor in rotorpy's parameters, with every term
PARAMS = {"mass": 0.5, "Ixx": 3e-3, "Iyy": 3.2e-3, "Izz": 5e-3, "num_rotors": 4, "rotor_directions": np.array([1, -1, 1, -1]),
          "rotor_pos": {f"r{i + 1}": 0.12 * np.array([x, y, 0.0]) for i, (x, y) in enumerate([(1, 1), (1, -1), (-1, -1), (-1, 1)])},
          "rotor_speed_max": 1500, "k_eta": 5.57e-6, "k_m": 1.36e-7, "k_d": 1.19e-4, "k_z": 2.32e-4, "k_h": 3.39e-3, "k_flap": -1e-6,
          "c_Dx": 0.5e-2, "c_Dy": 0.5e-2, "c_Dz": 1e-2, "tau_m": 0.02}


def reality():
    return Reality(deepcopy(PARAMS), deepcopy(PARAMS))


def rotorpy_wrench(params, rate, speed, air):
    """rotorpy 3.0.0, multirotor.py, compute_body_wrench, written out for one instant."""
    hubs = np.array(list(params["rotor_pos"].values()))
    local = air[:, None] + np.cross(rate, hubs).T
    thrust = np.array([0, 0, params["k_eta"]])[:, None] * speed**2 + np.array([0, 0, params["k_h"]])[:, None] * (local[0]**2 + local[1]**2)
    hub_force = -speed * (np.diag([params["k_d"], params["k_d"], params["k_z"]]) @ local)
    body = -np.linalg.norm(air) * np.array([params["c_Dx"], params["c_Dy"], params["c_Dz"]]) * air
    flap = -params["k_flap"] * speed * np.cross(local.T, [0, 0, 1]).T
    yaw = params["rotor_directions"] * (np.array([0, 0, params["k_m"]])[:, None] * speed**2)
    return (thrust + hub_force).sum(axis=1) + body, np.cross(hubs, (thrust + hub_force).T).sum(axis=0) + (flap + yaw).sum(axis=1)


def write_vehicle(folder, params):
    table, mjcf = vehicle_file("test", params)
    folder.mkdir()
    (folder / "vehicle.toml").write_text(vehicle_text(table), encoding="utf-8")
    (folder / "vehicle.xml").write_text(mjcf, encoding="utf-8")
    return folder


def test_the_vehicle_file_gives_rotorpy_s_wrench(tmp_path):
    folder, rng, n = write_vehicle(tmp_path / "vehicle", PARAMS), np.random.default_rng(1), 20
    v, w, speed = 3 * rng.standard_normal((n, 3)), 2 * rng.standard_normal((n, 3)), 470 + 60 * rng.standard_normal((n, 4))
    column = {"time_s": SAMPLE_S * np.arange(n), "px": np.zeros(n), "qw": np.ones(n), **{q: np.zeros(n) for q in ("qx", "qy", "qz")}}
    column |= dict(zip(("vx", "vy", "vz"), v.T)) | dict(zip(("wx", "wy", "wz"), w.T)) | {f"rotor{i + 1}": speed[:, i] for i in range(4)}
    force, turn = balance(folder, Log("a.csv", {}, column))
    inertia = np.array([3e-3, 3.2e-3, 5e-3])
    for k in range(n):
        wanted, moment = rotorpy_wrench(PARAMS, w[k], speed[k], v[k])
        assert force[k] * 0.5 == pytest.approx(wanted, rel=1e-9)
        assert turn[k] * inertia == pytest.approx(moment - np.cross(w[k], inertia * w[k]), rel=1e-9, abs=1e-12)


def test_sizes_go_into_rotorpy_and_back():
    for effect in HELD:
        assert nominal({**PARAMS, **rotorpy_of(effect, nominal(PARAMS, effect), PARAMS)}, effect) == pytest.approx(nominal(PARAMS, effect))
    assert nominal(PARAMS, "flapping_torque") == {"coefficient": 1e-6} and nominal({**PARAMS, "k_h": 0.0}, "translational_lift") is None
    assert nominal(PARAMS, "quadratic_drag")["area_xy"] == pytest.approx(2 * 0.005 / 1.225)
    assert nominal(PARAMS, "rotor_drag")["at_hover"] == pytest.approx(4 * hover_speed(PARAMS) * 1.19e-4)


def test_the_file_is_one_of_the_project(tmp_path):
    folder = write_vehicle(tmp_path / "vehicle", {**PARAMS, "k_d": 0.0})
    table = tomllib.loads((folder / "vehicle.toml").read_text(encoding="utf-8"))
    assert [rotor["direction"] for rotor in table["rotor"]] == ["cw", "ccw", "cw", "ccw"]
    assert {effect["type"] for effect in table["effect"]} == set(HELD) - {"rotor_drag"}
    assert table["thrust"]["torque_ratio"] == pytest.approx(1.36e-7 / 5.57e-6)
    sites = xml.parse(folder / "vehicle.xml").getroot().findall(".//site")
    assert [site.get("name") for site in sites] == [rotor["site"] for rotor in table["rotor"]]


@pytest.mark.parametrize("effect", EFFECTS)
def test_what_is_concealed_is_between_file_and_reality(effect):
    for seed in range(8):
        drawn, made = draw_effect(effect, PARAMS, np.random.default_rng(seed)), reality()
        conceal(made, effect, drawn["parameters"], drawn["file"])
        assert 0.5 <= drawn["limits"] <= 10
        if effect not in HELD:
            assert all(np.array_equal(made.file[key], value) for key, value in PARAMS.items() if not isinstance(value, dict)) and not drawn["file"]
            continue
        assert nominal(made.real, effect) == pytest.approx(drawn["parameters"])
        assert (nominal(made.file, effect) or {}) == pytest.approx(drawn["file"])
        assert {e: nominal(made.file, e) for e in HELD if e != effect} == {e: nominal(PARAMS, e) for e in HELD if e != effect}


def test_bodies_are_changed_as_the_catalogue_says():
    made = reality()
    conceal(made, "mass", {"delta": 0.1}, {})
    conceal(made, "inertia", dict.fromkeys(("delta_x", "delta_y", "delta_z"), -0.2), {})
    conceal(made, "thrust_scale", {"delta": 0.05}, {})
    assert (made.real["mass"], made.real["Izz"]) == pytest.approx((0.55, 4e-3))
    # a scale takes the reaction torque with it, the ratio does not
    assert made.real["k_m"] / made.real["k_eta"] == pytest.approx(1.36e-7 / 5.57e-6) and made.real["k_eta"] == pytest.approx(1.05 * 5.57e-6)
    conceal(made, "yaw_torque_ratio", {"delta": 0.2}, {})
    assert made.real["k_m"] == pytest.approx(1.2 * 1.05 * 1.36e-7) and made.real["k_eta"] == pytest.approx(1.05 * 5.57e-6)
    conceal(made, "center_of_mass", {"x": 0.01, "y": 0.0, "z": 0.0}, {})
    assert made.real["rotor_pos"]["r1"] == pytest.approx([0.11, 0.12, 0.0]) and made.file["rotor_pos"]["r1"][0] == 0.12
    with pytest.raises(ValueError):
        conceal(made, "gust", {}, {})


def still_flight(n=1200):
    """A turning, hovering vehicle of made-up motion; the log starts after the settling."""
    t = SAMPLE_S * np.arange(n)
    zero = np.zeros((n, 3))
    return {"time_s": t[:, None], "x": np.column_stack([np.sin(t), t, 0 * t]), "v": np.column_stack([np.cos(t), 0 * t + 1, 0 * t]),
            "q": np.tile([0.0, 0, 0, 1], (n, 1)), "w": zero + [0, 0, 2.0], "turn": zero + [0, 0, 3.0], "accel": zero, "gyro": zero + [0, 0, 2.0],
            "u": np.full((n, 4), 470.0), "rotor": np.full((n, 4), 470.0)}


SILENT = Setting(position_m=0, velocity_mps=0, attitude_rad=0, rotor_share=0)


def test_sensors_record_as_the_catalogue_says():
    log = lambda effect, values, setting=SILENT: (conceal(made := reality(), effect, values, {}), recorded(still_flight(), made, setting, np.random.default_rng(0)))[1].column
    # p_log = p_com − R r_c, v_log = v_com − R (ω × r_c), and the accelerometer is at the logged point
    moved = log("center_of_mass", {"x": 0.01, "y": 0.0, "z": 0.0})
    assert (moved["px"][0], moved["vy"][0]) == pytest.approx((np.sin(2.0) - 0.01, 1 - 0.02))
    assert (moved["ax"][0], moved["ay"][0]) == pytest.approx((0.04, -0.03))
    lever = log("imu_lever", {"x": 0.01, "y": 0.0, "z": 0.0})
    assert (lever["ax"][0], lever["ay"][0], lever["px"][0]) == pytest.approx((-0.04, 0.03, np.sin(2.0)))
    late = log("pose_delay", {"delay": 0.012})
    assert late["px"][0] == pytest.approx(np.sin(2.0 - 0.012), abs=1e-8) and late["vx"][0] == pytest.approx(np.cos(2.0 - 0.012), abs=1e-8)
    assert log("gyro_scale", {"delta": 0.03})["wz"][0] == pytest.approx(2.06)
    assert log("attitude_offset", {"x": 0.02, "y": 0.0})["qx"][0] == pytest.approx(np.sin(0.01))
    slow = log("mass", {"delta": 0.0}, Setting(pose_every=2, rotors=True))
    assert np.isnan(slow["px"][1]) and np.isfinite(slow["px"][2]) and np.all(np.isfinite(slow["wz"])) and "rotor4" in slow and "rotor1" not in late


def test_the_balance_shows_a_thrust_that_is_not_in_the_file(tmp_path):
    folder, n = write_vehicle(tmp_path / "vehicle", PARAMS), 600
    hover = np.full(n, hover_speed(PARAMS))
    column = {"time_s": SAMPLE_S * np.arange(n), **{name: np.zeros(n) for name in ("px", "vx", "vy", "vz", "qx", "qy", "qz", "wx", "wy", "wz", "ax", "ay")},
              "qw": np.ones(n), "az": np.full(n, 1.04 * 9.81), **{f"u{i + 1}": hover for i in range(4)}}
    left = residual(folder, Log("a.csv", {}, column))
    assert left["force"][0] == pytest.approx([0, 0, 0.04 * 9.81]) and left["rate"][1] == pytest.approx([0, 0, 0], abs=1e-9)
    step = {**column, **{f"u{i + 1}": np.where(np.arange(n) < 3, 400.0, 500.0) for i in range(4)}}
    assert speeds_of(Log("a.csv", {}, step), 0.02)[4, 0] == pytest.approx(500 - 100 * np.exp(-0.25))


def test_a_plan_is_mixed_and_names_every_effect():
    planned = plan(71, 40)
    assert Counter(kind for kind, *_ in planned) == {"single": 25, "pair": 7, "nothing": 8} and planned == plan(71, 40) != plan(72, 40)
    singles = Counter(effects[0] for kind, _, effects, _ in planned if kind == "single")
    assert set(singles) == set(EFFECTS) and max(singles.values()) == 2
    assert {vehicle for _, vehicle, *_ in planned} == set(VEHICLES) and {air for *_, air in planned} == {"calm", "mild"}
    assert all(len(set(effects)) == {"single": 1, "pair": 2, "nothing": 0}[kind] for kind, _, effects, _ in planned)
    assert limit("steady_wind", PARAMS) > 0 and limit("mass", PARAMS) == 0.012


# ---- what counts ------------------------------------------------------------------------------------------------------

def finding(effect, alike=(), **parameters):
    return {"effect": effect, "class": [effect, *alike], "parameters": {name: {"value": value} for name, value in parameters.items()}}


def row(named, suspected=(), *, hidden=({"effect": "mass", "rotor": None, "file": {}, "parameters": {"delta": 0.05}, "limits": 4.0},), kind="single"):
    truth = {"trial": "trial_001", "kind": kind, "vehicle": "crazyflie", "air": "calm", "effects": list(hidden)}
    return judge(truth, None if named is None else {"verdict": "explained", "effects": list(named), "suspected": list(suspected)})


def test_outcomes():
    mass, drag = finding("mass", delta=0.05), finding("rotor_drag", at_hover=0.02)
    assert row([mass])["outcome"] == "exact" and row([finding("thrust_scale", ["mass"], delta=-0.05)])["outcome"] == "exact"
    assert row([mass, drag])["outcome"] == "wrong" and row([mass, drag])["wrong"] == ["rotor_drag"]
    assert row([], [mass])["outcome"] == "withheld" and row([], [drag])["outcome"] == "nothing" and row([])["outcome"] == "nothing"
    assert row(None)["outcome"] == "failed"
    assert row([], [drag], hidden=(), kind="nothing")["outcome"] == "exact" and row([drag], hidden=(), kind="nothing")["outcome"] == "wrong"
    pair = ({"effect": "mass", "rotor": None, "file": {}, "parameters": {"delta": 0.05}, "limits": 4.0},
            {"effect": "rotor_loss", "rotor": 2, "file": {}, "parameters": {"rotor": 2, "loss": 0.04}, "limits": 4.0})
    assert row([mass], hidden=pair)["outcome"] == "partial" and row([mass, finding("rotor_loss", rotor=2, loss=0.04)], hidden=pair)["outcome"] == "exact"
    assert row([mass, finding("rotor_loss", rotor=3, loss=0.04)], hidden=pair)["outcome"] == "wrong"


def test_size_is_measured_from_the_file():
    more = {"effect": "motor_lag", "rotor": None, "file": {"time_constant": 0.05}, "parameters": {"time_constant": 0.07}, "limits": 5.0}
    assert size_error(finding("motor_lag", time_constant=0.065), more) == pytest.approx(0.25)
    assert size_error(finding("actuation_delay", ["motor_lag"], delay=0.02), more) is None


def test_the_table_counts_each_trial_once_and_lists_what_is_not_exact():
    mass = finding("mass", delta=0.055)
    text = markdown([row([mass]), row([]), row([mass], hidden=(), kind="nothing")])
    assert "| mass | 2 | 1 | 0 | 0 | 1 | 0 | 0 | 10 % |" in text and "| nothing | 1 | 0 | 1 | 0 | 0 | 0 | 0 | – |" in text
    assert "| all | 3 | 1 | 1 | 0 | 1 | 0 | 0 | 10 % |" in text
    assert "where nothing is concealed: explained 1." in text
    assert text.count("\n- trial_001") == 2 and "there mass (4.0 limits); named –" in text and "there nothing; named mass; wrong mass" in text
