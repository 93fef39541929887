"""Semi-real cases: the inputs that conceal an effect, the faults of recordings and files, and what counts as right."""

import sys
from copy import deepcopy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

HOME = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(HOME / "scripts" / "prove"))

import conceal_inputs as physics  # noqa: E402
from falsify import VehicleFolder  # noqa: E402
from families import large_frame_thrust_N, merged, smallest_three  # noqa: E402
from flight_files import Log, read_vehicle  # noqa: E402
from semi_real import Case, change_inputs, change_recording, falsify_file, hover_difference, in_range, limit_of, limit_of_thirds, seen_away, sizes_before  # noqa: E402
from semi_real_outcomes import combined, judge, over_stated, summary  # noqa: E402

FILE = HOME / "models" / "imrc_brushed" / "vehicle.toml"
VEHICLE = read_vehicle(FILE)
EFFECTS = {"thrust_scale": {"delta": 0.05}, "rotor_loss": {"loss": 0.1, "rotor": 2}, "thrust_curve": {"curvature": -0.2}, "battery_sag": {"exponent": 1.5},
           "axial_inflow": {"at_hover": 0.012}, "translational_lift": {"coefficient": 3e-4}, "ground_effect": {"strength": 6.0},
           "yaw_torque_ratio": {"delta": 0.2}, "center_of_mass": {"x": 0.001, "y": -0.002}, "inertia": {"delta_x": 0.2, "delta_y": 0.2, "delta_z": 0.2}}


def flight(samples=200):
    """A motion and thrusts that have nothing to do with each other: the balance must hold all the same."""
    rng = np.random.default_rng(1)
    wander = lambda size, columns: size * rng.standard_normal((samples, columns))
    motion = physics.Motion(0.01 * np.arange(samples), wander(1, 3), wander(2, 3), wander(20, 3), [0, 0, 9.81] + wander(1, 3),
                            0.1 + np.abs(wander(0.2, 4)), 3.6 + 0.1 * rng.random(samples))
    return motion, VEHICLE.weight / 4 * (1 + 0.2 * rng.standard_normal((samples, 4)).clip(-2, 2))


@pytest.mark.parametrize("effect", EFFECTS)
def test_concealed_inputs_give_the_wrench_of_the_recording(effect):
    motion, thrust = flight()
    changed = physics.thrusts_with(VEHICLE, motion, thrust, effect, EFFECTS[effect])
    needed = physics.wrench(VEHICLE, motion, thrust) + physics.needed_besides(VEHICLE, motion, effect, EFFECTS[effect])
    assert physics.wrench(VEHICLE, motion, changed, effect, EFFECTS[effect]) == pytest.approx(needed, rel=1e-4, abs=1e-7)
    assert np.abs(changed - thrust).max() > 1e-4


def test_effects_have_the_catalogue_s_signs():
    motion, thrust = flight()
    change = lambda effect: physics.wrench(VEHICLE, motion, thrust, effect, EFFECTS[effect]) - physics.wrench(VEHICLE, motion, thrust)
    assert np.all(change("rotor_loss")[:, 0] < 0) and np.all(change("ground_effect")[:, 0] > 0) and np.all(change("translational_lift")[:, 0] > 0)
    # an inflow from above while climbing costs thrust; rotor 2 is back right: its loss rolls to the right (+x torque is roll to the right)
    motion.rate_B[:], motion.velocity_B[:] = 0.0, [0.0, 0.0, 1.0]
    assert np.all(change("axial_inflow")[:, 0] < 0)
    assert np.all(change("rotor_loss")[:, 1] > 0) and np.all(change("rotor_loss")[:, 2] < 0)
    # sag below the nominal voltage weakens
    assert np.all(change("battery_sag")[:, 0] < 0)


@pytest.mark.parametrize("actuator", ["rotor_speed", "thrust", "pwm"])
def test_inputs_and_thrusts_are_inverse(actuator):
    _, thrust = flight()
    for vehicle in (VEHICLE, read_vehicle(HOME / "models" / "crazyflie_21" / "vehicle.toml")):
        assert physics.thrust_of(physics.inputs_of(thrust, actuator, vehicle), actuator, vehicle) == pytest.approx(thrust)


