#!/usr/bin/env python3
"""Trials in which the simulator rotorpy, made by others, is the real vehicle: is what its vehicle file lacks named, and nothing else?

    rotorpy_trials.py draw --seed S --count N --out DIR        (in a Python environment that has rotorpy==3.0.0)
    rotorpy_trials.py check DIR                                each vehicle file against its logs, by the balance of forces and torques
    rotorpy_trials.py ask DIR --gustlab BIN [--jobs 1] [--limit N]

`draw` writes DIR/<trial>/{fit_1,fit_2,fit_3,holdout_1}.csv, sidecars and vehicle/, and the truth into DIR/truth.jsonl alone. Body, rotors,
aerodynamics, paths, autopilot and the noise of the IMU are rotorpy's; lever, delays and offsets of sensors, the loss of one rotor, rough
air and mocap noise are added here. `ask` diagnoses (a finished diagnosis is kept), writes DIR/results.jsonl and prints Markdown.

rotorpy's formulas and the catalogue's are the same, term by term: k_d = rotor_drag / (N Ω_h), k_z = axial_inflow / (N Ω_h),
k_h = translational_lift, k_flap = −flapping_torque, c_D = ½ ρ area, tau_m = both constants of motor_lag, rotor_directions = +1 for clockwise.
"""

import argparse
import concurrent.futures
import importlib
import importlib.util
import json
import math
import statistics
import sys
import tomllib
import xml.etree.ElementTree as xml
from collections import Counter
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from falsify import vehicle_text
from flight_files import HOME, Log, read_log, write_log
from outcomes import by_effect, by_value, counted, label, means, others, table, truth_names
from run_trials import run_measured

G, AIR_DENSITY = 9.81, 1.225
SAMPLE_S, SETTLE_S, FLIGHT_S = 0.005, 2.0, 20.0
PRECISION = {"method": "RK45", "rtol": 1e-6, "atol": 1e-9}
VEHICLES = ("crazyflie", "hummingbird", "crazyfliebrushless", "px4_sihsim_quadx")
ROLES = ("fit_1", "fit_2", "fit_3", "holdout_1")
# what vehicle.toml can hold, and the parameters of rotorpy that say it
HELD = {"rotor_drag": ("k_d",), "axial_inflow": ("k_z",), "translational_lift": ("k_h",), "flapping_torque": ("k_flap",),
        "quadratic_drag": ("c_Dx", "c_Dy"), "motor_lag": ("tau_m",)}
EFFECTS = (*HELD, "mass", "inertia", "center_of_mass", "thrust_scale", "rotor_loss", "yaw_torque_ratio", "actuation_delay", "steady_wind",
           "attitude_offset", "pose_delay", "gyro_scale", "imu_lever")
SIZES = (2.0, 6.0)                          # of single effects and pairs, in limits
# bounds beyond which the loop is lost or the effect is no longer moderate, small and large vehicles
MOST = {"actuation_delay": (0.015, 0.012), "attitude_offset": (0.05, 0.05), "steady_wind": (3.0, 6.0), "translational_lift": (2.5e-3, 2e-2)}
# pairs that one log cannot part, or parts badly
ALIKE = ({"mass", "thrust_scale"}, {"motor_lag", "actuation_delay"}, {"inertia", "yaw_torque_ratio"}, {"rotor_loss", "center_of_mass"},
         {"steady_wind", "attitude_offset"}, {"rotor_drag", "quadratic_drag"}, {"rotor_drag", "steady_wind"})


# ---- rotorpy's parameters, and the same in the catalogue's terms ----------------------------------------------------------

def shipped(name):
    """Parameters of a vehicle as rotorpy ships it."""
    params = deepcopy(importlib.import_module(f"rotorpy.vehicles.{name}_params").quad_params)
    if params["Izz"] > 0.99 * (params["Ixx"] + params["Iyy"]):
        # no body has such an inertia (the Crazyflie's): MuJoCo refuses it
        params["Izz"] = 0.9 * (params["Ixx"] + params["Iyy"])
    return params


def large(params):
    return params["mass"] > 0.2


def hover_speed(params):
    return math.sqrt(params["mass"] * G / (params["num_rotors"] * params["k_eta"]))


def hubs(params):
    return np.array([params["rotor_pos"][name] for name in params["rotor_pos"]], dtype=float)


def arm(params):
    return float(np.hypot(*hubs(params).T[:2]).mean())


def nominal(params, effect):
    """Catalogue's parameters of an effect in rotorpy's; None when it has none."""
    per_hover = params["num_rotors"] * hover_speed(params)
    number = lambda name: float(params.get(name, 0.0))
    if not any(number(name) for name in HELD[effect]):
        return None
    return {"rotor_drag": lambda: {"at_hover": number("k_d") * per_hover}, "axial_inflow": lambda: {"at_hover": number("k_z") * per_hover},
            "translational_lift": lambda: {"coefficient": number("k_h")}, "flapping_torque": lambda: {"coefficient": -number("k_flap")},
            "quadratic_drag": lambda: {"area_xy": 2 * number("c_Dx") / AIR_DENSITY, "area_z": 2 * number("c_Dz") / AIR_DENSITY},
            "motor_lag": lambda: {"time_constant": number("tau_m"), "time_constant_down": number("tau_m")}}[effect]()


