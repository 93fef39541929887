#!/usr/bin/env python3
"""Trials from a simulator of its own, written from the formats and the catalogue alone: is what the vehicle file lacks named, and nothing else?

    foreign_trials.py --seed S --count N --out DIR [--first K] [--style NAME] [--air NAME] [--gustlab BIN] [--jobs 1] [--draw-only]

Writes DIR/<trial>/{fit_1,fit_2,fit_3,holdout_1}.csv, sidecars and vehicle/, the truth into DIR/truth.jsonl alone, diagnoses (a finished diagnosis is
kept), writes DIR/results.jsonl and prints Markdown. A trial depends on the seed, its number, and the style and the air that are asked for. No code of src/ is used or known here.

Physics: rigid body with lumped rotor aerodynamics (Mahony, Kumar and Corke 2012; Svacha, Mohta and Kumar 2017; Faessler, Franchi and Scaramuzza 2018),
ground effect of a whole multirotor (Sanchez-Cuevas, Heredia and Ollero 2017), gusts with the spectra of Dryden (MIL-F-8785C), rotors of first order.
Loops: cascaded PID, incremental inversion of the rate dynamics (Smeur, Chu and de Croon 2016), geometric on SO(3) (Lee, Leok and McClamroch 2010).
"""

import argparse
import concurrent.futures
import json
import math
import sys
import xml.etree.ElementTree as xml
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy import signal
from scipy.spatial.transform import Rotation

from falsify import vehicle_text
from flight_files import HOME, Log, write_log
from outcomes import by_effect, by_value, counted, label, means, others, table, truth_names
from run_trials import run_measured

G, AIR_DENSITY, STEP_S = 9.81, 1.225, 0.001
SETTLE = 3000                              # steps before the log begins
ROLES = ("fit_1", "fit_2", "fit_3", "holdout_1")
STYLES = ("imu", "mocap", "estimator", "default", "filtered", "collective")
AIRS = {"calm": (0.01, 0.03), "light": (0.1, 0.2), "rough": (0.35, 0.7)}     # m/s rms of a component of the gust
LOOPS = ("pid", "incremental", "geometric")
OUTSIDE = ("slosh", "rubber_band", "updraft", "sticking_rotor", "imbalance", "tether")
# names that are a fair description of something outside of the catalogue: a sloshing mass is a pendulum, a payload on rubber hangs
FAIR = {"slosh": ("slung_load",), "rubber_band": ("slung_load", "mass")}
# what a total force alone can show, and what a sensor or a fast sample is needed for
OF_FORCE = ("mass", "thrust_scale", "thrust_curve", "battery_sag", "rotor_drag", "quadratic_drag", "axial_inflow", "translational_lift", "ground_effect",
            "steady_wind", "constant_force", "slung_load", "attitude_offset", "pose_delay")
OF_TORQUE = ("inertia", "center_of_mass", "rotor_loss", "flapping_torque", "yaw_torque_ratio", "rotor_inertia", "motor_lag", "actuation_delay", "saturation",
             "gyro_scale", "imu_lever")
EFFECTS = OF_FORCE + OF_TORQUE
OF_SENSORS = ("attitude_offset", "pose_delay", "gyro_scale", "imu_lever")    # an estimator of the pose mixes them
FAST = ("motor_lag", "actuation_delay", "rotor_inertia", "imu_lever")        # not to be seen in 50 Hz or filtered columns
# pairs that one log parts badly or not at all
ALIKE = [set(pair.split()) for pair in (
    "mass thrust_scale", "mass constant_force", "mass slung_load", "mass battery_sag", "mass thrust_curve", "thrust_scale constant_force",
    "thrust_scale slung_load", "thrust_scale battery_sag", "thrust_scale rotor_loss", "constant_force slung_load", "constant_force steady_wind",
    "constant_force attitude_offset", "steady_wind attitude_offset", "steady_wind rotor_drag", "steady_wind quadratic_drag", "rotor_drag quadratic_drag",
    "rotor_loss center_of_mass", "motor_lag actuation_delay", "motor_lag rotor_inertia", "motor_lag inertia", "actuation_delay inertia",
    "actuation_delay pose_delay", "inertia yaw_torque_ratio", "rotor_inertia yaw_torque_ratio", "saturation thrust_curve", "gyro_scale inertia")]


# ---- vehicles -----------------------------------------------------------------------------------------------------------------

@dataclass
class Craft:
    """A vehicle as its file says. The body's origin is its centre of mass."""
    name: str
    mass: float
    inertia: tuple
    places: tuple                # (x, y, direction seen from above) of each rotor
    height: float                # of the rotors
    hover: float                 # rad/s
    top: float                   # rad/s
    ratio: float                 # m
    radius: float
    voltage: float
    speed: float                 # of its flights, m/s
    known: dict                  # effects of its file

    @property
    def hubs(self):
        return np.array([(x, y, self.height) for x, y, _ in self.places])

    @property
    def spin(self):
        return np.array([1.0 if way == "ccw" else -1.0 for *_, way in self.places])

    @property
    def count(self):
        return len(self.places)

    @property
    def arm(self):
        return float(np.hypot(*self.hubs.T[:2]).mean())

    @property
    def weight(self):
        return self.mass * G

    @property
    def thrust(self):
        return self.weight / self.count / self.hover**2

    @property
    def pwm(self):
        offset = 0.12 * self.top
        return {"slope": (self.top - offset) / 65535, "offset": offset}


def cross_places(x, y, order):
    ways = {"front left": (x, y), "front right": (x, -y), "back left": (-x, y), "back right": (-x, -y)}
    return tuple((*ways[place], way) for place, way in order)


CRAFTS = {craft.name: craft for craft in (
    Craft("tiny", 0.035, (2.3e-5, 2.4e-5, 4.1e-5), cross_places(0.0325, 0.0325, (("front right", "ccw"), ("back right", "cw"), ("back left", "ccw"), ("front left", "cw"))),
          0.006, 2050.0, 3150.0, 6.1e-3, 0.0235, 3.7, 1.2,
          {"rotor_drag": {"at_hover": 0.012}, "axial_inflow": {"at_hover": 0.016}, "motor_lag": {"time_constant": 0.028, "time_constant_down": 0.04}}),
    Craft("racer", 0.25, (2.6e-4, 3.1e-4, 4.9e-4), cross_places(0.048, 0.055, (("back right", "cw"), ("front right", "ccw"), ("back left", "ccw"), ("front left", "cw"))),
          0.012, 1250.0, 2600.0, 0.011, 0.038, 14.8, 2.8,
          {"rotor_drag": {"at_hover": 0.055}, "quadratic_drag": {"area_xy": 0.008, "area_z": 0.014}, "translational_lift": {"coefficient": 0.0025},
           "motor_lag": {"time_constant": 0.02, "time_constant_down": 0.025}}),
    Craft("survey", 1.4, (0.0135, 0.0142, 0.0235), cross_places(0.16, 0.16, (("front right", "ccw"), ("back left", "ccw"), ("front left", "cw"), ("back right", "cw"))),
          0.03, 560.0, 920.0, 0.016, 0.12, 14.8, 2.4,
          {"rotor_drag": {"at_hover": 0.3}, "axial_inflow": {"at_hover": 0.8}, "flapping_torque": {"coefficient": 2e-6},
           "motor_lag": {"time_constant": 0.035, "time_constant_down": 0.045}}),
    Craft("hexa", 4.0, (0.11, 0.115, 0.2), tuple((0.34 * math.sin(math.radians(30 + 60 * k)), -0.34 * math.cos(math.radians(30 + 60 * k)), ("ccw", "cw")[k % 2]) for k in range(6)),
          0.05, 400.0, 640.0, 0.019, 0.165, 22.2, 2.4,
          {"rotor_drag": {"at_hover": 0.7}, "quadratic_drag": {"area_xy": 0.05, "area_z": 0.09}, "axial_inflow": {"at_hover": 2.2}, "rotor_inertia": {"inertia": 9e-5},
           "motor_lag": {"time_constant": 0.05, "time_constant_down": 0.06}}))}