def test_the_standard_error_falls_with_the_signature():
    motion, thrust = flight(3000)
    one = physics.standard_error(VEHICLE, [(motion, thrust)], "thrust_curve", {"curvature": 0.01})
    assert physics.standard_error(VEHICLE, [(motion, thrust)], "thrust_curve", {"curvature": 0.02}) == pytest.approx(one / 2, rel=1e-6)
    assert physics.standard_error(VEHICLE, [(motion, thrust)] * 4, "thrust_curve", {"curvature": 0.01}) == pytest.approx(one / 2, rel=1e-6)


def test_a_channel_of_noise_tells_nothing_of_its_scale():
    motion, thrust = flight(6000)
    rng = np.random.default_rng(2)
    commanded = physics.wrench(VEHICLE, motion, thrust)[:, 3]
    error = lambda: physics.standard_error(VEHICLE, [(motion, thrust)], "yaw_torque_ratio", {"delta": 0.01})
    # turned about z alone, by what is commanded and by as much again that is not
    motion.rate_B[:, :2] = motion.angular_B[:, :2] = 0.0
    motion.angular_B[:, 2] = commanded / VEHICLE.inertia[2]
    motion.angular_B[:, 2] += motion.angular_B[:, 2].std() * rng.standard_normal(6000)
    independent = 60 / physics.CORRELATION_S
    assert error() == pytest.approx(1 / (0.01 * np.sqrt(independent)), rel=0.3)  # r² = 1/2
    motion.angular_B[:, 2] = rng.permutation(motion.angular_B[:, 2])
    assert error() > 1 / (0.01 * np.sqrt(independent)) * 4


def test_flights_show_a_trim_by_themselves():
    motion, thrust = flight(3000)
    motion.time_s = 0.01 * np.arange(3000)
    # the recorded force is that of a thrust 4 % larger than the file's
    motion.specific_B[:, 2] = 1.04 * thrust.sum(axis=1) / VEHICLE.mass
    (size, weight), again = physics.sizes_shown(VEHICLE, [(motion, thrust)] * 2, "thrust_scale", {"delta": 0.01})
    assert size == pytest.approx(4.0, abs=0.05) and weight > 0 and again == (size, weight)
    assert physics.sizes_shown(VEHICLE, [(motion, thrust)], "inertia", {"delta_x": 0.01, "delta_y": 0.01, "delta_z": 0.01}) == []


def test_an_effect_is_seen_by_what_scales_of_thrust_and_torque_leave():
    rng = np.random.default_rng(2)
    motion, thrust = flight(3000)
    motion.time_s = 0.01 * np.arange(3000)
    # slow thrusts that a curve of 0.05 changes, in a vehicle whose thrust and torques are 3 % too large besides
    thrust = VEHICLE.weight / 4 * (1 + 0.4 * physics.low_pass(motion.time_s, rng.standard_normal((3000, 4)), 2))
    given = physics.wrench(VEHICLE, motion, thrust, "thrust_curve", {"curvature": 0.05}) * 1.03
    motion.rate_B[:] = 0.0
    motion.specific_B[:, 2], motion.angular_B = given[:, 0] / VEHICLE.mass, given[:, 1:] / VEHICLE.inertia
    (size, _), = physics.sizes_shown(VEHICLE, [(motion, thrust)], "thrust_curve", {"curvature": 0.01})
    assert size == pytest.approx(5 * 1.03, rel=0.02)
    # a curve is a scale of thrust and torques where all four do the same small steps
    thrust = np.repeat(thrust[:, :1], 4, axis=1)
    small = VEHICLE.weight / 4 * (1 + 0.05 * (thrust / (VEHICLE.weight / 4) - 1))
    error = [physics.standard_error(VEHICLE, [(motion, values)], "thrust_curve", {"curvature": 0.01}) for values in (thrust, small)]
    assert error[1] > 10 * error[0]


def test_a_flight_that_tells_little_counts_little_in_the_spread():
    assert physics.spread([(1.0, 5.0)]) == 0.0
    assert physics.spread([(1.0, 2.0), (3.0, 2.0)]) == pytest.approx(np.sqrt(2))
    assert physics.spread([(1.0, 1.0), (1.2, 1.0), (9.0, 1e-6)]) < 0.2


@pytest.mark.parametrize("effect, values", [("gyro_scale", {"delta": 0.03}), ("pose_delay", {"delay": 0.01}), ("yaw_offset", {"z": 0.05}),
                                            ("attitude_offset", {"x": 0.03}), ("attitude_offset", {"y": -0.02}), ("imu_lever", {"y": 0.02})])