def rotorpy_of(effect, values, params):
    """{rotorpy's parameter: number} that gives an effect of these sizes; hover is that of `params`."""
    per_hover = params["num_rotors"] * hover_speed(params)
    return {"rotor_drag": lambda: {"k_d": values["at_hover"] / per_hover}, "axial_inflow": lambda: {"k_z": values["at_hover"] / per_hover},
            "translational_lift": lambda: {"k_h": values["coefficient"]}, "flapping_torque": lambda: {"k_flap": -values["coefficient"]},
            "quadratic_drag": lambda: {**dict.fromkeys(("c_Dx", "c_Dy"), AIR_DENSITY * values["area_xy"] / 2), "c_Dz": AIR_DENSITY * values["area_z"] / 2},
            "motor_lag": lambda: {"tau_m": values["time_constant"]}}[effect]()


def vehicle_file(name, params):
    """(table of vehicle.toml, MJCF) of rotorpy's parameters."""
    sites = [f"rotor{i + 1}" for i in range(params["num_rotors"])]
    thrust = {"coefficient": params["k_eta"], "torque_ratio": params["k_m"] / params["k_eta"], "max_speed_radps": float(params["rotor_speed_max"])}
    if "rotor_radius" in params:
        thrust["radius_m"] = params["rotor_radius"]
    # rotorpy's direction is that of the torque: a clockwise rotor turns the body counter-clockwise
    table = {"format": "gustlab-vehicle/1", "name": f"rotorpy_{name}", "mjcf": "vehicle.xml",
             "rotor": [{"site": site, "direction": "cw" if s > 0 else "ccw"} for site, s in zip(sites, params["rotor_directions"])],
             "thrust": thrust,
             "effect": [{"type": effect, **values} for effect in HELD if (values := nominal(params, effect)) is not None]}
    text = lambda numbers: " ".join(repr(float(x)) for x in numbers)
    root = xml.Element("mujoco", model=f"rotorpy_{name}")
    xml.SubElement(root, "compiler", inertiafromgeom="false")
    body = xml.SubElement(xml.SubElement(root, "worldbody"), "body", name=f"rotorpy_{name}", pos="0 0 1")
    xml.SubElement(body, "freejoint")
    xml.SubElement(body, "inertial", pos="0 0 0", mass=repr(float(params["mass"])), diaginertia=text(params[f"I{axis}"] for axis in ("xx", "yy", "zz")))
    xml.SubElement(body, "geom", type="box", size=text(arm(params) * x for x in (0.5, 0.5, 0.2)), contype="0", conaffinity="0", group="1")
    for site, hub in zip(sites, hubs(params)):
        xml.SubElement(body, "site", name=site, pos=text(hub))
    xml.indent(root)
    return table, xml.tostring(root, encoding="unicode") + "\n"


# ---- what is concealed ----------------------------------------------------------------------------------------------------

@dataclass
class Reality:
    """A vehicle as its file says (`file`), and as it is: rotorpy's parameters (`real`) and what rotorpy has no parameter for."""
    file: dict
    real: dict
    center_B_m: np.ndarray = field(default_factory=lambda: np.zeros(3))    # of mass, from the logged point
    rotor_loss: tuple = (0, 0.0)                                           # index of the rotor, share
    delay_s: float = 0.0
    wind_W_mps: np.ndarray = field(default_factory=lambda: np.zeros(3))
    attitude_rad: np.ndarray = field(default_factory=lambda: np.zeros(3))
    pose_delay_s: float = 0.0
    gyro: float = 0.0
    lever_B_m: np.ndarray = field(default_factory=lambda: np.zeros(3))


def limit(effect, params):
    """Size of the leading parameter that is just worth reporting: the tolerance; for forces of the air 1.2 % of the weight, and for
    flapping the torque of 1.2 % of a rotor, at the speed of these flights."""
    speed, climb = (2.0, 0.7) if large(params) else (1.2, 0.4)
    weight, rotors = params["mass"] * G, params["num_rotors"]
    force = 0.012 * weight
    if effect == "steady_wind":
        drag = params.get("k_d", 0.0) * rotors * hover_speed(params) + 2 * speed * params.get("c_Dx", 0.0)
        return force / drag
    return {"rotor_drag": force / speed, "quadratic_drag": 2 * force / (AIR_DENSITY * speed**2), "axial_inflow": force / climb,
            "translational_lift": force / (rotors * speed**2), "flapping_torque": force / rotors * arm(params) / (rotors * hover_speed(params) * speed),
            "mass": 0.012, "thrust_scale": 0.012, "center_of_mass": 0.003 * arm(params), "rotor_loss": 0.01, "inertia": 0.05,
            "yaw_torque_ratio": 0.05, "motor_lag": 0.004, "actuation_delay": 0.003, "pose_delay": 0.003, "gyro_scale": 0.01,
            "attitude_offset": 0.01, "imu_lever": 0.005}[effect]


def leading(effect):
    return {"rotor_drag": "at_hover", "axial_inflow": "at_hover", "quadratic_drag": "area_xy", "translational_lift": "coefficient",
            "flapping_torque": "coefficient", "motor_lag": "time_constant"}[effect]


