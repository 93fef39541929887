"""Own physics of a multirotor's wrench, and inputs that give a recorded motion although an effect is in place.

What the rotors must do follows from the recording alone: the wrench that the vehicle file gives to the recorded inputs. With
an effect in place other inputs give this wrench; they are found by putting what is missing back through the mixer. Rotors
push along z only: forces to the side cannot be put in, so mass, drag and a tilted rotor are no effects here.

Formulas are those of the catalogue of effects; nothing is shared with src/. Rotors' thrusts are the unknowns, (samples, N) [N].
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt
from scipy.spatial.transform import Rotation

# reporting tolerances (DIAGNOSIS.md, 3.6); of the centre of mass: the torque of 1.2 % of one rotor
TOLERANCE = {"mass": 0.012, "thrust_scale": 0.012, "rotor_loss": 0.01, "inertia": 0.05, "yaw_torque_ratio": 0.05, "motor_lag": 0.004,
             "actuation_delay": 0.003, "pose_delay": 0.003, "gyro_scale": 0.01, "center_of_mass": 0.003}


@dataclass
class Motion:
    """What the body does at the times of the inputs; None where the log does not tell."""
    time_s: np.ndarray
    velocity_B: np.ndarray | None       # m/s, (n, 3)
    rate_B: np.ndarray | None           # rad/s
    angular_B: np.ndarray | None        # rad/s², of the rate below 15 Hz
    specific_B: np.ndarray | None       # m/s², specific force
    height_m: np.ndarray | None         # above the ground, of every hub, (n, N)
    voltage_V: np.ndarray | None


def low_pass(time_s, values, cut_Hz):
    """Zero-phase Butterworth filter of evenly sampled values."""
    rate = 1.0 / np.median(np.diff(time_s))
    return values if cut_Hz >= 0.45 * rate else sosfiltfilt(butter(2, cut_Hz / (rate / 2), output="sos"), values, axis=0)


def stream(log, *names):
    """(time_s (m,), values (m, k)) of the rows that have all of these columns, or None."""
    values = log.stack(*names)
    if values is None:
        return None
    rows = np.all(np.isfinite(values), axis=1)
    return (log.column["time_s"][rows], values[rows]) if rows.sum() > 10 else None


def even(samples, cut_Hz, rate_Hz=None):
    """A spline of a stream after a low pass on an even grid."""
    time_s, values = samples
    step = np.median(np.diff(time_s)) if rate_Hz is None else 1.0 / rate_Hz
    grid = np.arange(time_s[0], time_s[-1] + 0.5 * step, step)
    return CubicSpline(grid, low_pass(grid, CubicSpline(time_s, values)(np.minimum(grid, time_s[-1])), cut_Hz))


def motion_at(log, vehicle, time_s):
    """The recorded motion at `time_s` (clipped to the recording)."""
    inside = lambda samples: np.clip(time_s, samples[0][0], samples[0][-1])
    q, p, v, w = (stream(log, *names) for names in (("qx", "qy", "qz", "qw"), ("px", "py", "pz"), ("vx", "vy", "vz"), ("wx", "wy", "wz")))
    turn = None
    if q is not None:
        flips = np.cumprod(np.r_[1.0, np.where(np.sum(q[1][1:] * q[1][:-1], axis=1) < 0, -1.0, 1.0)])
        turn = Rotation.from_quat(even((q[0], q[1] * flips[:, None]), 20)(inside(q)))
    rates = None if w is None else even(w, 15)
    rate, angular = (None, None) if w is None else (rates(inside(w)), rates.derivative()(inside(w)))
    velocity = even(v, 10) if v is not None else even(p, 6).derivative() if p is not None else None
    a = stream(log, "ax", "ay", "az")
    specific = None
    if velocity is not None and turn is not None:
        at = inside(v if v is not None else p)
        specific = turn.inv().apply(velocity.derivative()(at) + [0, 0, 9.81])
    elif a is not None:
        specific = even(a, 10)(inside(a))
    voltage = stream(log, "vbat")
    heights = None
    ground = log.meta.get("environment", {}).get("ground_z_m")
    if p is not None and turn is not None and ground is not None:
        hubs = np.stack([turn.apply(hub)[:, 2] for hub in vehicle.hub], axis=1)
        heights = even(p, 10)(inside(p))[:, 2:] - ground + hubs
    return Motion(time_s, turn.inv().apply(velocity(inside(v if v is not None else p))) if velocity is not None and turn is not None else None,
                  rate, angular, specific, heights, None if voltage is None else np.interp(time_s, voltage[0], voltage[1][:, 0]))


# ---- wrench of the rotors ---------------------------------------------------------------------------------------------

LATENCY = {"motor_lag": "time_constant", "actuation_delay": "delay"}      # to first order both are a time by which thrusts are late


def mixer(vehicle, shift=(0.0, 0.0, 0.0)):
    """(4, N): thrusts → [force along z, torque about x, y, z] for a centre of mass moved by `shift`."""
    hub = vehicle.hub - np.asarray(shift)
    return np.stack([np.ones(len(hub)), hub[:, 1], -hub[:, 0], -vehicle.direction * vehicle.torque_ratio])


def hub_velocity(vehicle, motion):
    return motion.velocity_B[:, None, :] + np.cross(motion.rate_B[:, None, :], vehicle.hub[None]) if motion.rate_B is not None \
        else np.repeat(motion.velocity_B[:, None, :], len(vehicle.hub), axis=1)


def wrench(vehicle, motion, thrust, effect=None, values=None):
    """(n, 4) of thrusts that the file gives, with one effect in place."""
    lift, drag_torque, shift, values = thrust, thrust, (0.0, 0.0, 0.0), values or {}
    number = lambda name: values.get(name, 0.0)
    if effect == "thrust_scale":
        lift = drag_torque = thrust * (1 + number("delta"))
    elif effect == "rotor_loss":
        keep = np.ones(thrust.shape[1])
        keep[int(values["rotor"]) - 1] = 1 - number("loss")
        lift = drag_torque = thrust * keep
    elif effect == "thrust_curve":
        lift = drag_torque = thrust * (1 + number("curvature") * (thrust / (vehicle.weight / len(vehicle.hub)) - 1))
    elif effect == "battery_sag":
        left = (motion.voltage_V / vehicle.voltage) ** number("exponent") if "exponent" in values \
            else 1 - number("rate") * (motion.time_s - motion.time_s[0])
        lift = drag_torque = thrust * left[:, None]
    elif effect == "axial_inflow":
        speed = np.sqrt(np.maximum(thrust, 0) / vehicle.thrust)
        lift = thrust - number("at_hover") / (len(vehicle.hub) * vehicle.hover_speed) * speed * hub_velocity(vehicle, motion)[:, :, 2]
    elif effect == "translational_lift":
        lift = thrust + number("coefficient") * np.sum(hub_velocity(vehicle, motion)[:, :, :2] ** 2, axis=2)
    elif effect == "ground_effect":
        lift = thrust * (1 + number("strength") * (vehicle.radius / (4 * np.maximum(motion.height_m, vehicle.radius))) ** 2)
    elif effect == "yaw_torque_ratio":
        drag_torque = thrust * (1 + number("delta"))
    elif effect in LATENCY:
        late_s = number(LATENCY[effect])
        lift = drag_torque = thrust - late_s * np.gradient(low_pass(motion.time_s, thrust, 15), motion.time_s, axis=0)
    elif effect == "center_of_mass":
        shift = tuple(number(axis) for axis in "xyz")
    matrix = mixer(vehicle, shift)
    return np.concatenate([lift @ matrix[:3].T, drag_torque @ matrix[3:].T], axis=1)


def needed_besides(vehicle, motion, effect, values):
    """(n, 4): what the same motion of the centre of mass takes besides, because mass properties are others."""
    more = np.zeros((len(motion.time_s), 4))
    if effect == "inertia":
        extra = vehicle.inertia * np.array([values.get(f"delta_{axis}", 0.0) for axis in "xyz"])
        more[:, 1:] = extra * motion.angular_B + np.cross(motion.rate_B, extra * motion.rate_B)
    elif effect == "mass":
        more[:, 0] = vehicle.mass * values["delta"] * motion.specific_B[:, 2]
    return more


def thrusts_with(vehicle, motion, thrust, effect, values, passes=12):
    """Thrusts (as the file would give them) that produce the recorded motion with the effect in place."""
    wanted = wrench(vehicle, motion, thrust) + needed_besides(vehicle, motion, effect, values)
    back, changed = np.linalg.pinv(mixer(vehicle)), thrust
    for _ in range(passes):
        changed = np.clip(changed + (wanted - wrench(vehicle, motion, changed, effect, values)) @ back.T, 0.0, 10 * vehicle.weight)
    return changed


def conceals(vehicle, motion, thrust, effect, values):
    """Whether there are such thrusts: their force along z is what it must be, within 2 % of the weight in 99 of 100 samples. A curve that
    bends down gives no more beyond its top."""
    wanted = wrench(vehicle, motion, thrust) + needed_besides(vehicle, motion, effect, values)
    given = wrench(vehicle, motion, thrusts_with(vehicle, motion, thrust, effect, values), effect, values)
    return bool(np.quantile(np.abs(given - wanted)[:, 0], 0.99) < 0.02 * vehicle.weight)


def signature(vehicle, motion, thrust, effect, values):
    """(n, 4): wrench that is missing when the effect is there and the file does not know it, per `values`."""
    return wrench(vehicle, motion, thrust, effect, values) - wrench(vehicle, motion, thrust) - needed_besides(vehicle, motion, effect, values)


# ---- inputs ↔ thrusts -------------------------------------------------------------------------------------------------

def thrust_of(inputs, actuator, vehicle):
    """(n, N) [N] of recorded inputs; a collective thrust is shared alike."""
    if actuator == "rotor_speed":
        return vehicle.thrust * inputs**2
    if actuator == "thrust":
        return inputs.copy()
    if actuator == "collective_thrust":
        return np.repeat(inputs / len(vehicle.thrust), len(vehicle.thrust), axis=1)
    if vehicle.pwm_thrust:
        c = vehicle.pwm_thrust
        return c[0] + c[1] * inputs + c[2] * inputs**2
    return vehicle.thrust * (vehicle.pwm["slope"] * inputs + vehicle.pwm["offset"]) ** 2


def inputs_of(thrust, actuator, vehicle):
    """The inverse of thrust_of."""
    if actuator == "rotor_speed":
        return np.sqrt(thrust / vehicle.thrust)
    if actuator == "thrust":
        return thrust
    if actuator == "collective_thrust":
        return thrust.sum(axis=1, keepdims=True)
    if vehicle.pwm_thrust:
        c = vehicle.pwm_thrust
        return (-c[1] + np.sqrt(np.maximum(c[1] ** 2 - 4 * c[2] * (c[0] - thrust), 0))) / (2 * c[2])
    return (np.sqrt(thrust / vehicle.thrust) - vehicle.pwm["offset"]) / vehicle.pwm["slope"]


# ---- how much of an effect is visible ---------------------------------------------------------------------------------

def missing(vehicle, motion, thrust):
    """(n, 4): wrench of the recorded motion less that of the inputs; NaN columns where the log does not tell."""
    rest = np.full((len(motion.time_s), 4), np.nan)
    if motion.specific_B is not None:
        rest[:, 0] = vehicle.mass * motion.specific_B[:, 2]
    if motion.angular_B is not None:
        rest[:, 1:] = vehicle.inertia * motion.angular_B + np.cross(motion.rate_B, vehicle.inertia * motion.rate_B)
    return rest - wrench(vehicle, motion, thrust)


def state_of(motion):
    """What drag and its moments follow: [(n, 3)] that the log has."""
    return [x for x in (motion.velocity_B, motion.rate_B) if x is not None] + ([motion.velocity_B**2] if motion.velocity_B is not None else [])


def remainder(vehicle, motion, thrust):
    """(n, 4): what is missing below 5 Hz, less what the inputs' own scale, velocity and rate explain."""
    given, rest = wrench(vehicle, motion, thrust), missing(vehicle, motion, thrust)
    state = state_of(motion)
    for k in np.flatnonzero(np.isfinite(rest).all(axis=0)):
        known = np.column_stack([np.ones(len(rest)), given[:, k], *state])
        rest[:, k] = low_pass(motion.time_s, rest[:, k] - known @ np.linalg.lstsq(known, rest[:, k], rcond=None)[0], 5)
    return rest