def test_a_recording_shows_by_itself_what_is_concealed_in_a_sensor(effect, values):
    # it swings about two axes, drifts to the sides as that pushes it, and feels its thrust
    time_s = 0.01 * np.arange(4000)
    turn = Rotation.from_rotvec(np.column_stack([0.2 * np.sin(2 * time_s), 0.3 * np.sin(1.3 * time_s), 0.4 * np.sin(0.7 * time_s)]))
    rate = CubicSpline(time_s[:-1] + 0.005, (turn[:-1].inv() * turn[1:]).as_rotvec() / 0.01)(time_s)
    felt = np.column_stack([0 * time_s, 0 * time_s, np.full(4000, 9.81)])
    speed = CubicSpline(time_s, turn.apply(felt) - [0, 0, 9.81]).antiderivative()(time_s)
    columns = {"q": ("xyzw", turn.as_quat()), "w": ("xyz", rate), "v": ("xyz", speed), "a": ("xyz", felt)}
    column = {"time_s": time_s, **{name + axis: values[:, k] for name, (axes, values) in columns.items() for k, axis in enumerate(axes)}}
    log = Log("a.csv", {}, column)
    (axis, size), = values.items()
    shown = [physics.SEEN_BY_SENSORS[effect](seen, VEHICLE, axis) for seen in (log, change_recording(log, effect, values, None))]
    assert shown == pytest.approx([0.0, size], abs=0.05 * abs(size))


def test_an_origin_beside_the_center_of_mass_is_seen_to_turn_about_it():
    time_s = 0.01 * np.arange(1000)
    angle, rate = 0.5 * np.sin(2 * time_s), np.cos(2 * time_s)
    column = {"time_s": time_s, **{name: 0 * time_s for name in ("px", "py", "pz", "vx", "vy", "vz", "ax", "ay", "az", "qx", "qy", "wx", "wy")},
              "qz": np.sin(angle / 2), "qw": np.cos(angle / 2), "wz": rate}
    seen = seen_away(Log("a.csv", {}, column), np.array([0.1, 0.0, 0.02])).column
    inner = slice(100, -100)
    assert seen["px"][inner] == pytest.approx(0.1 * np.cos(angle)[inner], abs=1e-4) and seen["pz"] == pytest.approx(0.02 + 0 * time_s)
    assert seen["vy"][inner] == pytest.approx(0.1 * (rate * np.cos(angle))[inner], abs=1e-3)
    # in axes of the body: -r ω² along the arm, r dω/dt across it
    assert seen["ax"][inner] == pytest.approx(-0.1 * rate[inner] ** 2, abs=1e-3)
    assert seen["ay"][inner] == pytest.approx(-0.2 * np.sin(2 * time_s)[inner], abs=1e-2)
    assert list(seen["wz"]) == list(rate)


def test_files_are_wrong_by_as_much_as_the_case_says(tmp_path):
    for effect, values, rotor in (("mass", {"delta": 0.1}, None), ("thrust_scale", {"delta": 0.1}, None), ("rotor_loss", {"loss": 0.2}, 3),
                                  ("center_of_mass", {"x": 0.002}, None), ("inertia", {"delta_x": 0.1, "delta_y": 0.1, "delta_z": 0.1}, None)):
        file = VehicleFolder(FILE)
        falsify_file(file, effect, values, rotor)
        file.write(tmp_path / effect)
        wrong = read_vehicle(tmp_path / effect / "vehicle.toml")
        assert effect != "mass" or wrong.mass * 1.1 == pytest.approx(VEHICLE.mass)
        assert effect != "thrust_scale" or wrong.thrust * 1.1 == pytest.approx(VEHICLE.thrust)
        assert effect != "rotor_loss" or wrong.thrust[2] * 0.8 == pytest.approx(VEHICLE.thrust[2])
        assert effect != "center_of_mass" or wrong.center[0] + 0.002 == pytest.approx(VEHICLE.center[0])
        assert effect != "inertia" or wrong.inertia * 1.1 == pytest.approx(VEHICLE.inertia)