def draw_effect(effect, params, rng):
    """What one trial conceals: catalogue's totals, what of them the file has, and the size in limits."""
    size = float(rng.uniform(*SIZES)) * (unit := limit(effect, params))
    if effect in MOST:
        size = min(size, MOST[effect][large(params)])
    sign, rotor, angle = float(rng.choice([-1.0, 1.0])), int(rng.integers(params["num_rotors"])), float(rng.uniform(0, 2 * math.pi))
    flat = {"x": size * math.cos(angle), "y": size * math.sin(angle)}
    found = {"effect": effect, "rotor": None, "file": {}}
    if effect in HELD:
        own = nominal(params, effect)
        # the file lacks the effect where rotorpy's own is moderate; else the vehicle has more of it than the file
        absent = own is not None and effect != "motor_lag" and SIZES[0] <= own[leading(effect)] / unit <= 1.5 * SIZES[1] and rng.random() < 0.6
        if absent:
            parameters, size = dict(own), own[leading(effect)]
        else:
            found["file"] = own or {}
            parameters = {**{"quadratic_drag": {"area_xy": 0.0, "area_z": 0.0}, "motor_lag": {}}.get(effect, {}), **found["file"]}
            parameters[leading(effect)] = parameters.get(leading(effect), 0.0) + size
            if effect == "motor_lag":
                parameters["time_constant_down"] = parameters["time_constant"]
    else:
        parameters = {"mass": lambda: {"delta": sign * size}, "thrust_scale": lambda: {"delta": sign * size},
                      "yaw_torque_ratio": lambda: {"delta": sign * size}, "gyro_scale": lambda: {"delta": sign * size},
                      "inertia": lambda: dict.fromkeys(("delta_x", "delta_y", "delta_z"), sign * size), "center_of_mass": lambda: {**flat, "z": 0.0},
                      "rotor_loss": lambda: {"rotor": rotor + 1, "loss": size}, "actuation_delay": lambda: {"delay": size},
                      "steady_wind": lambda: {**flat, "z": 0.0}, "attitude_offset": lambda: flat, "pose_delay": lambda: {"delay": size},
                      "imu_lever": lambda: {**flat, "z": 0.0}}[effect]()
        found["rotor"] = rotor + 1 if effect == "rotor_loss" else None
    return {**found, "parameters": parameters, "limits": size / unit}


def conceal(reality, effect, values, in_file):
    """Puts an effect of these total sizes into the real vehicle, and what `in_file` says of it into the file."""
    real, file, vector = reality.real, reality.file, np.array([values.get(axis, 0.0) for axis in "xyz"])
    if effect in HELD:
        real.update(rotorpy_of(effect, values, file))
        if not in_file:
            file.update(dict.fromkeys((*HELD[effect], *(["c_Dz"] if effect == "quadratic_drag" else [])), 0.0))
    elif effect == "mass":
        real["mass"] *= 1 + values["delta"]
    elif effect == "inertia":
        for axis in "xyz":
            real[f"I{axis}{axis}"] *= 1 + values[f"delta_{axis}"]
    elif effect == "center_of_mass":
        reality.center_B_m = vector
        real["rotor_pos"] = {name: hub - vector for name, hub in real["rotor_pos"].items()}
    elif effect == "thrust_scale":
        real["k_eta"] *= 1 + values["delta"]
        real["k_m"] *= 1 + values["delta"]
    elif effect == "rotor_loss":
        reality.rotor_loss = (values["rotor"] - 1, values["loss"])
    elif effect == "yaw_torque_ratio":
        real["k_m"] *= 1 + values["delta"]
    elif effect == "actuation_delay":
        reality.delay_s = values["delay"]
    elif effect == "steady_wind":
        reality.wind_W_mps = vector
    elif effect == "attitude_offset":
        reality.attitude_rad = vector
    elif effect == "pose_delay":
        reality.pose_delay_s = values["delay"]
    elif effect == "gyro_scale":
        reality.gyro = values["delta"]
    elif effect == "imu_lever":
        reality.lever_B_m = vector
    else:
        raise ValueError(effect)


# ---- flights ----------------------------------------------------------------------------------------------------------------

@dataclass
class Setting:
    """How one trial is flown and recorded: sensors' noise (sigma a sample) and air."""
    pose_every: int = 1                   # samples
    rotors: bool = False                  # measured speeds are logged
    position_m: float = 4e-4
    velocity_mps: float = 6e-3
    attitude_rad: float = 2e-3
    gyro_radps: float = 0.01
    accel_mps2: float = 0.08
    rotor_share: float = 2e-3
    bias: float = 1.0
    air_mps2: float = 0.0                 # force per mass, rms an axis
    air_radps2: float = 0.0               # torque per inertia


def draw_setting(params, air, rng):
    noisy = rng.choice([1.0, 2.0])
    rough = float(rng.uniform(1.0, 2.0)) if air == "mild" else 0.0
    return Setting(int(rng.choice([1, 2])), bool(rng.random() < 0.4), 4e-4 * noisy, 6e-3 * noisy, 2e-3 * noisy, (0.008 if large(params) else 0.015) * noisy,
                   0.08 * noisy, 2e-3, 1.0, 0.07 * rough, (0.12 if large(params) else 0.8) * rough)


class Swing:
    """A yaw for rotorpy's paths: a swing on a slow turn."""

    def __init__(self, rng):
        self.size, self.rate, self.turn = rng.uniform(0.3, 0.7), rng.uniform(1.2, 2.2), rng.uniform(-0.4, 0.4)

    def update(self, t, _velocity=None):
        phase = self.rate * t
        return {"yaw": self.size * math.sin(phase) + self.turn * t, "yaw_dot": self.size * self.rate * math.cos(phase) + self.turn,
                "yaw_ddot": -self.size * self.rate**2 * math.sin(phase)}