def write_vehicle(folder, craft, known):
    """vehicle.toml and MJCF; `known`: the effects that the file says."""
    sites = [f"rotor{i + 1}" for i in range(craft.count)]
    table = {"format": "gustlab-vehicle/1", "name": f"foreign_{craft.name}", "mjcf": "vehicle.xml",
             "rotor": [{"site": site, "direction": way} for site, (*_, way) in zip(sites, craft.places)],
             "thrust": {"coefficient": craft.thrust, "torque_ratio": craft.ratio, "max_speed_radps": craft.top, "radius_m": craft.radius,
                        "nominal_voltage_V": craft.voltage},
             "actuator": {"pwm": craft.pwm, "throttle": {"slope": craft.top, "offset": 0.0}},
             "effect": [{"type": effect, **values} for effect, values in known.items()]}
    text = lambda numbers: " ".join(repr(float(x)) for x in numbers)
    root = xml.Element("mujoco", model=table["name"])
    xml.SubElement(root, "compiler", inertiafromgeom="false")
    body = xml.SubElement(xml.SubElement(root, "worldbody"), "body", name=table["name"], pos="0 0 1")
    xml.SubElement(body, "freejoint")
    xml.SubElement(body, "inertial", pos="0 0 0", mass=repr(craft.mass), diaginertia=text(craft.inertia))
    xml.SubElement(body, "geom", type="box", size=text(craft.arm * x for x in (0.5, 0.5, 0.2)), contype="0", conaffinity="0", group="1")
    for site, hub in zip(sites, craft.hubs):
        xml.SubElement(body, "site", name=site, pos=text(hub))
    xml.indent(root)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "vehicle.xml").write_text(xml.tostring(root, encoding="unicode") + "\n", encoding="utf-8")
    (folder / "vehicle.toml").write_text(vehicle_text(table), encoding="utf-8")


# ---- the real vehicle, and what of it is concealed -------------------------------------------------------------------------------

@dataclass
class Reality:
    mass: float
    inertia: np.ndarray
    center: np.ndarray                     # of mass, from the body's origin
    gain: np.ndarray                       # of each rotor's thrust and reaction torque
    lag: tuple                             # s, up and down
    values: dict                           # totals of the other effects of the catalogue: {effect: {parameter: value}}
    outside: dict = field(default_factory=dict)

    def value(self, effect, name):
        return self.values.get(effect, {}).get(name, 0.0)

    def vector(self, effect):
        return np.array([self.value(effect, axis) for axis in "xyz"])


def built(craft, known, rng):
    """A vehicle as a workshop builds it: close to its file."""
    near = lambda share, size=None: 1 + share * rng.standard_normal(size)
    lag = known["motor_lag"]
    return Reality(craft.mass * near(0.002), np.array(craft.inertia) * near(0.01, 3), 1e-3 * craft.arm * rng.standard_normal(3), near(0.003, craft.count),
                   (lag["time_constant"], lag["time_constant_down"]), {effect: dict(values) for effect, values in known.items()})


def sizes(craft):
    """{effect: (small but clear, large, what it is a measure of)}; of each the leading quantity."""
    share, v = craft.weight, craft.speed
    per_rotor = craft.weight / craft.count * craft.arm
    drag = craft.known["rotor_drag"]["at_hover"] + AIR_DENSITY * v / 2 * craft.known.get("quadratic_drag", {}).get("area_xy", 0.0)
    lead = 2 * craft.ratio * craft.thrust * craft.hover
    return {"mass": (0.025, 0.15, "of the mass"), "thrust_scale": (0.025, 0.12, "of the thrust"), "thrust_curve": (0.06, 0.3, "of the thrust, at twice hover"),
            "battery_sag": (0.5, 2.0, "exponent"), "rotor_drag": (0.025 * share / v, 0.1 * share / v, "N s/m"),
            "quadratic_drag": (0.06 * share / (AIR_DENSITY * v**2), 0.24 * share / (AIR_DENSITY * v**2), "m²"), "axial_inflow": (0.03 * share / 0.8, 0.12 * share / 0.8, "N s/m"),
            "translational_lift": (0.03 * share / craft.count / v**2, 0.12 * share / craft.count / v**2, "kg/m"), "ground_effect": (0.7, 1.5, "of the published formula"),
            "steady_wind": (0.025 * share / drag, 0.08 * share / drag, "m/s"), "constant_force": (0.02 * share, 0.08 * share, "N"),
            "slung_load": (0.03, 0.1, "of the mass"), "attitude_offset": (0.015, 0.06, "rad"), "pose_delay": (0.01, 0.04, "s"),
            "inertia": (0.12, 0.4, "of the inertia"), "center_of_mass": (0.012 * craft.arm, 0.06 * craft.arm, "m"), "rotor_loss": (0.03, 0.15, "of one rotor"),
            "flapping_torque": (0.05 * per_rotor / (craft.count * craft.hover * v), 0.25 * per_rotor / (craft.count * craft.hover * v), "N s²"),
            "yaw_torque_ratio": (0.12, 0.4, "of the ratio"), "rotor_inertia": (0.03 * lead, 0.1 * lead, "kg m²"), "motor_lag": (0.012, 0.035, "s"),
            "actuation_delay": (0.006, 0.025, "s"), "saturation": (1.12, 1.35, "of hover speed"), "gyro_scale": (0.015, 0.06, "of the rate"),
            "imu_lever": (0.2 * craft.arm, 0.6 * craft.arm, "m")}


LEADING = {"rotor_drag": "at_hover", "quadratic_drag": "area_xy", "axial_inflow": "at_hover", "translational_lift": "coefficient", "flapping_torque": "coefficient",
           "rotor_inertia": "inertia", "battery_sag": "exponent", "thrust_curve": "curvature", "pose_delay": "delay", "actuation_delay": "delay",
           "ground_effect": "of_formula", "slung_load": "mass"}