def test_only_inputs_that_the_actuator_takes_conceal():
    class Flown:
        vehicle = VEHICLE
        set = type("Set", (), {"latency_s": 0.0})

        @staticmethod
        def inputs(log):
            values = log.stack("u1", "u2", "u3", "u4")
            return ["u1", "u2", "u3", "u4"], np.ones(len(values), dtype=bool), log.column["time_s"], values

        @staticmethod
        def motion(log):
            return flight(100)[0], physics.thrust_of(log.stack("u1", "u2", "u3", "u4"), "pwm", VEHICLE)

    column = {"time_s": 0.01 * np.arange(100), **{f"u{i}": np.full(100, 60000.0) for i in range(1, 5)}}
    log = Log("a.csv", {"actuator": "pwm"}, column)
    assert in_range(log, Flown, "thrust_scale", {"delta": 0.1})        # stronger rotors need less
    assert not in_range(log, Flown, "thrust_scale", {"delta": -0.3})
    # a curve whose top lies below the thrusts that are needed conceals nothing
    assert not in_range(log, Flown, "thrust_curve", {"curvature": -0.49})
    hovering = Log("a.csv", {"actuator": "pwm"}, {**column, **{f"u{i}": np.full(100, 40000.0) for i in range(1, 5)}})
    assert in_range(hovering, Flown, "thrust_curve", {"curvature": -0.2})


def test_a_lag_of_the_inputs_that_conceal_one_gives_the_recorded_speeds():
    class Flown:
        @staticmethod
        def inputs(log):
            return ["u1"], np.ones(len(log.column["u1"]), dtype=bool), log.column["time_s"], log.stack("u1")

    time_s, lag_s = 0.002 * np.arange(4000), 0.016
    recorded = 1500 + 80 * np.sin(2 * np.pi * 6 * time_s) + 20 * np.sin(2 * np.pi * 25 * time_s) + 5 * np.random.default_rng(3).standard_normal(4000)
    log = Log("a.csv", {}, {"time_s": time_s, "u1": recorded})
    changed = change_inputs(log, Flown, "motor_lag", {"time_constant": lag_s, "time_constant_down": lag_s}).column["u1"]
    follows = lfilter([1 - np.exp(-0.002 / lag_s)], [1, -np.exp(-0.002 / lag_s)], changed - 1500)
    inner = slice(500, -500)
    clean = (recorded - 1500)[inner]
    # what is left is the speeds' own noise beyond the band of the motion, and half a sample of the filter
    assert np.std(follows[inner] - clean) < 0.12 * np.std(clean)


def test_a_late_pose_and_a_turned_attitude():
    time_s = 0.01 * np.arange(200)
    column = {"time_s": time_s, "px": np.sin(time_s), "py": time_s, "pz": 0 * time_s, "qw": np.ones(200), **{q: np.zeros(200) for q in ("qx", "qy", "qz")}}
    log = Log("a.csv", {}, column)
    late = change_recording(log, "pose_delay", {"delay": 0.02}, None)
    assert late.column["px"][50] == pytest.approx(np.sin(time_s[48]), abs=1e-6)
    turned = change_recording(log, "attitude_offset", {"x": 0.02}, None)
    assert turned.column["qx"] == pytest.approx(np.sin(0.01)) and log.column["qx"][0] == 0


def test_streams_keep_their_own_times():
    time_s, columns = merged({("a",): (np.array([0.0, 0.01]), np.array([[1.0], [2.0]])), ("b",): (np.array([0.01, 0.0151]), np.array([[3.0], [4.0]]))})
    assert time_s.tolist() == pytest.approx([0, 0.01, 0.0151])
    assert columns["a"][:2].tolist() == [1, 2] and np.isnan(columns["a"][2]) and np.isnan(columns["b"][0]) and columns["b"][2] == 4


def test_packed_quaternions_and_published_thrust():
    # (x, y, z, w) = (0.5, -0.25, 0.1, largest)
    pack = lambda value: (512 if value < 0 else 0) | int(511 * abs(value) / np.sqrt(0.5) + 0.5)
    packed = np.array([3 << 30 | pack(0.5) << 20 | pack(-0.25) << 10 | pack(0.1)], dtype=float)
    assert smallest_three(packed)[0, 1:] == pytest.approx([0.5, -0.25, 0.1], abs=1e-3)
    assert np.linalg.norm(smallest_three(packed)) == pytest.approx(1)
    assert large_frame_thrust_N(0.6 * 65536, 3.7) == pytest.approx(9.80665e-3 * (44.104 - 73.506 - 31.877 + 19.119 + 56.916), rel=1e-4)


# ---- what counts ------------------------------------------------------------------------------------------------------

def finding(effect, alike=(), **parameters):
    return {"effect": effect, "confidence": 0.9, "class": [effect, *alike], "parameters": {name: {"value": value} for name, value in parameters.items()}}


