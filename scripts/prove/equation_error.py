"""Equation error: m a − thrust and J dω/dt − torque along a flight, and what each effect of the catalogue would add.

This is what sparse identification of a discrepancy usually starts from. Every column is the derivative of force and torque
(body axes) with respect to one parameter, at the nominal vehicle.
"""

import numpy as np
from scipy.signal import savgol_filter
from scipy.spatial.transform import Rotation

POSE_WINDOW_s, RATE_WINDOW_s = 0.19, 0.09  # of the local polynomials, as for our own linearisation point
AIR_kgpm3 = 1.225


def local_polynomial(y, dt, window_s, degree, derivative):
    """The derivative of the least-squares polynomial around each sample (Savitzky-Golay); beyond the ends the first and the last value stay."""
    half = max(degree, round(0.5 * window_s / dt))
    return savgol_filter(y, 2 * half + 1, degree, deriv=derivative, delta=dt, axis=0, mode="nearest")


def rotations(q):
    return Rotation.from_quat(q[:, [1, 2, 3, 0]]).as_matrix()


def first_order(command, dt, up, down):
    speed = np.empty_like(command)
    state = command[0].copy()
    for k, wanted in enumerate(command):
        # the command is held from its time stamp on, and the speed at that time does not know it yet
        tau = np.where(wanted > state, up, down)
        after = wanted + (state - wanted) * np.exp(-dt / np.maximum(tau, 1e-9))
        speed[k] = state if up > 0 else wanted
        state = after
    return speed


def late(signal, dt, delay):
    t = np.arange(len(signal)) * dt
    return np.column_stack([np.interp(t - delay, t, signal[:, k]) for k in range(signal.shape[1])])


def smooth_alike(wrench, dt):
    """What the differentiation of velocity and rate does to an acceleration, done to a wrench (n, 6)."""
    total = np.cumsum(wrench, axis=0) * dt
    total -= 0.5 * dt * wrench
    return np.hstack([local_polynomial(total[:, :3], dt, POSE_WINDOW_s, 3, 1), local_polynomial(total[:, 3:], dt, RATE_WINDOW_s, 2, 1)])