def conceal(effect, craft, known, reality, rng):
    """Puts an effect into the real vehicle, takes it from what the file says where that is drawn, and returns the truth of it."""
    low, high, unit = sizes(craft)[effect]
    size = low * (high / low)**rng.random()
    signed, angle, rotor = size * float(rng.choice((-1.0, 1.0))), rng.uniform(0, 2 * math.pi), None
    flat = {"x": size * math.cos(angle), "y": size * math.sin(angle), "z": 0.0}
    if effect == "mass":
        reality.mass *= 1 + signed
        values = {"delta": signed}
    elif effect == "inertia":
        change = signed * rng.uniform(0.7, 1.0, 3)
        reality.inertia = reality.inertia * (1 + change)
        values = dict(zip(("delta_x", "delta_y", "delta_z"), map(float, change)))
    elif effect == "center_of_mass":
        reality.center = reality.center + [flat["x"], flat["y"], 0]
        values = flat
    elif effect == "thrust_scale":
        reality.gain = reality.gain * (1 + signed)
        values = {"delta": signed}
    elif effect == "rotor_loss":
        rotor = int(rng.integers(craft.count)) + 1
        reality.gain[rotor - 1] *= 1 - size
        values = {"rotor": rotor, "loss": size}
    elif effect == "motor_lag":
        reality.lag = tuple(lag + size for lag in reality.lag)
        values = dict(zip(("time_constant", "time_constant_down"), reality.lag))
    elif effect in ("yaw_torque_ratio", "gyro_scale"):
        values = {"delta": signed}
    elif effect in ("steady_wind", "constant_force", "attitude_offset", "imu_lever"):
        values = flat
    elif effect == "saturation":
        values = {"max_speed": size * craft.hover}
    elif effect == "slung_load":
        values = {"mass": size * craft.mass, "length": float(rng.uniform(3, 8) * craft.arm)}
    else:
        values = {LEADING[effect]: signed if effect == "thrust_curve" else size}
        if effect == "quadratic_drag":
            values["area_z"] = 1.5 * size
        if effect in known and rng.random() < 0.5:
            known.pop(effect)
        elif effect in known:
            values = {name: value + known[effect].get(name, 0.0) for name, value in values.items()}
    reality.values[effect] = values
    return {"effect": effect, "rotor": rotor, "parameters": values, "file": dict(known.get(effect, {})), "size": f"{signed if 'delta' in values else size:.3g} {unit}"}


def draw_outside(name, craft, rng):
    """Parameters of physics that the catalogue does not have."""
    grow = lambda low, high: float(low * (high / low)**rng.random())
    return {"slosh": lambda: {"share": grow(0.05, 0.15), "hertz": rng.uniform(1.2, 2.5), "damping": 0.05},
            "rubber_band": lambda: {"share": grow(0.05, 0.12), "hertz": rng.uniform(1.5, 3.0), "length": 4 * craft.arm, "damping": 0.08},
            "updraft": lambda: {"speed": grow(0.8, 2.5), "width": 0.5 * craft.speed, "x": float(rng.normal(0, 0.4)), "y": float(rng.normal(0, 0.4))},
            "sticking_rotor": lambda: {"rotor": int(rng.integers(craft.count)), "band": grow(0.02, 0.06) * craft.hover},
            "imbalance": lambda: {"rotor": int(rng.integers(craft.count)), "force": grow(0.05, 0.2) * craft.weight / craft.count},
            "tether": lambda: {"stiffness": grow(0.03, 0.1) * craft.weight / craft.speed, "slack": 0.3 * craft.speed}}[name]()


# ---- paths -------------------------------------------------------------------------------------------------------------------------

def path_of(kind, craft, rng, steps):
    """Position (steps, 3), yaw, and what is added to the torques and the thrust: shares of what hover has of them."""
    t = STEP_S * np.arange(steps)
    begin = np.clip(t / 2, 0, 1)
    run = np.cumsum(begin**2 * (3 - 2 * begin)) * STEP_S       # time that starts slowly
    v, high = craft.speed, 0.6 + 0.35 * craft.speed
    shake = np.zeros((steps, 4))
    if kind == "eight":
        size = v * rng.uniform(0.7, 1.0)
        phase = run * v / size * rng.uniform(0.75, 1.05)
        p = np.column_stack([size * np.sin(phase), 0.5 * size * np.sin(2 * phase), high + 0.15 * v * np.sin(rng.uniform(0.6, 0.9) * phase)])
    elif kind == "circle":
        size, wobble = v * rng.uniform(0.6, 0.9), rng.uniform(0.5, 0.8)
        phase = v / size * (0.75 * run + 0.4 * np.sin(wobble * run) / wobble) * rng.choice([-1, 1])
        p = np.column_stack([size * np.cos(phase), size * np.sin(phase), high + 0.2 * v * np.sin(1.3 * run)])
    elif kind in ("steps", "stairs"):
        spots, now, at = [np.array([0, 0, high if kind == "steps" else 8 * craft.radius])], 2.0, [0.0, 2.0]
        spots.append(spots[0])
        while now < t[-1] + 3:
            if kind == "steps":
                spot = np.array([*rng.uniform(-0.8, 0.8, 2) * v, high + 0.25 * v * rng.uniform(-1, 1)])
            else:
                spot = np.array([*rng.uniform(-0.25, 0.25, 2) * v, craft.radius * rng.choice([2.2, 3, 4, 6, 9])])
            far = np.linalg.norm(spot - spots[-1])
            span = max(1.2, 1.25 * math.sqrt(far), 1.9 * far / v)
            spots += [spot, spot]
            at += [now + span, now + span + 0.4]
            now = at[-1]
        index = np.clip(np.searchsorted(at, t, side="right") - 1, 0, len(at) - 2)
        at, spots = np.array(at), np.array(spots)
        s = ((t - at[index]) / (at[index + 1] - at[index]))[:, None]
        p = spots[index] + (spots[index + 1] - spots[index]) * (10 * s**3 - 15 * s**4 + 6 * s**5)
    else:
        rates = 2 * math.pi * rng.uniform(0.15, 0.4, 3)
        p = np.array([0, 0, high]) + 0.35 * v * np.array([1, 1, 0.4]) * np.sin(np.outer(run, rates))
        sweep = (t[:, None] + rng.uniform(0, 6, 4)) % rng.uniform(5, 8)
        low, top = np.array([1.0, 1.0, 0.4, 0.4]), np.array([8, 8, 4, 3])
        # what tilts the vehicle is the weaker the slower it is
        weak = np.clip((low + (top - low) / 8 * sweep) / top, 0, 1)**[1, 1, 0, 0]
        shake = begin[:, None] * weak * np.sin(2 * math.pi * (low * sweep + (top - low) / 16 * sweep**2)) * rng.uniform([0.08, 0.08, 0.08, 0.1], [0.14, 0.14, 0.16, 0.18])
    turning = 0.5 * craft.weight * craft.ratio / craft.inertia[2]       # rad/s², with half of the thrust
    rate = 2 * math.pi * rng.uniform(0.15, 0.3)
    yaw = min(0.9, 0.3 * turning / rate**2) * np.sin(rate * run) + rng.uniform(-0.3, 0.3) * run
    return p, yaw, shake


# ---- air ---------------------------------------------------------------------------------------------------------------------------

def gusts(craft, rms, rng, steps, flights):
    """Dryden's velocity (steps, flights, 3) and turning (steps, flights, 3; of the body) of the air, without mean."""
    span, length, speed = 2 * (craft.arm + craft.radius), 6 * craft.arm + 0.6, 0.4 + 0.5 * craft.speed
    white = lambda: rng.standard_normal((steps, flights))

    def shaped(above, below, size):
        out = signal.lfilter(*signal.bilinear(above, below, 1 / STEP_S), white(), axis=0)
        return size * (out - out.mean(axis=0)) / max(1e-12, np.sqrt(np.mean((out - out.mean(axis=0))**2)))

    tau = length / speed
    second = ([math.sqrt(3) * tau, 1], [tau**2, 2 * tau, 1])
    velocity = [shaped([1], [tau, 1], rms), shaped(*second, rms), shaped(*second, rms)]
    turn_rms = 1.9 * rms / math.sqrt(length * span)
    turning = [shaped([1], [4 * span / (math.pi * speed), 1], turn_rms * share) for share in (1, 1, 0.6)]
    return np.stack(velocity, axis=-1), np.stack(turning, axis=-1)


# ---- physics, all flights of a trial at once ------------------------------------------------------------------------------------------

SKEW = np.zeros((3, 3, 3))
for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    SKEW[i, k, j], SKEW[i, j, k] = 1.0, -1.0