def diagnosis(*effects, suspected=()):
    return {"verdict": "explained", "effects": list(effects), "suspected": list(suspected), "rejected": []}


def outcome(found, asked="file", base=(), before=None, effect="thrust_scale", rotor=None, **parameters):
    case = Case("c", "s", "input", asked, effect, parameters or {"delta": 0.04}, rotor, 2.0)
    return judge(case, found, diagnosis(*base) if asked == "file" else None, before)["outcome"]


DRAG = finding("rotor_drag", ["quadratic_drag"], at_hover=0.02)


def test_a_new_name_alone_is_exact_and_any_other_new_name_is_wrong():
    found = finding("thrust_scale", delta=0.041)
    assert outcome(diagnosis(found)) == "exact"
    assert outcome(diagnosis(DRAG, found), base=[DRAG]) == "exact"
    assert outcome(diagnosis(DRAG, found)) == "wrong"
    assert outcome(diagnosis(finding("mass", delta=-0.04))) == "wrong"
    assert outcome(diagnosis(finding("mass", ["thrust_scale"], delta=-0.04))) == "exact"
    assert outcome(diagnosis(suspected=[found])) == "withheld" and outcome(diagnosis()) == "nothing"
    assert outcome(diagnosis(finding("quadratic_drag", ["rotor_drag"], area_xy=0.01), found), base=[DRAG]) == "exact"


def test_what_the_untouched_flights_suspect_is_no_new_name():
    case = Case("c", "s", "input", "file", "thrust_scale", {"delta": 0.04}, None, 2.0)
    row = judge(case, diagnosis(DRAG, finding("thrust_scale", delta=0.041)), diagnosis(suspected=[DRAG]))
    assert row["outcome"] == "exact" and row["crossed"] == ["rotor_drag"] and row["wrong"] == []
    row = judge(case, diagnosis(finding("mass", delta=0.04)), diagnosis(suspected=[DRAG]))
    assert row["outcome"] == "wrong" and row["crossed"] == []


def test_what_the_authors_of_flights_report_is_no_wrong_name():
    case = Case("c", "s", "input", "file", "thrust_scale", {"delta": 0.04}, None, 2.0)
    row = judge(case, diagnosis(DRAG, finding("thrust_scale", delta=0.041)), diagnosis(), reported=("rotor_drag",))
    assert row["outcome"] == "exact" and row["reported"] == ["rotor_drag"] and row["wrong"] == []
    assert judge(case, diagnosis(DRAG), diagnosis(), reported=("rotor_drag",))["outcome"] == "nothing"
    assert judge(case, diagnosis(DRAG), diagnosis(), reported=("mass",))["outcome"] == "wrong"
    # beside reference flights only what each flight has for itself
    case = Case("c", "s", "nothing", "reference")
    wind = {**finding("steady_wind", x=3.0), "per_flight": {"a": {}}}
    assert judge(case, diagnosis(wind), diagnosis(), reported=("steady_wind",))["outcome"] == "exact"
    assert judge(case, diagnosis(DRAG), diagnosis(), reported=("rotor_drag",))["outcome"] == "wrong"


def test_what_logs_do_not_tell_is_counted_apart():
    says_so = {**diagnosis(), "not_identifiable": [{"effect": "thrust_scale", "why": "no torque"}]}
    assert outcome(says_so) == "not_told" and outcome({**says_so, "not_identifiable": [{"effect": "mass", "why": ""}]}) == "nothing"


def test_a_size_is_compared_with_what_the_untouched_flights_say_would_show():
    would_show = lambda effect, **sizes: {"effect": effect, "why": "", "would_show": {key: {"value": size} for key, size in sizes.items()}}
    case = lambda effect, **parameters: Case("c", "s", "input", "file", effect, parameters, parameters.get("rotor"), 2.0)
    untouched = {**diagnosis(), "rejected": [would_show("center_of_mass", x=0.002, y=0.004), would_show("rotor_loss (rotor 1)", loss=0.02),
                                             would_show("rotor_loss (rotor 3)", loss=0.05)]}
    assert over_stated(case("center_of_mass", x=-0.003, y=0.004), untouched) == pytest.approx(1.5)
    assert over_stated(case("rotor_loss", loss=0.1, rotor=3), untouched) == pytest.approx(2.0)
    assert over_stated(case("rotor_loss", loss=0.1, rotor=2), untouched) == pytest.approx(5.0)
    assert over_stated(case("mass", delta=0.1), untouched) == 0.0
    named = {**diagnosis(), "effects": [{**DRAG, "parameters": {"at_hover": {"value": 0.02, "std": 0.001}}}]}
    assert over_stated(case("rotor_drag", at_hover=0.01), named) == pytest.approx(2.0)