class Equations:
    """Residual (n, 6) of one flight in N and N m, and columns {(effect, parameter): (n, 6)}."""

    def __init__(self, log, vehicle, command):
        self.log, self.vehicle = log, vehicle
        self.own = {e["type"]: e for e in vehicle.effects}
        t = log.column["time_s"]
        self.dt = dt = float(np.median(np.diff(t)))
        self.t = t - t[0]
        self.R = rotations(log.stack("qw", "qx", "qy", "qz"))
        self.position = log.stack("px", "py", "pz")
        velocity = log.stack("vx", "vy", "vz")
        if velocity is None:
            velocity = local_polynomial(self.position, dt, POSE_WINDOW_s, 3, 1)
            acceleration = local_polynomial(self.position, dt, POSE_WINDOW_s, 3, 2)
        else:
            acceleration = local_polynomial(velocity, dt, POSE_WINDOW_s, 3, 1)
        gyro = log.stack("wx", "wy", "wz")
        self.rate = local_polynomial(gyro, dt, RATE_WINDOW_s, 2, 0)
        self.turn = local_polynomial(gyro, dt, RATE_WINDOW_s, 2, 1)
        self.specific = self.into_body(acceleration + [0, 0, 9.81])
        self.air = self.into_body(velocity)
        lag = self.own.get("motor_lag", {})
        self.lag = (lag.get("time_constant", 0.0), lag.get("time_constant_down", lag.get("time_constant", 0.0)))
        self.command, self.speed = command, first_order(command, dt, *self.lag)

    def into_body(self, vectors):
        return np.einsum("nij,ni->nj", self.R, vectors)

    def wrench_of_thrust(self, thrust, axis=(0.0, 0.0, 1.0), reaction=True):
        v, axis = self.vehicle, np.asarray(axis)
        force = thrust.sum(1)[:, None] * axis
        torque = sum(np.cross(v.hub[i], axis) * thrust[:, i:i + 1] for i in range(len(v.hub)))
        if reaction:
            torque = torque - (thrust @ v.direction)[:, None] * v.torque_ratio * axis
        return np.hstack([force, torque])

    def turning(self, inertia):
        return inertia * self.turn + np.cross(self.rate, inertia * self.rate)

    def thrust(self, speed):
        return self.vehicle.thrust * speed**2

    def residual(self):
        v = self.vehicle
        known = np.hstack([v.mass * self.specific, self.turning(v.inertia)])
        known -= smooth_alike(self.wrench_of_thrust(self.thrust(self.speed)), self.dt)
        # a centre of mass off the origin moves what was measured
        known[:, :3] += v.mass * (np.cross(self.turn, v.center) + np.cross(self.rate, np.cross(self.rate, v.center)))
        for (effect, name), column in self.columns().items():
            if effect in self.own and effect != "motor_lag" and name in self.own[effect]:
                known -= self.own[effect][name] * column
        return known

    def columns(self):
        v, n = self.vehicle, len(self.t)
        count = len(v.hub)
        zero, zeros = np.zeros((n, 3)), np.zeros((n, count))
        hub_speed = [self.air + np.cross(self.rate, v.hub[i]) for i in range(count)]
        share = self.speed / (count * v.hover_speed)
        thrust = self.thrust(self.speed)
        columns = {}

        def at_hubs(forces):
            return np.hstack([sum(forces), sum(np.cross(v.hub[i], forces[i]) for i in range(count))])

        level = [h * [1, 1, 0] for h in hub_speed]
        columns["rotor_drag", "at_hover"] = at_hubs([-share[:, i:i + 1] * level[i] for i in range(count)])
        size = np.linalg.norm(self.air, axis=1, keepdims=True)
        drag = -0.5 * AIR_kgpm3 * size * self.air
        columns["quadratic_drag", "area_xy"] = np.hstack([drag * [1, 1, 0], zero])
        columns["quadratic_drag", "area_z"] = np.hstack([drag * [0, 0, 1], zero])
        climb = np.column_stack([h[:, 2] for h in hub_speed])
        columns["axial_inflow", "at_hover"] = self.wrench_of_thrust(-share * climb, reaction=False)
        columns["translational_lift", "coefficient"] = self.wrench_of_thrust(
            np.column_stack([(h**2).sum(1) for h in level]), reaction=False)
        flap = sum(self.speed[:, i:i + 1] * np.cross(hub_speed[i], [0, 0, 1]) for i in range(count))
        columns["flapping_torque", "coefficient"] = np.hstack([zero, flap])
        self.add_surfaces(columns, thrust)
        drag_size = 0.016 * v.weight if "rotor_drag" not in self.own else self.own["rotor_drag"]["at_hover"]
        for k, name in enumerate("xyz"):
            toward = self.R[:, k, :]
            columns["constant_force", name] = np.hstack([toward, zero])
            if k < 2:
                columns["steady_wind", name] = np.hstack([drag_size * toward * [1, 1, 0], zero])
        # from the model's side (what it predicts), not from the noisy one; otherwise mass −1, thrust −1 would explain all
        predicted = self.wrench_of_thrust(thrust)
        columns["mass", "delta"] = np.hstack([-predicted[:, :3], zero])
        for k, name in enumerate("xyz"):
            e = np.eye(3)[k]
            moved = -v.mass * (np.cross(self.turn, e) + np.cross(self.rate, np.cross(self.rate, e)))
            columns["center_of_mass", name] = np.hstack([moved, -np.cross(e, thrust.sum(1)[:, None] * [0.0, 0.0, 1.0])])
            columns["inertia", f"delta_{name}"] = np.hstack([zero, -predicted[:, 3:] * e])
        columns["thrust_scale", "delta"] = predicted
        for i in range(count):
            one = zeros.copy()
            one[:, i] = -thrust[:, i]
            columns[f"rotor_loss#{i + 1}", "loss"] = self.wrench_of_thrust(one)
        columns["rotor_tilt", "x"] = self.wrench_of_thrust(thrust, (1, 0, 0))
        columns["rotor_tilt", "y"] = self.wrench_of_thrust(thrust, (0, 1, 0))
        slower = first_order(self.command, self.dt, self.lag[0] + 0.01, self.lag[1] + 0.01)
        columns["motor_lag", "time_constant"] = self.wrench_of_thrust(self.thrust(slower) - thrust) / 0.01
        columns["actuation_delay", "delay"] = self.wrench_of_thrust(late(thrust, self.dt, 0.005) - thrust) / 0.005
        columns["thrust_curve", "curvature"] = self.wrench_of_thrust(thrust * (thrust * count / v.weight - 1))
        battery = self.log.column.get("vbat")
        if battery is not None and np.isfinite(battery).all():
            nominal = v.voltage or battery.mean()
            columns["battery_sag", "exponent"] = self.wrench_of_thrust(thrust * np.log(battery / nominal)[:, None])
        else:
            columns["battery_sag", "rate"] = self.wrench_of_thrust(-thrust * self.t[:, None])
        yaw = -(thrust @ v.direction) * v.torque_ratio
        columns["yaw_torque_ratio", "delta"] = np.column_stack([np.zeros((n, 5)), yaw])
        spin = np.gradient(self.speed, self.dt, axis=0) @ v.direction
        columns["rotor_inertia", "inertia"] = np.hstack(
            [zero, -spin[:, None] * [0, 0, 1] - np.cross(self.rate, (self.speed @ v.direction)[:, None] * [0.0, 0.0, 1.0])])
        for k, name in enumerate("xyz"):
            turned = np.hstack([np.cross(predicted[:, :3], np.eye(3)[k]), zero])
            columns["attitude_offset" if k < 2 else "yaw_offset", name] = turned
        columns["pose_delay", "delay"] = np.hstack([-np.gradient(predicted[:, :3], self.dt, axis=0), zero])
        return {key: smooth_alike(column, self.dt) for key, column in columns.items()}

    def add_surfaces(self, columns, thrust):
        v, room = self.vehicle, self.log.meta.get("environment", {})
        height = self.position[:, 2:] + np.einsum("nj,ij->ni", self.R[:, 2, :], v.hub)
        for effect, key, side in (("ground_effect", "ground_z_m", 1), ("ceiling_effect", "ceiling_z_m", -1)):
            if key in room:
                distance = np.maximum(side * (height - room[key]), v.radius)
                columns[effect, "strength"] = self.wrench_of_thrust(thrust * (v.radius / (4 * distance))**2, reaction=False)
        if room.get("walls"):
            push = np.zeros((len(self.t), 3))
            for px, py, nx, ny in room["walls"]:
                distance = np.maximum((self.position[:, :2] - [px, py]) @ [nx, ny], v.radius)
                push += (thrust.sum(1) * (v.radius / distance)**2)[:, None] * [-nx, -ny, 0.0]
            columns["wall_effect", "strength"] = np.hstack([self.into_body(push), np.zeros((len(self.t), 3))])