def skew(a):
    """(…, 3) → (…, 3, 3), so that skew(a) b = a × b."""
    return (a @ SKEW.reshape(3, 9)).reshape(*a.shape[:-1], 3, 3)


def cross(a, b):
    return (skew(a) @ b[..., None])[..., 0]


def small_turn(a):
    """Rotation matrices of small rotation vectors."""
    square, matrix = (a * a).sum(axis=-1)[..., None, None], skew(a)
    return np.eye(3) + (1 - square / 6) * matrix + (0.5 - square / 24) * (matrix @ matrix)


def off(matrix):
    """Axis of the antisymmetric part."""
    return 0.5 * np.stack([matrix[..., 2, 1] - matrix[..., 1, 2], matrix[..., 0, 2] - matrix[..., 2, 0], matrix[..., 1, 0] - matrix[..., 0, 1]], axis=-1)


class Plant:
    """The real vehicle in `flights` flights: p, v of the centre of mass in W, attitude R, rate w, rotor speeds."""

    def __init__(self, craft, reality, position, gust=None, turning=None):
        self.craft, self.real, n = craft, reality, len(position)
        self.hubs = craft.hubs - reality.center
        self.hub_rate = -skew(self.hubs)                                   # × w: velocity of a hub
        self.R, self.w, self.v = np.tile(np.eye(3), (n, 1, 1)), np.zeros((n, 3)), np.zeros((n, 3))
        self.p = position + reality.center
        self.speed = np.full((n, craft.count), craft.hover)
        self.acceleration, self.turn = np.zeros((n, 3)), np.zeros((n, 3))
        still = np.zeros((1, n, 3))
        self.gust, self.turning = (still if gust is None else gust), (still if turning is None else turning)
        per_hover = craft.count * craft.hover
        self.k_drag, self.k_axial = reality.value("rotor_drag", "at_hover") / per_hover, reality.value("axial_inflow", "at_hover") / per_hover
        self.k_lift, self.k_flap = reality.value("translational_lift", "coefficient"), reality.value("flapping_torque", "coefficient")
        self.curve, self.rotor_inertia = reality.value("thrust_curve", "curvature"), reality.value("rotor_inertia", "inertia")
        self.area = np.array([reality.value("quadratic_drag", "area_xy")] * 2 + [reality.value("quadratic_drag", "area_z")])
        self.ratio = craft.ratio * (1 + reality.value("yaw_torque_ratio", "delta"))
        self.wind, self.push = reality.vector("steady_wind"), reality.vector("constant_force")
        self.ground, self.top = reality.value("ground_effect", "of_formula"), reality.value("saturation", "max_speed") or craft.top
        self.outside, self.hung = reality.outside, None
        load = self.load()
        if load:
            hang = np.zeros(3) if load["inside"] else np.array([0, 0, -load["length"] - load["mass"] * G / load["stiffness"]])
            self.hung = [self.p + hang, np.zeros((n, 3))]
        self.phase, self.held = np.zeros(n), self.speed.copy()

    def load(self):
        """A point mass that hangs on the vehicle or moves in it: stiffness, damping, rest length."""
        real, found = self.real, None
        if "slung_load" in real.values:
            found = {"inside": False, "mass": real.value("slung_load", "mass"), "length": real.value("slung_load", "length"), "hertz": 15.0, "damping": 0.15}
        for name in ("slosh", "rubber_band"):
            if name in self.outside:
                found = {"inside": name == "slosh", "length": 0.0, **self.outside[name], "mass": self.outside[name]["share"] * self.craft.mass}
        if found:
            found["stiffness"] = found["mass"] * (2 * math.pi * found["hertz"])**2
            found["viscous"] = 2 * found["damping"] * found["mass"] * 2 * math.pi * found["hertz"]
        self.payload = found
        return found

    def rotor_wrench(self, speed, R, p, air, rate, gain):
        """Thrust along the axes, forces (flights, rotors, 3) at the hubs and the torque of the reaction and of flapping."""
        craft, lift = self.craft, gain * self.craft.thrust * speed**2
        if self.curve:
            lift = lift * (1 + self.curve * (lift / (craft.weight / craft.count) - 1))
        local = air[:, None, :] + np.einsum("nij,fj->fni", self.hub_rate, rate)
        across = local * [1.0, 1.0, 0.0]
        thrust = lift - self.k_axial * speed * local[..., 2] + self.k_lift * (across**2).sum(axis=-1)
        if self.ground:
            thrust = thrust * self.near_ground(p[:, None, 2] + np.einsum("ni,fi->fn", self.hubs, R[:, 2]))
        force = -self.k_drag * speed[..., None] * across
        force[..., 2] = thrust
        torque = np.einsum("nij,fnj->fi", skew(self.hubs), force)
        if self.k_flap:
            lean = self.k_flap * (speed[..., None] * local).sum(axis=1)
            torque = torque + np.column_stack([lean[:, 1], -lean[:, 0], np.zeros(len(lean))])       # v × e3
        torque[:, 2] -= self.ratio * (lift @ craft.spin)
        return force, torque

    def near_ground(self, z):
        """Sanchez-Cuevas, Heredia and Ollero 2017: own image, those of the neighbours, and the fountain under the body."""
        r, z = self.craft.radius, np.maximum(z, self.craft.radius)
        beside, opposite = math.sqrt(2) * self.craft.arm, 2 * self.craft.arm
        image = lambda d: r**2 * z / (d**2 + 4 * z**2)**1.5
        return 1 / (1 - self.ground * ((r / (4 * z))**2 + image(beside) + 0.5 * image(opposite) + 2 * 2 * image(opposite)))

    def outer(self, R, p, v):
        """Force in W at the centre of mass, and torque in B, of what is neither rotor nor drag."""
        force, torque = np.broadcast_to(self.push, p.shape), np.zeros(p.shape)
        if self.payload:
            load, (at, speed) = self.payload, self.hung
            far, relative = at - p, speed - v
            if load["inside"]:
                # a tank: free along x and y of the body, held along z
                along = np.einsum("fji,fj->fi", R, far), np.einsum("fji,fj->fi", R, relative)
                pull_B = (load["stiffness"] * along[0] + load["viscous"] * along[1]) * [1, 1, 0]
                pull_B[:, 2] = 200 * load["mass"] * (along[0][:, 2] * 60 + along[1][:, 2])
                pull = np.einsum("fij,fj->fi", R, pull_B)
            else:
                length = np.linalg.norm(far, axis=1, keepdims=True)
                way = far / length
                tension = load["stiffness"] * (length - load["length"]) + load["viscous"] * (relative * way).sum(axis=1, keepdims=True)
                pull = np.maximum(tension, 0) * way
                torque = cross(np.broadcast_to(-self.real.center, p.shape), np.einsum("fji,fj->fi", R, pull))
            force = force + pull
            self.hung[1] = speed + STEP_S * (-pull / load["mass"] - [0, 0, G])
            self.hung[0] = at + STEP_S * self.hung[1]
        if "tether" in self.outside:
            far = np.linalg.norm(p[:, :2], axis=1, keepdims=True)
            pull = self.outside["tether"]["stiffness"] * np.maximum(0, far - self.outside["tether"]["slack"]) / np.maximum(far, 1e-9)
            force = force - np.column_stack([p[:, :2] * pull, np.zeros(len(p))])
        return force, torque

    def wrench(self, k, R, p, v, w, speed, spin_up):
        """Specific force of the centre of mass and torque about it, in B."""
        real, g = self.real, min(k, len(self.gust) - 1)
        moving = self.wind + self.gust[g]
        if "updraft" in self.outside:
            up = self.outside["updraft"]
            moving = moving + np.column_stack([0 * p[:, :2], up["speed"] * np.exp(-((p[:, 0] - up["x"])**2 + (p[:, 1] - up["y"])**2) / (2 * up["width"]**2))])
        to_body = R.transpose(0, 2, 1)
        air = (to_body @ (v - moving)[..., None])[..., 0]
        force, torque = self.rotor_wrench(speed, R, p, air, w - self.turning[g], real.gain)
        total = force.sum(axis=1) - 0.5 * AIR_DENSITY * self.area * np.sqrt((air**2).sum(axis=1, keepdims=True)) * air
        if self.rotor_inertia:
            momentum = self.rotor_inertia * (speed @ self.craft.spin)
            torque[:, 2] -= self.rotor_inertia * (spin_up @ self.craft.spin)
            torque[:, 0] -= w[:, 1] * momentum
            torque[:, 1] += w[:, 0] * momentum
        outer, outer_torque = self.outer(R, p, v)
        total, torque = total + (to_body @ outer[..., None])[..., 0], torque + outer_torque
        if "imbalance" in self.outside:
            bad = self.outside["imbalance"]
            self.phase = self.phase + STEP_S * speed[:, bad["rotor"]]
            size = bad["force"] * (speed[:, bad["rotor"]] / self.craft.hover)**2
            shaking = np.column_stack([size * np.cos(self.phase), size * np.sin(self.phase), 0 * size])
            total, torque = total + shaking, torque + cross(np.broadcast_to(self.hubs[bad["rotor"]], shaking.shape), shaking)
        mass = real.mass - (self.payload["mass"] if self.payload and self.payload["inside"] else 0.0)
        return total / mass, torque

    def step(self, k, command, voltage):
        """One millisecond, by the midpoint; the specific force in it. `voltage`: over the nominal one."""
        real = self.real
        target = command * (voltage**(real.value("battery_sag", "exponent") / 2))[:, None]
        if "sticking_rotor" in self.outside:
            bad = self.outside["sticking_rotor"]
            at = bad["rotor"]
            self.held[:, at] = np.where(np.abs(target[:, at] - self.held[:, at]) > bad["band"], target[:, at], self.held[:, at])
            target = target.copy()
            target[:, at] = self.held[:, at]
        target = np.minimum(target, self.top)
        left = np.where(target > self.speed, math.exp(-STEP_S / real.lag[0]), math.exp(-STEP_S / real.lag[1]))
        after = target + (self.speed - target) * left
        half = 0.5 * STEP_S
        R = self.R @ small_turn(half * self.w)
        w = self.w + half * self.turn
        specific, torque = self.wrench(k, R, self.p + half * self.v, self.v + half * self.acceleration, w, 0.5 * (self.speed + after), (after - self.speed) / STEP_S)
        self.turn = (torque - cross(w, real.inertia * w)) / real.inertia
        self.acceleration = (R @ specific[..., None])[..., 0] - [0, 0, G]
        self.R = self.R @ small_turn(STEP_S * (self.w + half * self.turn))
        if k % 100 == 0:
            self.R = 1.5 * self.R - 0.5 * self.R @ self.R.transpose(0, 2, 1) @ self.R
        self.p = self.p + STEP_S * (self.v + half * self.acceleration)
        self.v, self.w, self.speed = self.v + STEP_S * self.acceleration, self.w + STEP_S * self.turn, after
        return specific