class Shaken:
    """A path with small oscillations of 0.5 to 3 Hz in the accelerations that are asked for: an identification flight."""

    def __init__(self, path, rng):
        self.path, self.radps, self.phase = path, 2 * math.pi * rng.uniform(0.5, 3.0, (4, 3)), rng.uniform(0, 2 * math.pi, (4, 3))

    def update(self, t):
        flat = self.path.update(t)
        flat["x_ddot"] = flat["x_ddot"] + 0.35 * np.sin(self.radps * t + self.phase).sum(axis=0)
        return flat


def path_of(kind, params, rng):
    """One of rotorpy's paths, of the vehicle's size."""
    from rotorpy.trajectories.circular_traj import ThreeDCircularTraj
    from rotorpy.trajectories.hover_traj import HoverTraj
    from rotorpy.trajectories.lissajous_traj import TwoDLissajous
    from rotorpy.trajectories.minsnap import MinSnap
    scale, quick = (2.0, 0.75) if large(params) else (1.0, 1.0)
    height = 1.5 * scale
    if kind == "circle":
        radius, turns = scale * rng.uniform(0.8, 1.3), quick * rng.uniform(0.2, 0.3)
        return ThreeDCircularTraj(np.array([0, 0, height]), np.array([radius, radius, scale * rng.uniform(0.2, 0.4)]),
                                  np.array([turns, turns, quick * rng.uniform(0.25, 0.4)]), yaw_traj=Swing(rng))
    if kind == "lissajous":
        rate = quick * rng.uniform(1.0, 1.4)
        return TwoDLissajous(scale * rng.uniform(1.0, 1.6), scale * rng.uniform(0.5, 0.8), rate, rate * float(rng.choice([1.5, 2.0])),
                             float(rng.uniform(0, math.pi)), height=height, yaw_traj=Swing(rng))
    if kind == "waypoints":
        speed, length, points = (1.5 if large(params) else 1.1), 0.0, [np.array([0, 0, height])]
        while length < speed * (FLIGHT_S + SETTLE_S + 1):
            point = scale * np.array([*rng.uniform(-1.4, 1.4, 2), rng.uniform(1.0, 2.1)])
            if (distance := np.linalg.norm(point - points[-1])) > 0.9 * scale:
                points.append(point)
                length += distance
        yaw = np.cumsum(rng.uniform(-0.6, 0.6, len(points)))
        return Shaken(MinSnap(np.array(points), yaw - yaw[0], v_max=6, v_avg=speed, verbose=False), rng)
    return Shaken(HoverTraj(np.array([0, 0, height]), yaw_traj=Swing(rng)), rng)


def multirotor(reality):
    """rotorpy's vehicle, with a rotor that can be weak and with air that can push."""
    from rotorpy.vehicles.multirotor import Multirotor

    class Vehicle(Multirotor):
        push_B_N, twist_B_Nm = np.zeros(3), np.zeros(3)

        def compute_body_wrench(self, body_rates, rotor_speeds, body_airspeed_vector):
            force, torque = super().compute_body_wrench(body_rates, rotor_speeds, body_airspeed_vector)
            rotor, share = reality.rotor_loss
            if share:
                less = share * rotor_speeds[rotor]**2
                weaker = np.array([0.0, 0.0, -less * self.k_eta])
                force = force + weaker
                torque = torque + np.cross(self.rotor_geometry[rotor], weaker) - np.array([0, 0, self.rotor_dir[rotor] * less * self.k_m])
            return force + self.push_B_N, torque + self.twist_B_Nm

    return Vehicle


class Pilot:
    """rotorpy's SE3 controller of the vehicle as shipped, with gains for these rates and a lead that answers slow motors."""

    def __init__(self, params):
        from rotorpy.controllers.quadrotor_control import SE3Control
        self.se3, self.params, self.slow = SE3Control(params), params, None
        self.lead = params["tau_m"] > 0.02
        # yaw has little torque: it is asked for less
        of_yaw = np.array([1.0, 1.0, 0.4])
        self.se3.kp_att, self.se3.kd_att = (150.0 * of_yaw, 30.0 * of_yaw) if self.lead else (self.se3.kp_att * of_yaw, self.se3.kd_att * of_yaw)
        if self.lead:
            self.se3.kp_pos, self.se3.kd_pos = np.array([4.0, 4.0, 10.0]), np.array([3.0, 3.0, 6.0])

    def command(self, t, measured, flat):
        wanted = self.se3.update(t, measured, flat)["cmd_motor_speeds"]
        if self.lead:
            self.slow = wanted if self.slow is None else self.slow
            rate = (wanted - self.slow) / 0.03
            self.slow = self.slow + SAMPLE_S * rate
            wanted = self.slow + self.params["tau_m"] * rate
        return np.clip(wanted, self.params["rotor_speed_min"], self.params["rotor_speed_max"])


def imu_of(setting, rng):
    from rotorpy.sensors.imu import Imu
    density = lambda sigma: np.full(3, sigma / math.sqrt(0.5 / SAMPLE_S))
    kind = lambda sigma, bias: {"initial_bias": setting.bias * bias * rng.standard_normal(3), "noise_density": density(sigma), "random_walk": np.zeros(3)}
    return Imu(kind(setting.accel_mps2, 0.03), kind(setting.gyro_radps, 0.005), sampling_rate=1 / SAMPLE_S)