CORRELATION_S = 0.5          # of what remains of the wrench: its samples count once in this time
# these are seen by what is constant, too; any other effect only by what a scale of each channel (thrust, inertia) and constant torques leave
TRIM = ("thrust_scale", "mass", "rotor_loss", "center_of_mass", "yaw_torque_ratio", "inertia")
# channels of the wrench in which flights show by themselves how large a trim is; for inertia and yaw torque noise of the inputs hides it
SHOWN_IN = {"thrust_scale": [0], "mass": [0], "rotor_loss": [0, 1, 2], "center_of_mass": [1, 2], "inertia": [], "yaw_torque_ratio": []}


def scales_of(effect, values):
    """(4,): by which share each channel's wrench is another one, of an effect that is that and no more; else None."""
    if effect == "yaw_torque_ratio":
        return np.array([0.0, 0.0, 0.0, values["delta"]])
    return np.array([0.0, *(values.get(f"delta_{axis}", 0.0) for axis in "xyz")]) if effect == "inertia" else None


def beside_trims(effect, given, values):
    """`values` (n, 4) less what a scale of each channel's own wrench and constant torques explain; those of a trim as they are."""
    left = values.copy()
    for k in [] if effect in TRIM else np.flatnonzero(np.isfinite(values).all(axis=0)):
        known = given[:, :1] if k == 0 else np.column_stack([given[:, k], np.ones(len(given))])
        left[:, k] -= known @ np.linalg.lstsq(known, values[:, k], rcond=None)[0]
    return left