def test_what_was_named_before_must_have_moved():
    before = finding("thrust_scale", delta=0.10)
    assert outcome(diagnosis(before), base=[before], before={"delta": 0.10}) == "nothing"
    assert outcome(diagnosis(finding("thrust_scale", delta=1.1 * 1.04 - 1)), base=[before], before={"delta": 0.10}) == "exact"


def test_a_name_that_was_there_is_no_hit_for_a_wider_class():
    vague = finding("rotor_drag", ["thrust_scale"], at_hover=0.02)
    assert outcome(diagnosis(vague), base=[DRAG]) == "nothing" and outcome(diagnosis(vague), base=[]) == "exact"


def test_a_late_thrust_is_missing_what_it_changes_by():
    """Of a lag or a delay the wrench lacks the time times the rate of change, so its limit is five standard errors like any other's."""
    motion, thrust = flight(2000)
    thrust[:] = VEHICLE.weight / 4 * (1 + 0.2 * np.sin(2 * np.pi * 1.5 * motion.time_s)[:, None] * [1, -1, -1, 1])
    late = {"delay": 0.01}
    change = physics.signature(VEHICLE, motion, thrust, "actuation_delay", late)
    earlier = physics.wrench(VEHICLE, motion, VEHICLE.weight / 4 * (1 + 0.2 * np.sin(2 * np.pi * 1.5 * (motion.time_s - 0.01))[:, None] * [1, -1, -1, 1]))
    assert change[100:-100, 2] == pytest.approx((earlier - physics.wrench(VEHICLE, motion, thrust))[100:-100, 2], abs=0.06 * np.abs(change[:, 2]).max())
    assert np.isfinite(physics.standard_error(VEHICLE, [(motion, thrust)], "motor_lag", {"time_constant": 0.01}))


def test_reference_flights_ask_for_the_size():
    assert outcome(diagnosis(finding("thrust_scale", delta=0.05)), asked="reference") == "exact"
    assert outcome(diagnosis(finding("thrust_scale", delta=0.06)), asked="reference") == "size"
    assert outcome(diagnosis(finding("rotor_loss", rotor=2, loss=0.04)), "reference", effect="rotor_loss", rotor=2, loss=0.04, **{}) == "exact"
    assert outcome(diagnosis(finding("rotor_loss", rotor=3, loss=0.04)), "reference", effect="rotor_loss", rotor=2, loss=0.04) == "wrong"


def test_nothing_concealed_wants_nothing_and_a_wrong_file_is_no_change():
    nothing = Case("untouched", "s", "nothing", "reference")
    assert judge(nothing, diagnosis())["outcome"] == "exact" and judge(nothing, diagnosis(DRAG))["outcome"] == "wrong"
    # every flight has its own wind: no change, where the untouched flights have one
    wind = {**finding("steady_wind", x=2.0), "per_flight": {"a.csv": {}}}
    assert judge(nothing, diagnosis(wind), diagnosis(wind))["outcome"] == "exact"
    assert judge(nothing, diagnosis(wind), diagnosis())["outcome"] == "wrong"
    assert judge(nothing, diagnosis(DRAG), diagnosis(DRAG))["outcome"] == "wrong"
    both = Case("file_mass", "s", "file", "reference", "mass", {"delta": 0.1})
    assert both.truth is None and deepcopy(both).effect == "mass"
    assert combined("rotor_loss", "loss", 0.1, 0.2) == pytest.approx(0.28)


def test_where_an_equal_is_named_the_untouched_flights_equation_error_says_the_size():
    motion, thrust = flight(3000)
    motion.time_s = 0.01 * np.arange(3000)
    motion.specific_B[:, 2] = 0.8 * thrust.sum(axis=1) / VEHICLE.mass
    recordings = SimpleNamespace(set=SimpleNamespace(new=("a",)), log=lambda entry: entry, motion=lambda entry: (motion, thrust), vehicle=VEHICLE, vehicle_file=FILE)
    case = Case("file_thrust_scale", "s", "file", "file", "thrust_scale", {"delta": -0.1})
    named = lambda effect, **parameters: {"effects": [{"effect": effect, "class": [effect, "thrust_scale"],
                                                       "parameters": {name: {"value": value} for name, value in parameters.items()}}]}
    assert sizes_before(named("battery_sag", exponent=2.5), case, recordings)["delta"] == pytest.approx(-0.2, abs=0.01)
    assert sizes_before(named("thrust_scale", delta=-0.3), case, recordings) == {"delta": -0.3}