def fly(reality, shipped_params, kind, setting, rng, precision=PRECISION, parts=1):
    """One flight as the motions it had: arrays of 200 Hz samples, or None when the vehicle was lost."""
    np.random.seed(int(rng.integers(2**31)))          # rotorpy's sensors draw from numpy's global stream
    path, pilot, imu = path_of(kind, shipped_params, rng), Pilot(shipped_params), imu_of(setting, rng)
    vehicle = multirotor(reality)(reality.real, integrator_kwargs=precision)
    from rotorpy.wind.default_winds import ConstantWind
    wind = ConstantWind(*reality.wind_W_mps)
    start, center = path.update(0.0), reality.center_B_m
    hover = hover_speed(shipped_params)
    state = {"x": np.array(start["x"], float) + center, "v": np.array(start["x_dot"], float), "q": np.array([0.0, 0, 0, 1]), "w": np.zeros(3),
             "wind": wind.update(0.0, None), "rotor_speeds": np.full(vehicle.num_rotors, hover)}
    push_W, twist_B, keep_push, keep_twist = np.zeros(3), np.zeros(3), math.exp(-SAMPLE_S / 0.15), math.exp(-SAMPLE_S / 0.07)
    inertia = np.diag(vehicle.inertia)
    late, over = divmod(reality.delay_s, SAMPLE_S)
    past, rows = [np.full(vehicle.num_rotors, hover)] * (int(late) + 2), []
    for k in range(round((SETTLE_S + FLIGHT_S) / SAMPLE_S) + 1):
        t = k * SAMPLE_S
        turn = Rotation.from_quat(state["q"])
        push_W = keep_push * push_W + setting.air_mps2 * math.sqrt(1 - keep_push**2) * rng.standard_normal(3)
        twist_B = keep_twist * twist_B + setting.air_radps2 * math.sqrt(1 - keep_twist**2) * rng.standard_normal(3) * [1, 1, 0.3]
        vehicle.push_B_N, vehicle.twist_B_Nm = reality.real["mass"] * turn.inv().apply(push_W), inertia * twist_B
        measured = {"x": state["x"] - turn.apply(center) + setting.position_m * rng.standard_normal(3),
                    "v": state["v"] - turn.apply(np.cross(state["w"], center)) + setting.velocity_mps * rng.standard_normal(3),
                    "q": (turn * Rotation.from_rotvec(setting.attitude_rad * rng.standard_normal(3))).as_quat(),
                    "w": state["w"] + setting.gyro_radps * rng.standard_normal(3)}
        flat = path.update(t)
        command = pilot.command(t, measured, flat)
        past.append(command)
        change = vehicle.statedot(state, {"cmd_motor_speeds": command}, SAMPLE_S)
        reading = imu.measurement(state, change)
        rows.append([t, *state["x"], *state["v"], *state["q"], *state["w"], *change["wdot"], *reading["accel"], *reading["gyro"], *command, *state["rotor_speeds"]])
        if not np.all(np.isfinite(rows[-1])) or np.linalg.norm(state["x"] - flat["x"]) > 2.5 or turn.as_matrix()[2, 2] < 0.3:
            return None
        # a command acts `delay` after it was given: within this interval first one, then the next
        for length, given in ((over, past[-2 - int(late)]), (SAMPLE_S - over, past[-1 - int(late)])):
            for _ in range(parts if length > 1e-9 else 0):
                state = vehicle.step(state, {"cmd_motor_speeds": given}, length / parts)
    n = vehicle.num_rotors
    cuts = np.cumsum([1, 3, 3, 4, 3, 3, 3, 3, n])
    names = ("time_s", "x", "v", "q", "w", "turn", "accel", "gyro", "u", "rotor")
    return dict(zip(names, np.split(np.array(rows), cuts, axis=1)))


def recorded(flight, reality, setting, rng):
    """The log of a flight, as sensors with the concealed faults record it."""
    time_s, w = flight["time_s"][:, 0], flight["w"]
    first = round(SETTLE_S / SAMPLE_S)
    q = flight["q"] * np.cumprod(np.r_[1.0, np.where(np.sum(flight["q"][1:] * flight["q"][:-1], axis=1) < 0, -1.0, 1.0)])[:, None]
    turn, center = Rotation.from_quat(q), reality.center_B_m
    x, v = flight["x"] - turn.apply(center), flight["v"] - turn.apply(np.cross(w, center))
    if reality.pose_delay_s:
        old = np.maximum(time_s - reality.pose_delay_s, 0.0)
        x, v, q = (CubicSpline(time_s, values)(old) for values in (x, v, q))
        turn = Rotation.from_quat(q)
    noise = lambda sigma: sigma * rng.standard_normal((len(time_s), 3))
    logged = turn * Rotation.from_rotvec(reality.attitude_rad) * Rotation.from_rotvec(noise(setting.attitude_rad))
    q = logged.as_quat()
    q *= np.cumprod(np.r_[1.0, np.where(np.sum(q[1:] * q[:-1], axis=1) < 0, -1.0, 1.0)])[:, None]
    lever = reality.lever_B_m - center
    accel = flight["accel"] + np.cross(flight["turn"], lever) + np.cross(w, np.cross(w, lever))
    # the scale is one of what turns, not of noise and bias
    gyro = flight["gyro"] + reality.gyro * w
    pose = np.column_stack([x + noise(setting.position_m), v + noise(setting.velocity_mps), q[:, [3, 0, 1, 2]]])
    pose[np.arange(len(pose)) % setting.pose_every != 0] = np.nan
    column = {"time_s": time_s[first:] - time_s[first]}
    add = lambda names, values: column.update(zip(names, values[first:].T))
    add(("px", "py", "pz", "vx", "vy", "vz", "qw", "qx", "qy", "qz"), pose)
    add(("wx", "wy", "wz"), gyro)
    add(("ax", "ay", "az"), accel)
    count = flight["u"].shape[1]
    add([f"u{i + 1}" for i in range(count)], flight["u"])
    if setting.rotors:
        add([f"rotor{i + 1}" for i in range(count)], flight["rotor"] * (1 + setting.rotor_share * rng.standard_normal(flight["rotor"].shape)))
    meta = {"format": "gustlab-flight/1", "actuator": "rotor_speed", "source": "recording", "hold": "zoh", "notes": ""}
    return Log("", meta, column)