def told_of_scale(vehicle, motion, thrust):
    """(4,): information on the scale of each channel's wrench, N r²/(1 − r²), where r is the correlation of what the inputs give and what the
    motion needs, below 5 Hz, beside velocity and rate. Inputs have noise: of a channel in which they do not go with the motion nothing is told."""
    given, told = wrench(vehicle, motion, thrust), np.zeros(4)
    needed = missing(vehicle, motion, thrust) + given
    known = np.column_stack([np.ones(len(given)), *state_of(motion)])
    independent = (motion.time_s[-1] - motion.time_s[0]) / CORRELATION_S
    for k in np.flatnonzero(np.isfinite(needed).all(axis=0) & (np.ptp(given, axis=0) > 0) & (np.ptp(needed, axis=0) > 0)):
        both = low_pass(motion.time_s, np.column_stack([given[:, k], needed[:, k]]), 5)
        r = np.corrcoef((both - known @ np.linalg.lstsq(known, both, rcond=None)[0]).T)[0, 1]
        told[k] = independent * max(r, 0.0)**2 / (1 - r**2)
    return told


def standard_error(vehicle, flights, effect, unit):
    """Standard error of an effect's size, in units of `unit`, against what remains of the wrench as noise. flights: [(motion, thrust)]."""
    information = 0.0
    for motion, thrust in flights:
        if (scales := scales_of(effect, unit)) is not None:
            information += np.sum(scales**2 * told_of_scale(vehicle, motion, thrust))
            continue
        rest = remainder(vehicle, motion, thrust)
        shape, given = (low_pass(motion.time_s, values, 5) for values in (signature(vehicle, motion, thrust, effect, unit), wrench(vehicle, motion, thrust)))
        shape = beside_trims(effect, given, shape)
        good = np.isfinite(rest).all(axis=0)
        once = CORRELATION_S / np.median(np.diff(motion.time_s))
        information += np.sum(shape[:, good] ** 2 / np.var(rest[:, good], axis=0)) / once
    return 1.0 / np.sqrt(information) if information > 0 else np.inf