# ---- loops -------------------------------------------------------------------------------------------------------------------------

class Pilot:
    """A loop of one of three kinds, with the vehicle file's numbers, on measured signals."""

    def __init__(self, kind, craft, flights, period_s, stiff):
        self.kind, self.craft, self.dt = kind, craft, period_s
        lag = sum(craft.known["motor_lag"].values()) / 2
        self.rate_gain = stiff * 0.5 / (lag + 0.006) * np.array([1, 1, 0.6])
        tilt = self.rate_gain[0] / 2.5
        self.tilt_gain = tilt * np.array([1, 1, 0.6])
        self.v_gain = tilt / 2.0
        self.p_gain, self.i_gain = self.v_gain**2 / 2.6, self.v_gain**3 / 16
        self.drag = craft.known["rotor_drag"]["at_hover"] / craft.mass
        self.J = np.array(craft.inertia)
        hubs = craft.hubs
        self.mix = np.stack([np.ones(craft.count), hubs[:, 1], -hubs[:, 0], -craft.spin * craft.ratio])
        self.unmix = np.linalg.pinv(self.mix)
        self.follow = 1 - math.exp(-period_s / lag)
        self.keep = math.exp(-4 * period_s / lag)                   # low pass of the rate's change and of the thrusts, four times as fast as the rotors
        self.sum_p, self.sum_w = np.zeros((flights, 3)), np.zeros((flights, 3))
        self.slope, self.before = np.zeros((flights, 3)), None
        self.model = np.full((flights, craft.count), craft.weight / craft.count)
        self.model_slow = self.model.copy()

    def command(self, wanted, p, v, R, w):
        """Rotor speeds; `wanted`: position, velocity, acceleration, jerk, yaw, its rate, shake."""
        pd, vd, ad, jd, yaw, yaw_rate, shake = wanted
        self.sum_p = np.clip(self.sum_p + self.dt * (pd - p), -1.0, 1.0)
        a = ad + self.drag * vd + self.p_gain * (pd - p) + self.v_gain * (vd - v) + self.i_gain * self.sum_p + [0, 0, G]
        size = np.sqrt((a * a).sum(axis=1, keepdims=True))
        b3 = a / size
        b2 = cross(b3, np.column_stack([np.cos(yaw), np.sin(yaw), 0 * yaw]))
        b2 = b2 / np.sqrt((b2 * b2).sum(axis=1, keepdims=True))
        b1 = cross(b2, b3)
        lean = jd / size
        rate = np.column_stack([-(lean * b2).sum(axis=1), (lean * b1).sum(axis=1), yaw_rate * b3[:, 2]])
        error = off(R.transpose(0, 2, 1) @ np.stack([b1, b2, b3], axis=-1))
        thrust = self.craft.mass * (a * R[:, :, 2]).sum(axis=1)
        asked = rate + self.tilt_gain * error - w
        self.slope = self.keep * self.slope + (1 - self.keep) * ((w - self.before) / self.dt if self.before is not None else 0.0)
        self.before = w
        turn = self.rate_gain * asked
        if self.kind == "pid":
            self.sum_w = np.clip(self.sum_w + self.dt * asked, -0.5, 0.5)
            torque = self.J * (turn + 0.8 * self.rate_gain * self.sum_w - 0.01 * self.rate_gain * self.slope)
        elif self.kind == "geometric":
            torque = self.J * turn + cross(w, self.J * w)
        else:
            torque = self.model_slow @ self.mix[1:].T + self.J * (turn - self.slope)
        hover = self.craft.weight / 2 * np.array([self.craft.arm, self.craft.arm, self.craft.ratio])
        torque = torque + shake[:, :3] * hover
        thrust = thrust + shake[:, 3] * self.craft.weight
        each = np.column_stack([thrust, torque]) @ self.unmix.T
        each = np.clip(each, 0.04 * self.craft.weight / self.craft.count, self.craft.thrust * self.craft.top**2)
        self.model = self.model + self.follow * (each - self.model)
        self.model_slow = self.keep * self.model_slow + (1 - self.keep) * self.model
        return np.sqrt(each / self.craft.thrust)