def test_hovering_flights_differ_by_the_shares_of_their_rotors():
    thrusts = {"a": np.array([[1.0, 1.0, 1.0, 1.0]] * 3), "b": 2 * np.array([[1.04, 0.96, 1.0, 1.0]] * 3)}
    recordings = SimpleNamespace(set=SimpleNamespace(new=("a",), reference=("b",)), log=lambda entry: entry, motion=lambda entry: (None, thrusts[entry]))
    assert hover_difference(recordings) == pytest.approx(np.sqrt(2 * 0.04**2 / 4))


def test_the_summary_counts_twice_the_limit_and_nothing_concealed():
    row = lambda outcome, truth="mass", asked="file", times=2.0: {"outcome": outcome, "truth": truth, "asked": asked, "times": times}
    lines = summary([row("exact"), row("wrong"), row("exact", times=4.0), row("nothing", asked="reference"), row("exact", truth=None, times=0.0)]).splitlines()
    assert lines[3:] == ["| against the vehicle file | 2 | 1 (50 %) | 1 (50 %) | 0 | 0 | 0 | 0 | 0 |",
                         "| beside reference flights | 1 | 0 | 0 | 0 | 0 | 1 (100 %) | 0 | 0 |",
                         "| both | 3 | 1 (33 %) | 1 (33 %) | 0 | 0 | 1 (33 %) | 0 | 0 |",
                         "| nothing concealed | 1 | 1 (100 %) | 0 | 0 | 0 | 0 | 0 | 0 |"]
    lines = summary([{**row("exact"), "over_stated": 4.0}, {**row("nothing"), "over_stated": 0.0}, {**row("wrong"), "over_stated": 5.0}]).splitlines()
    assert lines[-2:] == ["| said to be not identifiable | 1 | 0 | 0 | 0 | 0 | 1 (100 %) | 0 | 0 |", "| 4 and more | 2 | 1 (50 %) | 1 (50 %) | 0 | 0 | 0 | 0 | 0 |"]
    lines = summary([{**row("exact"), "over_thirds": 2.0}, {**row("nothing"), "over_thirds": 0.6}]).splitlines()
    assert lines[-2:] == ["| below 1 | 1 | 0 | 0 | 0 | 0 | 1 (100 %) | 0 | 0 |", "| 2 | 1 | 1 (100 %) | 0 | 0 | 0 | 0 | 0 | 0 |"]


def test_flights_that_differ_within_themselves_tell_less_than_their_means():
    time_s = np.arange(0.0, 9.001, 0.01)
    body_rate = 0.3 * np.sin(2 * time_s)
    turn = Rotation.from_rotvec(np.c_[0 * time_s, 0 * time_s, -0.15 * np.cos(2 * time_s)]).as_quat()

    def flight(scales):
        scale = np.array(scales)[np.minimum((time_s / 3).astype(int), 2)]
        columns = {"time_s": time_s, "wx": 0 * time_s, "wy": 0 * time_s, "wz": scale * body_rate, **dict(zip(("qx", "qy", "qz", "qw"), turn.T))}
        return Log("f", {}, columns)

    def limits(*flights):
        recordings = SimpleNamespace(set=SimpleNamespace(new=flights, reference=(), holdout=()), log=flight, vehicle=None, has_rates=lambda: True)
        return limit_of(recordings, "gyro_scale", {"delta": 1.0}, "file"), limit_of_thirds(recordings, "gyro_scale", {"delta": 1.0}, "file")

    whole, thirds = limits((1.00, 1.03, 1.06), (1.06, 1.03, 1.00))
    spread = np.std([0.0, 0.03, 0.06] * 2, ddof=1)
    assert thirds == pytest.approx(5 * spread / np.sqrt(6), rel=0.15) and whole < 0.5 * thirds
    whole, thirds = limits((1.02,) * 3, (1.08,) * 3)
    assert thirds < whole == pytest.approx(5 * 0.06 / 2, rel=0.15)