def sizes_shown(vehicle, flights, effect, unit):
    """[(size, weight)] of an effect that each flight shows by itself, in units of `unit`: least squares of what is missing of the wrench, of a
    trim below 1 Hz, of others below 5 Hz, every channel weighted by what remains of it; empty where no channel shows it. A flight's weight is
    the information that it has. flights: [(motion, thrust)]."""
    sizes = []
    for motion, thrust in flights:
        all_of = (signature(vehicle, motion, thrust, effect, unit), missing(vehicle, motion, thrust), wrench(vehicle, motion, thrust))
        shape, rest, given = (low_pass(motion.time_s, values, 1 if effect in TRIM else 5) for values in all_of)
        noise = remainder(vehicle, motion, thrust)
        channels = [k for k in SHOWN_IN.get(effect, range(4)) if np.isfinite(rest[:, k]).all()]
        if channels:
            shape, rest = (beside_trims(effect, given, values)[:, channels] / noise[:, channels].std(axis=0) for values in (shape, rest))
            sizes.append((np.sum(shape * rest) / np.sum(shape**2), np.sum(shape**2)))
    return sizes


def spread(sizes):
    """Standard deviation of [(size, weight)] between flights; 0 of fewer than two."""
    if len(sizes) < 2:
        return 0.0
    size, weight = np.array(sizes).T
    mean = np.average(size, weights=weight)
    return float(np.sqrt(np.average((size - mean) ** 2, weights=weight) * len(size) / (len(size) - 1)))