@dataclass
class Setting:
    """How a trial is flown and recorded; noise is sigma of a sample."""
    loop: str
    style: str
    rms_mps: float                # gusts
    period: int                   # steps of the loop
    stiff: float
    actuator: str
    position_m: float
    attitude_rad: float
    gyro_radps: float
    accel_mps2: float
    vibration: float              # share of the usual
    kinds: tuple
    seconds: tuple


def draw_setting(style, air, effects, rng):
    low, high = AIRS[air]
    kinds = list(rng.permutation(["eight", "steps", "chirp", "circle"]))
    if "chirp" in kinds[3:]:
        kinds = kinds[1:] + kinds[:1]                 # the chirp is a flight to fit
    if "ground_effect" in effects:
        kinds[0] = kinds[3] = "stairs"
    actuator = {"default": "throttle", "collective": "collective_thrust"}.get(style) or str(rng.choice(["rotor_speed", "pwm", "thrust"]))
    noisy = rng.uniform(0.7, 2.0)
    return Setting(str(rng.choice(LOOPS)), style, float(rng.uniform(low, high)), int(rng.choice([1, 2])), float(rng.uniform(0.8, 1.2)), actuator, 2.5e-4 * noisy,
                   1.5e-3 * noisy, 0.006 * noisy, 0.06 * noisy, float(rng.uniform(0.3, 1.5)), tuple(map(str, kinds)), tuple(map(float, rng.uniform(12, 20, 4))))


def fly(craft, reality, setting, rng):
    """{name: (steps, flights, …)} of what happened, or why the flights cannot be used."""
    n, steps = len(setting.kinds), SETTLE + round(max(setting.seconds) / STEP_S) + 1
    # a few steps longer than the flight: at the ends differences are coarse
    paths = [path_of(kind, craft, rng, steps + 5) for kind in setting.kinds]
    p, yaw, shake = (np.stack(part, axis=1) for part in zip(*paths))
    slope = lambda x: np.gradient(x, STEP_S, axis=0)
    v, yaw_rate = slope(p), slope(yaw)
    a = slope(v)
    jerk = slope(a)
    plant = Plant(craft, reality, p[0], *gusts(craft, setting.rms_mps, rng, steps, n))
    pilot = Pilot(setting.loop, craft, n, setting.period * STEP_S, setting.stiff)
    drain = rng.uniform(0.06, 0.14, n) / steps
    voltage = rng.uniform(0.98, 1.06, n) - drain * np.arange(steps)[:, None]
    noise = rng.standard_normal((steps, n, 3, 4)) * [setting.position_m, 0.01, setting.attitude_rad, setting.gyro_radps]
    late = round(reality.value("actuation_delay", "delay") / STEP_S)
    shapes = {"p": (3,), "v": (3,), "R": (3, 3), "w": (3,), "f": (3,), "turn": (3,), "u": (craft.count,), "rotor": (craft.count,)}
    out = {name: np.empty((steps, n, *shape)) for name, shape in shapes.items()}
    offset, wm = small_turn(reality.vector("attitude_offset")[None]), np.zeros((n, 3))
    smooth = 1 - math.exp(-2 * math.pi * 70 * setting.period * STEP_S)
    command = plant.speed.copy()
    for k in range(steps):
        if k % setting.period == 0:
            e = noise[k]
            wm = wm + smooth * (plant.w + e[..., 3] - wm)
            origin = plant.p - plant.R @ reality.center
            command = pilot.command((p[k], v[k], a[k], jerk[k], yaw[k], yaw_rate[k], shake[k]), origin + e[..., 0], plant.v + e[..., 1],
                                    plant.R @ offset @ small_turn(e[..., 2]), wm)
        for name in ("p", "v", "R", "w"):
            out[name][k] = getattr(plant, name)
        out["rotor"][k], out["u"][k] = plant.speed, command
        out["f"][k] = plant.step(k, out["u"][max(0, k - late)], voltage[k])
        out["turn"][k] = plant.turn
        if k % 200 == 0 and not (np.abs(plant.p - p[k]).max() < 0.5 + 0.5 * craft.speed and plant.R[:, 2, 2].min() > 0.3 and plant.p[:, 2].min() > 0.5 * craft.radius):
            return f"{setting.kinds[int(np.argmax(np.abs(plant.p - p[k]).max(axis=1)))]} lost at {k * STEP_S:.1f} s"
    # what acts in a step is that of its middle: the samples lie between two steps
    for name in ("f", "turn"):
        out[name][1:] = 0.5 * (out[name][1:] + out[name][:-1])
    clipped = np.mean(out["u"] >= plant.top * (1 - 1e-6))
    if plant.top == craft.top and (clipped > 0.005 or np.mean(out["u"] <= craft.hover * 0.21) > 0.005):
        return "motors at their limits"
    if plant.top < craft.top and not 0.002 < clipped < 0.1:
        return "too little or too much of saturation"
    return {**out, "voltage": voltage * craft.voltage, "p_wanted": p[:steps]}


# ---- records -------------------------------------------------------------------------------------------------------------------------

def quaternion(R):
    q = Rotation.from_matrix(R).as_quat()[:, [3, 0, 1, 2]]
    return q * np.cumprod(np.r_[1.0, np.where(np.sum(q[1:] * q[:-1], axis=1) < 0, -1.0, 1.0)])[:, None]


def estimate(t, gyro, accel, p, R, every):
    """A filter of constant gains on inertial data: pose (each `every` samples) corrects what is integrated. Position, velocity, attitude."""
    dt, n = t[1] - t[0], len(t)
    at, speed, turn, bias_w, bias_a = p[0], np.zeros(3), R[0], np.zeros(3), np.zeros(3)
    out_p, out_v, out_R = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3))
    for k in range(n):
        if k % every == 0:
            error, tilt = p[k] - at, off(turn.T @ R[k])
            at, speed, turn = at + 0.25 * error, speed + 1.2 * error, turn @ small_turn(0.12 * tilt)
            bias_w, bias_a = bias_w - 0.02 * tilt, bias_a - 0.15 * turn.T @ error
        out_p[k], out_v[k], out_R[k] = at, speed, turn
        acceleration = turn @ (accel[k] - bias_a) - [0, 0, G]
        at, speed, turn = at + dt * (speed + 0.5 * dt * acceleration), speed + dt * acceleration, turn @ small_turn(dt * (gyro[k] - bias_w))
    out_R = 1.5 * out_R - 0.5 * out_R @ out_R.transpose(0, 2, 1) @ out_R
    return out_p, out_v, out_R