# ---- trials -----------------------------------------------------------------------------------------------------------------

def plan(seed, count):
    """[(kind, vehicle, effects, air)], mixed evenly, so that any first part is a sample: 62 % one effect, 18 % two, 20 % nothing."""
    rng = np.random.default_rng([seed, 1])
    pairs, nothing = round(0.18 * count), round(0.2 * count)
    counts = {"single": count - pairs - nothing, "pair": pairs, "nothing": nothing}
    # every effect as often as any other, and every vehicle with every kind
    effects = [effect for _ in range(counts["single"] // len(EFFECTS) + 1) for effect in rng.permutation(EFFECTS)]
    both = [pair for _ in range(pairs) for pair in [next(p for p in iter(lambda: tuple(map(str, rng.choice(EFFECTS, 2, replace=False))), None)
                                                        if not any(set(p) == alike for alike in ALIKE))]]
    chosen = {"single": [(str(effect),) for effect in effects], "pair": both, "nothing": [()] * nothing}
    order = sorted(((n + 0.5) / number, kind, n) for kind, number in counts.items() for n in range(number))
    first = {kind: int(rng.integers(len(VEHICLES))) for kind in counts}
    return [(kind, VEHICLES[(first[kind] + n) % len(VEHICLES)], chosen[kind][n], ("calm", "mild")[(n + n // len(VEHICLES)) % 2]) for _, kind, n in order]


def draw_trial(folder, name, vehicle, effects, air, rng, setting=None, precision=PRECISION):
    """Writes one trial and returns its truth. Flights in which the vehicle is lost are flown again, with smaller sizes after three."""
    params = shipped(vehicle)
    for attempt in range(12):
        rest = setting or draw_setting(params, air, rng)
        reality, truth = Reality(deepcopy(params), deepcopy(params)), []
        # what the file can hold comes first: hover is that of the file
        for effect in sorted(effects, key=lambda e: e not in HELD):
            hidden = draw_effect(effect, params, rng)
            conceal(reality, effect, hidden["parameters"], hidden["file"])
            truth.append(hidden)
        kinds = list(rng.permutation(["circle", "lissajous", "waypoints"]))
        kinds = [*kinds[:2], "hover", kinds[2]]
        logs = []
        for kind in kinds:
            if (flight := fly(reality, params, kind, rest, rng, precision)) is None:
                break
            logs.append(recorded(flight, reality, rest, rng))
        if len(logs) == len(kinds):
            break
        print(f"{name}: {vehicle} with {', '.join(effects) or 'nothing'} was lost on {kind}; drawn again", file=sys.stderr, flush=True)
    else:
        raise RuntimeError(f"{name}: the vehicle was lost twelve times")
    table, mjcf = vehicle_file(vehicle, reality.file)
    (folder / name / "vehicle").mkdir(parents=True, exist_ok=True)
    (folder / name / "vehicle" / "vehicle.toml").write_text(vehicle_text(table), encoding="utf-8")
    (folder / name / "vehicle" / "vehicle.xml").write_text(mjcf, encoding="utf-8")
    for role, log in zip(ROLES, logs):
        write_log(folder / name / f"{role}.csv", log, "vehicle/vehicle.toml")
    return {"trial": name, "vehicle": vehicle, "air": air, "effects": truth, "paths": dict(zip(ROLES, map(str, kinds))), "setting": vars(rest)}


def draw_planned(number, planned, seed, out):
    kind, vehicle, effects, air = planned
    truth = draw_trial(out, f"trial_{number + 1:03}", vehicle, effects, air, np.random.default_rng([seed, 2, number]))
    return {**truth, "kind": kind, "seed": seed}


def draw(seed, count, out, limit_to=None, jobs=1):
    out.mkdir(parents=True, exist_ok=True)
    planned, lines = plan(seed, count)[:limit_to], []
    with concurrent.futures.ProcessPoolExecutor(jobs) as pool:
        for truth in pool.map(draw_planned, range(len(planned)), planned, [seed] * len(planned), [out] * len(planned)):
            lines.append(json.dumps(truth))
            # what an interrupted draw leaves is a set of its own
            (out / "truth.jsonl").write_text("\n".join(lines) + "\n", encoding="utf-8")
            print(f"[{len(lines)}/{len(planned)}] {truth['kind']} {truth['vehicle']} {truth['air']}", file=sys.stderr, flush=True)


# ---- each file against its logs, without rotorpy and without gustlab --------------------------------------------------------------

def speeds_of(log, lag_s):
    """Rotor speeds at each sample: the commands, held, through the file's lag."""
    u, time_s = log.stack("u1", "u2", "u3", "u4"), log.column["time_s"]
    speed = u.copy()
    for k in range(1, len(u)):
        left = math.exp(-(time_s[k] - time_s[k - 1]) / lag_s) if lag_s > 0 else 0.0
        speed[k] = u[k - 1] + (speed[k - 1] - u[k - 1]) * left
    return speed


def balance(vehicle, log):
    """(specific force, angular acceleration) of each sample that the vehicle file gives; velocity and rate as logged."""
    table = tomllib.loads((vehicle / "vehicle.toml").read_text(encoding="utf-8"))
    root = xml.parse(vehicle / table["mjcf"]).getroot()
    inertial = root.find(".//inertial")
    numbers = lambda text: np.array([float(x) for x in text.split()])
    mass, inertia = float(inertial.get("mass")), numbers(inertial.get("diaginertia"))
    site = {s.get("name"): numbers(s.get("pos")) for s in root.iter("site")}
    effect = {e["type"]: e for e in table.get("effect", [])}
    number = lambda name, key: effect.get(name, {}).get(key, 0.0)
    k_f, ratio = table["thrust"]["coefficient"], table["thrust"]["torque_ratio"]
    time_s = log.column["time_s"]
    rows = np.isfinite(log.column["px"])
    at = lambda *names: np.column_stack([np.interp(time_s, time_s[rows], log.column[name][rows]) for name in names])
    turn = Rotation.from_quat(at("qx", "qy", "qz", "qw"))
    v, w = turn.inv().apply(at("vx", "vy", "vz")), log.stack("wx", "wy", "wz")
    speed = log.stack("rotor1", "rotor2", "rotor3", "rotor4")
    speed = speeds_of(log, number("motor_lag", "time_constant")) if speed is None else speed
    per_hover = len(table["rotor"]) * math.sqrt(mass * G / (len(table["rotor"]) * k_f))
    area = np.array([number("quadratic_drag", "area_xy")] * 2 + [number("quadratic_drag", "area_z")])
    force, torque = -0.5 * AIR_DENSITY * np.linalg.norm(v, axis=1)[:, None] * area * v, np.zeros_like(v)
    for i, rotor in enumerate(table["rotor"]):
        hub, omega, s = site[rotor["site"]], speed[:, i], 1 if rotor["direction"] == "ccw" else -1
        local = v + np.cross(w, hub)
        thrust = k_f * omega**2 - number("axial_inflow", "at_hover") / per_hover * omega * local[:, 2] \
            + number("translational_lift", "coefficient") * (local[:, 0]**2 + local[:, 1]**2)
        hub_force = -number("rotor_drag", "at_hover") / per_hover * omega[:, None] * local * [1, 1, 0]
        hub_force[:, 2] = thrust
        force += hub_force
        torque += np.cross(hub, hub_force) + number("flapping_torque", "coefficient") * omega[:, None] * np.cross(local, [0, 0, 1])
        torque[:, 2] -= s * ratio * k_f * omega**2
    return force / mass, (torque - np.cross(w, inertia * w)) / inertia


def residual(vehicle, log, span_s=0.1):
    """Mean and rms of what the file leaves: specific force (m/s²), and change of body rate over `span_s` (rad/s)."""
    force, turn = balance(vehicle, log)
    step = round(span_s / SAMPLE_S)
    rate = log.stack("wx", "wy", "wz")
    whole = np.vstack([np.zeros(3), np.cumsum(0.5 * (turn[1:] + turn[:-1]), axis=0) * SAMPLE_S])
    left = {"force": (log.stack("ax", "ay", "az") - force)[200:], "rate": (rate[step:] - rate[:-step] - whole[step:] + whole[:-step])[200:]}
    return {name: (values.mean(axis=0), np.sqrt((values**2).mean(axis=0))) for name, values in left.items()}


def check(folder):
    """Markdown: what the vehicle file leaves of each trial, all flights together."""
    lines = ["| trial | vehicle | concealed | air | noise m/s² | force left: mean x y z; rms x y z m/s² | rate left in 0.1 s: rms x y z rad/s |", "|" + " --- |" * 7]
    for line in (folder / "truth.jsonl").read_text(encoding="utf-8").splitlines():
        truth = json.loads(line)
        left = [residual(folder / truth["trial"] / "vehicle", read_log(folder / truth["trial"] / f"{role}.csv")) for role in ROLES]
        text = lambda name, k, how: " ".join(f"{x:.3f}" for x in how([flight[name][k] for flight in left]))
        mean, rms = lambda rows: np.mean(rows, axis=0), lambda rows: np.sqrt(np.mean(np.square(rows), axis=0))
        lines.append(f"| {truth['trial']} | {truth['vehicle']} | {', '.join(e['effect'] for e in truth['effects']) or '–'} | {truth['air']} | "
                     f"{truth['setting']['accel_mps2']:.2f} | {text('force', 0, mean)}; {text('force', 1, rms)} | {text('rate', 1, rms)} |")
    return "\n".join(lines) + "\n"


# ---- asking and scoring ---------------------------------------------------------------------------------------------------------

def size_error(finding, truth):
    """|found − true| over |true − file|, over all parameters; None when named as another of its class."""
    if finding["effect"] != truth["effect"]:
        return None
    wrong = change = 0.0
    for name, value in truth["parameters"].items():
        if name != "rotor":
            before = truth["file"].get(name, 0.0)
            wrong += (finding["parameters"].get(name, {"value": before})["value"] - value)**2
            change += (value - before)**2
    return math.sqrt(wrong / change)


def judge(truth, found):
    """One row. outcome: exact (all named, and nothing else) | wrong (a name that is not true) | partial (some of them) | withheld (none named,
    one suspected) | nothing | failed (no diagnosis)."""
    hidden = truth["effects"]
    row = {key: truth[key] for key in ("trial", "kind", "vehicle", "air")} | {"truth": truth_names(hidden), "limits": [e["limits"] for e in hidden]}
    right = lambda finding: any(means(finding, e["effect"], e["rotor"]) for e in hidden)
    row |= counted(found, [(e["effect"], e["rotor"]) for e in hidden], right, label, "partial", "nothing")
    if found is not None:
        row["size_error"] = [error for e in hidden for finding in found["effects"] if means(finding, e["effect"], e["rotor"])
                             if (error := size_error(finding, e)) is not None]
    return row


OUTCOMES = ("exact", "wrong", "withheld", "nothing", "partial", "failed")


def markdown(rows):
    """Counts by effect, vehicle and air, and every trial that is not exact."""
    def error(chosen):
        errors = [error for row in chosen for error in row.get("size_error", [])]
        return f"{100 * statistics.median(errors):.0f} %" if errors else None

    of = lambda kind: [row for row in rows if row["kind"] == kind]
    groups = {"concealed": [*by_effect(of("single")), ("one effect", of("single")), ("two effects", of("pair")), ("nothing", of("nothing")), ("all", rows)],
              "vehicle": by_value(rows, "vehicle"), "air": by_value(rows, "air")}
    lines = [line for title, chosen in groups.items() for line in table(title, chosen, OUTCOMES, "size error, median", error)]
    verdicts = Counter(row.get("verdict", "none") for row in of("nothing"))
    lines += ["Verdicts where nothing is concealed: " + (", ".join(f"{name} {n}" for name, n in sorted(verdicts.items())) or "–") + ".", ""]
    lines += others(rows, ("vehicle", "air"), ("named", "wrong", "suspected"), lambda name, row, k: f"{name} ({row['limits'][k]:.1f} limits)")
    return "\n".join(lines) + "\n"


def ask(folder, gustlab, jobs, limit_to, seconds):
    """Rows of the first trials; a diagnosis that is there is kept."""
    truths = [json.loads(line) for line in (folder / "truth.jsonl").read_text(encoding="utf-8").splitlines()][:limit_to]

    def row(truth):
        place = folder / truth["trial"]
        path = place / "diagnosis" / "diagnosis.json"
        if not path.exists():
            command = ["nice", "-n", "5", "timeout", str(seconds), gustlab, "diagnose", *(str(place / f"{role}.csv") for role in ROLES[:3]),
                       "--holdout", str(place / f"{ROLES[3]}.csv"), "--out", str(place / "diagnosis"), "--jobs", "1"]
            (place / "run.json").write_text(json.dumps(run_measured(command, place / "messages.txt")) + "\n", encoding="utf-8")
        return judge(truth, json.loads(path.read_text(encoding="utf-8")) if path.exists() else None)

    rows = []
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for done in pool.map(row, truths):
            rows.append(done)
            print(f"[{len(rows)}/{len(truths)}] {done['trial']} {', '.join(done['truth']) or 'nothing'}: {done['outcome']}", file=sys.stderr, flush=True)
    (folder / "results.jsonl").write_text("".join(json.dumps(done) + "\n" for done in rows), encoding="utf-8")
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    drawing = commands.add_parser("draw", help="write trials (needs rotorpy)")
    drawing.add_argument("--seed", type=int, required=True)
    drawing.add_argument("--count", type=int, required=True)
    drawing.add_argument("--limit", type=int, help="only the first of them")
    drawing.add_argument("--out", type=Path, required=True)
    drawing.add_argument("--jobs", type=int, default=1)
    checking = commands.add_parser("check", help="each vehicle file against its logs")
    checking.add_argument("folder", type=Path)
    asking = commands.add_parser("ask", help="diagnose and score")
    asking.add_argument("folder", type=Path)
    asking.add_argument("--gustlab", default=str(HOME / "build/release/gustlab"))
    asking.add_argument("--jobs", type=int, default=1)
    asking.add_argument("--limit", type=int, help="only the first trials; they are mixed evenly")
    asking.add_argument("--seconds", type=int, default=900, help="a diagnosis that takes longer has failed")
    options = parser.parse_args()
    if options.command == "draw":
        if importlib.util.find_spec("rotorpy") is None:
            parser.error("no rotorpy in this Python environment: pip install rotorpy==3.0.0, in an environment of its own")
        draw(options.seed, options.count, options.out, options.limit, options.jobs)
    elif options.command == "check":
        sys.stdout.write(check(options.folder))
    else:
        sys.stdout.write(markdown(ask(options.folder, options.gustlab, options.jobs, options.limit, options.seconds)))


if __name__ == "__main__":
    main()