# ---- what sensors and clocks show by themselves ---------------------------------------------------------------------------

def fitted(shape, rest):
    """Size of a shape (n, k) in what is left (n, k)."""
    return float(np.sum(shape * rest) / np.sum(shape**2))


def turning(log, cut_Hz=5.0):
    """(time_s (n,), rate by the attitude, rate by the gyroscope (n, 3)), rad/s, each less its mean; None without one of them."""
    attitude, gyro = stream(log, "qx", "qy", "qz", "qw"), stream(log, "wx", "wy", "wz")
    if attitude is None or gyro is None:
        return None
    turn = Rotation.from_quat(attitude[1])
    rate = (turn[:-1].inv() * turn[1:]).as_rotvec() / np.diff(attitude[0])[:, None]
    middle = 0.5 * (attitude[0][1:] + attitude[0][:-1])
    times = np.arange(max(middle[0], gyro[0][0]), min(middle[-1], gyro[0][-1]), 0.01)
    seen = [low_pass(times, np.column_stack([np.interp(times, t, column) for column in values.T]), cut_Hz) for t, values in ((middle, rate), gyro)]
    return (times, *(values - values.mean(axis=0) for values in seen))


def of_gyro_scale(log, vehicle, axis):
    """The gyroscope against the attitude's rate, which has the noise."""
    _, by_attitude, gyro = turning(log)
    return float(np.sum(gyro**2) / np.sum(by_attitude * gyro) - 1.0)


def of_pose_delay(log, vehicle, axis):
    """The attitude's rate is that of the gyroscope, later."""
    times, by_attitude, gyro = turning(log)
    return fitted(-np.gradient(gyro, times, axis=0), by_attitude - gyro)


def of_yaw_offset(log, vehicle, axis):
    """The attitude's rate is that of the gyroscope, in axes that are turned about z."""
    _, by_attitude, gyro = turning(log)
    return fitted(np.column_stack([gyro[:, 1], -gyro[:, 0]]), (by_attitude - gyro)[:, :2])


def sideways(log, vehicle):
    """Specific force below 2 Hz, m/s²: (to the sides of the body (n, 2), less what goes with the velocity's changes; along z (n,))."""
    time_s = log.column["time_s"]
    motion = motion_at(log, vehicle, np.arange(time_s[0], time_s[-1], 0.02))
    side, known = motion.specific_B[:, :2], motion.velocity_B[:, :2] - motion.velocity_B[:, :2].mean(axis=0)
    side = side - known * (np.sum(known * side, axis=0) / np.sum(known**2, axis=0))
    return low_pass(motion.time_s, side, 2), motion.specific_B[:, 2]


def of_attitude_offset(log, vehicle, axis):
    """Rotors push along the body's z: what pushes to the side is an attitude that is off (or a wind)."""
    side, up = sideways(log, vehicle)
    return fitted(up[:, None], -side[:, :1] if axis == "y" else side[:, 1:])


def of_imu_lever(log, vehicle, axis):
    """What an accelerometer at one side feels beside the origin's specific force, without its bias."""
    a, w = stream(log, "ax", "ay", "az"), stream(log, "wx", "wy", "wz")
    times = np.arange(a[0][0], a[0][-1], 0.01)
    rates = even(w, 15)
    rate, turn, arm = rates(times), rates.derivative()(times), np.eye(3)["xyz".index(axis)]
    felt = np.cross(turn, arm) + np.cross(rate, np.cross(rate, arm))
    motion = motion_at(log, vehicle, times)
    rest = even(a, 15)(times) - motion.specific_B
    shape, rest = (low_pass(times, values - values.mean(axis=0), 10) for values in (felt, rest))
    return fitted(shape, rest)


# (log, vehicle, axis) → size that a recording shows by itself
SEEN_BY_SENSORS = {"gyro_scale": of_gyro_scale, "pose_delay": of_pose_delay, "yaw_offset": of_yaw_offset, "attitude_offset": of_attitude_offset,
                   "imu_lever": of_imu_lever}