class Recorder:
    """Streams of one flight: each with its own rate, sampled from the steps of 1 ms."""

    def __init__(self, craft, reality, setting, flown, flight, rng):
        self.craft, self.setting, self.rng = craft, setting, rng
        self.last = SETTLE + round(setting.seconds[flight] / STEP_S)
        of = {name: values[:, flight] for name, values in flown.items()}
        lever = reality.vector("imu_lever") - reality.center
        w = of["w"]
        self.accel = of["f"] + np.cross(of["turn"], lever) + np.cross(w, np.cross(w, lever))
        self.gyro = w * (1 + reality.value("gyro_scale", "delta"))
        # what rotors shake: once and twice a turn, each with its own phase; sampled as it is, so that it aliases
        phase = STEP_S * np.cumsum(of["rotor"], axis=0) + rng.uniform(0, 2 * math.pi, craft.count)
        strong = (of["rotor"] / craft.hover)**2
        for harmonic, share in ((1, 1.0), (2, 0.4)):
            wave = strong * np.sin(harmonic * phase) * share * setting.vibration
            self.accel = self.accel + 0.12 * wave @ rng.standard_normal((craft.count, 3))
            self.gyro = self.gyro + 0.006 * wave @ rng.standard_normal((craft.count, 3))
        self.gyro = self.gyro + 0.008 * rng.standard_normal(3)
        self.accel = self.accel + 0.05 * rng.standard_normal(3)
        late = round(reality.value("pose_delay", "delay") / STEP_S)
        old = np.maximum(np.arange(len(w)) - late, 0)
        self.p, self.v = (of["p"] - of["R"] @ reality.center)[old], (of["v"] - np.einsum("kij,kj->ki", of["R"], np.cross(w, reality.center)))[old]
        self.R = (of["R"] @ small_turn(reality.vector("attitude_offset")[None]))[old]
        self.u, self.rotor, self.voltage = of["u"], of["rotor"], of["voltage"]

    def noise(self, rows, sigma, width=3):
        return sigma * self.rng.standard_normal((len(rows), width))

    def inertial(self, rows):
        """Of a sensor that averages over its sample, of 16 bits."""
        average = lambda x: 0.5 * (x[rows] + x[np.maximum(rows - 1, 0)])
        grid = lambda x, step: step * np.round(x / step)
        return grid(average(self.gyro) + self.noise(rows, self.setting.gyro_radps), 1.065e-3), grid(average(self.accel) + self.noise(rows, self.setting.accel_mps2), 4.8e-3)

    def pose(self, rows):
        turn = self.R[rows] @ small_turn(self.noise(rows, self.setting.attitude_rad))
        return 1e-5 * np.round(1e5 * (self.p[rows] + self.noise(rows, self.setting.position_m))), turn

    def inputs(self, rows):
        u, craft = self.u[rows], self.craft
        kind = self.setting.actuator
        if kind == "collective_thrust":
            return {"u1": craft.thrust * (u**2).sum(axis=1)}
        u = {"pwm": lambda: np.round((u - craft.pwm["offset"]) / craft.pwm["slope"]), "thrust": lambda: craft.thrust * u**2, "throttle": lambda: u / craft.top,
             "rotor_speed": lambda: u}[kind]()
        return named("u", u)


def named(prefix, values):
    names = {"p": ("px", "py", "pz"), "v": ("vx", "vy", "vz"), "q": ("qw", "qx", "qy", "qz"), "w": ("wx", "wy", "wz"), "a": ("ax", "ay", "az")}
    return dict(zip(names.get(prefix, [f"{prefix}{i + 1}" for i in range(values.shape[1])]), values.T))


def merged(streams):
    """One table of streams [(rows, {column: values})], with empty cells between the samples of each."""
    rows = np.unique(np.concatenate([at for at, _ in streams]))
    column = {"time_s": (rows - rows[0]) * STEP_S}
    for at, values in streams:
        place = np.searchsorted(rows, at)
        for name, cells in values.items():
            column[name] = np.full(len(rows), np.nan)
            column[name][place] = cells
    return column


def record(craft, reality, setting, flown, flight, rng):
    """The log of one flight in its style."""
    r = Recorder(craft, reality, setting, flown, flight, rng)
    at = lambda hertz, phase=0: np.arange(SETTLE + phase, r.last + 1, round(1 / (STEP_S * hertz)))
    volts = lambda rows: {"vbat": 0.001 * np.round(1000 * (r.voltage[rows] + 0.002 * craft.voltage * rng.standard_normal(len(rows))))}
    hold, style = "unknown", setting.style
    inertial = lambda rows: dict(zip(("w", "a"), r.inertial(rows)))
    flat = lambda parts: {name: cells for prefix, values in parts.items() for name, cells in named(prefix, values).items()}
    if style == "imu":
        hold = "zoh" if setting.period == 2 else "unknown"
        p, R = r.pose(rows := at(100, 1))
        column = merged([(at(500), {**flat(inertial(at(500))), **r.inputs(at(500))}), (rows, flat({"p": p, "q": quaternion(R)})), (at(10), volts(at(10)))])
    elif style in ("mocap", "filtered"):
        rows = at(200 if style == "mocap" else int(rng.choice([100, 200, 250])))
        p, R = r.pose(rows)
        v = signal.savgol_filter(p, 11, 3, deriv=1, delta=STEP_S * (rows[1] - rows[0]), axis=0)
        column = {"time_s": (rows - rows[0]) * STEP_S, **flat({"p": p, "v": v, "q": quaternion(R), **inertial(rows)}), **r.inputs(rows)}
        if style == "filtered":
            sections = signal.butter(2, rng.uniform(12, 20), fs=1 / (STEP_S * (rows[1] - rows[0])), output="sos")
            column = {name: cells if name == "time_s" else signal.sosfiltfilt(sections, cells) for name, cells in column.items()}
            size = np.sqrt(sum(column[name]**2 for name in ("qw", "qx", "qy", "qz")))
            column |= {name: column[name] / size for name in ("qw", "qx", "qy", "qz")}
        column |= volts(rows)
    elif style in ("estimator", "default"):
        # the filter runs before the log begins, with samples of its own
        every = 4 if style == "estimator" else 5
        rows = np.arange(0, r.last + 1, every)
        gyro, accel = r.inertial(rows)
        p, v, R = estimate(rows * STEP_S, gyro, accel, *r.pose(rows), 20 // every)
        of = lambda values, some: values[some // every]
        if style == "estimator":
            rows = at(250)
            speeds = r.rotor[rows] * (1 + 0.002 * rng.standard_normal((len(rows), craft.count)))
            column = merged([(rows, {**flat({"p": of(p, rows), "v": of(v, rows), "q": quaternion(of(R, rows)), "w": of(gyro, rows), "a": of(accel, rows)}), **r.inputs(rows),
                                     **named("rotor", np.round(speeds, 1))}), (at(10), volts(at(10)))])
        else:
            fast, slow, seldom = at(50, 3), at(20, 5), at(10, 10)
            column = merged([(at(100), flat(inertial(at(100)))), (fast, r.inputs(fast)), (slow, {**named("q", quaternion(of(R, slow)))}),
                             (seldom, {**flat({"p": of(p, seldom), "v": of(v, seldom)}), **volts(seldom)})])
    else:
        rows, seldom = at(100), at(25)
        p, R = r.pose(rows)
        v = r.v[rows] + r.noise(rows, 0.01)
        column = merged([(rows, flat({"p": p, "v": v, "q": quaternion(R), **inertial(rows)})), (seldom, {**r.inputs(seldom), **volts(seldom)})])
    meta = {"format": "gustlab-flight/1", "actuator": setting.actuator, "source": "recording", "hold": hold, "notes": "", "environment": {"ground_z_m": 0.0}}
    return Log("", meta, column)


# ---- trials ---------------------------------------------------------------------------------------------------------------------------

BLOCK = (*["nothing"] * 5, *["outside"] * 4, *["pair"] * 8, *["single"] * 23)


def plan(seed, number):
    """(kind, effects) of one trial; every block of 40 trials has the same mixture, and single effects take turns."""
    block, at = divmod(number, len(BLOCK))
    order = np.random.default_rng([seed, 1, block]).permutation(BLOCK)
    kind, before = str(order[at]), int(np.sum(order[:at] == order[at]))
    turn = block * BLOCK.count(kind) + before
    taken = lambda names: str(np.random.default_rng([seed, 2, turn // len(names)]).permutation(names)[turn % len(names)])
    if kind == "nothing":
        return kind, ()
    if kind == "outside":
        return kind, (taken(OUTSIDE),)
    if kind == "single":
        return kind, (taken(EFFECTS),)
    rng = np.random.default_rng([seed, 3, turn])
    while True:
        pair = tuple(map(str, rng.choice(EFFECTS, 2, replace=False)))
        if set(pair) not in ALIKE and allowed(pair):
            return kind, pair


def allowed(effects):
    """Styles in which all of them can be seen."""
    def shows(style):
        return not any((style == "collective" and e in OF_TORQUE) or (style in ("estimator", "default") and e in OF_SENSORS)
                       or (style in ("default", "filtered") and e in FAST) for e in effects)
    return [style for style in STYLES if shows(style)]


def draw(seed, number, out, style=None, air=None):
    """Writes one trial and returns its truth; nothing where what is concealed cannot be seen in this style. Flights that a vehicle cannot fly are
    drawn again."""
    name, (kind, effects) = f"trial_{number + 1:04}", plan(seed, number)
    rng = np.random.default_rng([seed, 4, number])
    if style and style not in allowed(effects):
        return None
    # drawn in any case: the rest of a trial stays as it is
    any_style, any_air, craft = str(rng.choice(allowed(effects))), str(rng.choice(list(AIRS))), CRAFTS[str(rng.choice(list(CRAFTS)))]
    style, air = style or any_style, air or any_air
    for attempt in range(20):
        known = {effect: dict(values) for effect, values in craft.known.items()}
        reality = built(craft, known, rng)
        if kind == "outside":
            reality.outside = {effects[0]: draw_outside(effects[0], craft, rng)}
            truth = [{"effect": effects[0], "rotor": None, "parameters": reality.outside[effects[0]], "file": {}, "size": ""}]
        else:
            truth = [conceal(effect, craft, known, reality, rng) for effect in effects]
        setting = draw_setting(style, air, effects, rng)
        flown = fly(craft, reality, setting, rng)
        if isinstance(flown, dict):
            break
        print(f"{name}: {craft.name} with {', '.join(effects) or 'nothing'}: {flown}; drawn again", file=sys.stderr, flush=True)
    else:
        raise RuntimeError(f"{name}: no flight of twenty can be used")
    write_vehicle(out / name / "vehicle", craft, known)
    for flight, role in enumerate(ROLES):
        write_log(out / name / f"{role}.csv", record(craft, reality, setting, flown, flight, rng), "vehicle/vehicle.toml")
    return {"trial": name, "seed": seed, "kind": kind, "vehicle": craft.name, "style": style, "air": air, "effects": truth, "setting": vars(setting)}


# ---- scores ---------------------------------------------------------------------------------------------------------------------------

OUTCOMES = ("exact", "wrong", "part", "withheld", "not_told", "nothing", "failed")


def judge(truth, found, run):
    """One row. exact: all of it named, and nothing else (a name also counts by its class) | wrong: a name that is not true | part: one of two |
    withheld: only suspected | not_told: said to be not identifiable | nothing | failed: no diagnosis. Physics outside of the catalogue has no name."""
    hidden, outside = truth["effects"], truth["kind"] == "outside"
    row = {key: truth[key] for key in ("trial", "kind", "vehicle", "style", "air")}
    row |= {"truth": truth_names(hidden), "size": [e["size"] for e in hidden], "cpu_seconds": run.get("cpu_seconds")}
    fair = [(name, None) for name in FAIR.get(hidden[0]["effect"], ())] if outside else [(e["effect"], e["rotor"]) for e in hidden]
    # the air of such a trial is a gust, whether or not it is told from noise
    right = lambda finding: any(means(finding, *name) for name in fair) or (truth["air"] != "calm" and finding["effect"] == "gust")
    blind = {entry["effect"] for entry in (found or {}).get("not_identifiable", [])}
    told = found and found["verdict"] != "insufficient_data" and not all(name in blind for name, _ in fair)
    return row | counted(found, fair, right, lambda e: f"{label(e)} ({e['confidence']:.2f})", "part", "nothing" if told else "not_told", enough=outside)


def markdown(rows):
    """Counts by kind, effect, style, vehicle and air, and every trial that is not exact."""
    def cpu(chosen):
        seconds = [row["cpu_seconds"] for row in chosen if row["cpu_seconds"] is not None]
        return f"{np.mean(seconds):.0f}" if seconds else None

    lines = []
    for key in ("kind", "style", "vehicle", "air"):
        lines += table(key, by_value(rows, key) + ([("all", rows)] if key == "kind" else []), OUTCOMES, "CPU s, mean", cpu)
    lines += table("concealed alone", by_effect([row for row in rows if row["kind"] in ("single", "outside")]), OUTCOMES, "CPU s, mean", cpu)
    lines += others(rows, ("vehicle", "style", "air"), ("named", "suspected"), lambda name, row, k: f"{name} ({row['size'][k]})" if row["size"][k] else name)
    return "\n".join(lines) + "\n"


def trial(number, options):
    """Draws, diagnoses and judges one trial; what is finished is kept."""
    name = f"trial_{number + 1:04}"
    place = options.out / name
    kept = options.out / "truths" / f"{name}.json"
    if not kept.exists():
        truth = draw(options.seed, number, options.out, options.style, options.air)
        if truth is None:
            return None, None
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_text(json.dumps(truth) + "\n", encoding="utf-8")
    truth = json.loads(kept.read_text(encoding="utf-8"))
    for key in ("seed", "style", "air"):
        if getattr(options, key) not in (None, truth[key]):
            raise SystemExit(f"{options.out} holds trials of {key} {truth[key]}")
    if options.draw_only:
        return truth, None
    path, run = place / "diagnosis" / "diagnosis.json", place / "run.json"
    if not run.exists():
        command = ["timeout", str(options.seconds), options.gustlab, "diagnose", *(str(place / f"{role}.csv") for role in ROLES[:3]), "--holdout",
                   str(place / f"{ROLES[3]}.csv"), "--out", str(place / "diagnosis"), "--jobs", "1"]
        run.write_text(json.dumps(run_measured(command, place / "messages.txt")) + "\n", encoding="utf-8")
    found = json.loads(path.read_text(encoding="utf-8")) if path.exists() else None
    return truth, judge(truth, found, json.loads(run.read_text(encoding="utf-8")))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, required=True)
    parser.add_argument("--first", type=int, default=1, help="number of the first trial")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--style", choices=STYLES, help="how all are logged; what it cannot show is left out")
    parser.add_argument("--air", choices=tuple(AIRS), help="of all")
    parser.add_argument("--gustlab", default=str(HOME / "build/release/gustlab"))
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--seconds", type=int, default=900, help="a diagnosis that takes longer has failed")
    parser.add_argument("--draw-only", action="store_true", help="write the trials, ask nothing")
    options = parser.parse_args()
    numbers, truths, rows = range(options.first - 1, options.first - 1 + options.count), [], []
    with concurrent.futures.ProcessPoolExecutor(options.jobs) as pool:
        for truth, row in pool.map(trial, numbers, [options] * len(numbers)):
            if truth is None:
                continue
            truths.append(truth)
            rows += [row] if row else []
            (options.out / "truth.jsonl").write_text("".join(path.read_text(encoding="utf-8") for path in sorted((options.out / "truths").glob("*.json"))), encoding="utf-8")
            (options.out / "results.jsonl").write_text("".join(json.dumps(line) + "\n" for line in rows), encoding="utf-8")
            print(f"[{len(truths)}/{len(numbers)}] {truth['trial']} {', '.join(e['effect'] for e in truth['effects']) or 'nothing'}: {row['outcome'] if row else 'drawn'}",
                  file=sys.stderr, flush=True)
    sys.stdout.write(markdown(rows) if rows else "")


if __name__ == "__main__":
    main()
