"""Checks between columns: quaternion, frames, signs, units and time offsets, each against an independent column."""

import itertools

import numpy as np

from .checks_columns import say
from .flight import MAX_NORM_ERROR, Flight
from .rotations import body_rate, conjugate, rotate
from .signals import agreement, band, boxcar, filled

REACH_s = 0.2           # largest time offset that is looked for
STRETCH_s = 4.0         # offsets are measured on stretches of this length, half overlapping
JUMP_s = 0.02           # spread of the offsets from which they are called not constant
LAG_JUMP_s = 0.06       # the same across a motor, whose lag alone spreads by 40 ms with the frequency of the commands
TRUSTED = 0.6           # correlation from which a stretch's offset counts
CLEARLY = 0.3           # by how much another reading must correlate better to be called right
STANDARD_GRAVITY = 9.80665  # m/s^2, CGPM 1901
ATTITUDE, RATE, FORCE = ("qw", "qx", "qy", "qz"), ("wx", "wy", "wz"), ("ax", "ay", "az")
POSITION, VELOCITY = ("px", "py", "pz"), ("vx", "vy", "vz")


def check_motion(flight: Flight) -> None:
    """Runs every check of this module; normalises quaternions and removes their sign flips."""
    quaternion(flight)
    attitude_against_rate(flight)
    velocity_against_position(flight)
    specific_force(flight)
    if not any(f.severity == "error" and f.kind in ("sign", "frame") for f in flight.findings):
        offsets(flight)
        actuation_offset(flight)


def quaternion(flight: Flight) -> None:
    """|q| and sign flips: repaired when that needs no guess."""
    q = flight.block(*ATTITUDE)
    if q is None:
        return
    norm = np.linalg.norm(q, axis=1)
    bad = np.flatnonzero(np.abs(norm - 1.0) > MAX_NORM_ERROR)
    if len(bad):
        say(flight, "inconsistent", ATTITUDE, (bad[0], bad[-1]), "error",
            f"|q| is {norm[bad[0]]:.4f} at {flight.where(bad[0], 'qw')} and off by more than {MAX_NORM_ERROR} in "
            f"{len(bad)} rows: these columns are no unit quaternion")
        return
    off = float(np.nanmax(np.abs(norm - 1.0)))
    if off > 1e-5:
        say(flight, "inconsistent", ATTITUDE, (0, len(q) - 1), "note", f"|q| is off by up to {off:.1e}: normalised", True)
        q = q / norm[:, None]
    turn = np.nansum(q[1:] * q[:-1], axis=1)
    flips = np.flatnonzero(turn < 0.0)
    if len(flips):
        say(flight, "sign", ATTITUDE, (flips[0], flips[-1] + 1), "note",
            f"the quaternion changes its sign {len(flips)} times (the same attitude): made continuous", True)
        q = q * np.concatenate([[1.0], np.cumprod(np.where(turn < 0.0, -1.0, 1.0))])[:, None]
    for k, name in enumerate(ATTITUDE):
        flight.columns[name] = q[:, k]


def _readings(q: np.ndarray, rate: np.ndarray):
    """(what it would mean, q, rate) of the mistakes that are made with attitudes and rates."""
    yield "", q, rate
    for order, name in (((1, 2, 3, 0), "the other quaternion order"), ((3, 0, 1, 2), "the other quaternion order")):
        yield name, q[:, order], rate
        yield name + " and world to body", conjugate(q[:, order]), rate
    yield 'rotates = "world_to_body"', conjugate(q), rate
    yield 'a body rate given in the world (frame = "world")', q, rotate(conjugate(q), rate)
    for signs in itertools.product((1.0, -1.0), repeat=3):
        if -1.0 in signs:
            axes = ", ".join(name for name, sign in zip(RATE, signs) if sign < 0.0)
            body = " (a body frame with y right and z down)" if signs == (1.0, -1.0, -1.0) else ""
            yield f"the opposite sign of {axes}{body}", q, rate * np.array(signs)


def attitude_against_rate(flight: Flight) -> None:
    """Does the attitude turn as the body rate says? Which reading of the columns would make it so?"""
    q, rate = flight.block(*ATTITUDE), flight.block(*RATE)
    if q is None or rate is None or any(f.severity == "error" and f.column == ",".join(ATTITUDE) for f in flight.findings):
        return
    q, rate, step = filled(q), filled(rate), flight.step_s()
    reach, found = round(REACH_s / step), []
    for meaning, q_read, rate_read in _readings(q, rate):
        turned = body_rate(q_read / np.maximum(np.linalg.norm(q_read, axis=1, keepdims=True), 1e-9), flight.time_s)
        found.append((*agreement(band(turned, step), band(rate_read, step), reach), meaning))
    correlation, _, gain, _ = found[0]
    best = max(found[1:], key=lambda entry: entry[0])
    rows, columns = (0, len(q) - 1), ATTITUDE + RATE
    if best[0] > max(correlation + CLEARLY, TRUSTED):
        kind = "sign" if "sign" in best[3] else "frame"
        say(flight, kind, columns, rows, "error",
            f"the quaternion contradicts the body rate (correlation {correlation:.2f}); they agree ({best[0]:.2f}) with "
            f"{best[3]}: correct the map")
    elif correlation < 0.5 and np.std(band(rate, step)) > 0.2 and best[0] < TRUSTED:
        say(flight, "inconsistent", columns, rows, "warning",
            f"the quaternion and the body rate hardly agree (correlation {correlation:.2f}), and no other order, frame or "
            "sign helps")
    elif correlation > 0.5 and not 0.1 < gain < 10.0:
        unit = 'degrees: unit = "deg/s"' if gain > 1.0 else 'radians: unit = "rad/s"'
        say(flight, "unit", RATE, rows, "error",
            f"the body rate is {gain:.3g} times the rate at which the attitude turns: it is in {unit}")
    elif correlation > 0.95 and not 0.9 < gain < 1.1:
        say(flight, "inconsistent", RATE, rows, "warning",
            f"the body rate is {gain:.3f} times the rate at which the attitude turns")
    upright(flight, q)


def upright(flight: Flight, q: np.ndarray) -> None:
    up = float(np.mean(1.0 - 2.0 * (q[:, 1] ** 2 + q[:, 2] ** 2)))
    if up < 0.3 and not any(f.severity == "error" for f in flight.findings):
        say(flight, "frame", ATTITUDE, (0, len(q) - 1), "error",
            f"the vehicle's z axis points {np.degrees(np.arccos(np.clip(up, -1, 1))):.0f} deg away from up on average: "
            "wrong quaternion order, or frames with z down")


def velocity_against_position(flight: Flight) -> None:
    """Is the velocity the derivative of the position, in which frame, unit and sign?"""
    position, velocity = flight.block(*POSITION), flight.block(*VELOCITY)
    if position is None or velocity is None:
        return
    step, q = flight.step_s(), flight.block(*ATTITUDE)
    rows, reach = (0, len(position) - 1), round(REACH_s / step)
    moved = boxcar(np.gradient(filled(position), flight.time_s, axis=0), round(0.05 / step))
    velocity = boxcar(filled(velocity), round(0.05 / step))
    if np.std(moved) < 0.05:
        return

    def misfit(candidate):
        """Relative error after the best shift and scale, that shift, and the scale."""
        correlation, lag, gain = agreement(moved, candidate, reach)
        return np.sqrt(max(0.0, 1.0 - correlation ** 2)) if correlation > 0.0 else 1.0, lag, gain

    own, _, gain = misfit(velocity)
    readings = [("in the opposite sign of " + ", ".join(n for n, s in zip(VELOCITY, signs) if s < 0.0),
                 velocity * np.array(signs)) for signs in itertools.product((1.0, -1.0), repeat=3) if -1.0 in signs]
    readings.append(("with x and y exchanged and z down (north-east-down)", velocity[:, (1, 0, 2)] * np.array([1, 1, -1])))
    if q is not None:
        readings += [('in the body frame: frame = "body"', rotate(filled(q), velocity)),
                     ('already in the world frame: frame = "world"', rotate(conjugate(filled(q)), velocity))]
    best = min(((misfit(values)[0], meaning) for meaning, values in readings), key=lambda entry: entry[0])
    if own > 0.15 and best[0] < 0.5 * own:
        say(flight, "sign" if "sign" in best[1] else "frame", VELOCITY, rows, "error",
            f"the velocity is not the derivative of the position (misfit {100 * own:.0f} %); it is ({100 * best[0]:.0f} %) "
            f"when read {best[1]}: correct the map")
    elif own > 0.5:
        say(flight, "inconsistent", VELOCITY, rows, "warning",
            f"the velocity is not the derivative of the position (misfit {100 * own:.0f} %), and no other frame or sign helps")
    elif not 0.2 < gain < 5.0:
        say(flight, "unit", VELOCITY, rows, "error",
            f"the velocity is {gain:.3g} times the derivative of the position: wrong unit")
    else:
        scale(flight, moved, velocity, reach)


def scale(flight: Flight, moved: np.ndarray, velocity: np.ndarray, reach: int) -> None:
    off = []
    for k, name in enumerate(VELOCITY):
        correlation, _, gain = agreement(moved[:, k:k + 1], velocity[:, k:k + 1], reach)
        if correlation > 0.95 and abs(gain - 1.0) > 0.03 and np.std(moved[:, k]) > 0.05:
            off.append(f"{name} {gain:.3f}")
    if off:
        say(flight, "inconsistent", VELOCITY, (0, len(moved) - 1), "warning",
            f"the velocity is a multiple of the derivative of the position: {', '.join(off)} (two estimators, or a scale)")


def specific_force(flight: Flight) -> None:
    """Unit and sign from gravity: over a flight the accelerometer reads about +9.81 m/s^2 along body z."""
    force = flight.block(*FORCE)
    if force is None:
        return
    force, rows = filled(force), (0, len(force) - 1)
    size, up = float(np.median(np.linalg.norm(force, axis=1))), float(np.median(force[:, 2]))
    ratio = size / STANDARD_GRAVITY
    if 0.08 < ratio < 0.13:
        say(flight, "unit", FORCE, rows, "error", f"the specific force is {size:.3g} in hover, not 9.81 m/s^2: it is in g, "
            'unit = "g"')
    elif 8.0 < ratio < 12.0:
        say(flight, "unit", FORCE, rows, "error", f"the specific force is {size:.3g} in hover, not 9.81 m/s^2: it is in "
            'm/s^2 already, unit = "m/s^2"')
    elif ratio < 0.3:
        say(flight, "inconsistent", FORCE, rows, "error",
            f"the specific force is {size:.3g} m/s^2 in hover: gravity was removed, so this is an acceleration")
    elif up < -0.5 * STANDARD_GRAVITY:
        say(flight, "sign", FORCE, rows, "error",
            f"the specific force reads {up:.2f} m/s^2 along z in hover, not +9.81: z down, or the sign of gravity")
    elif not 0.85 < ratio < 1.15:
        say(flight, "inconsistent", FORCE, rows, "warning",
            f"the median specific force is {size:.2f} m/s^2, {ratio:.2f} times gravity")


def offsets(flight: Flight) -> None:
    """Time offsets between streams, per stretch: a constant one is a fact, one that jumps is a fault."""
    q, step = flight.block(*ATTITUDE), flight.step_s()
    rate, velocity, position = flight.block(*RATE), flight.block(*VELOCITY), flight.block(*POSITION)
    force, pairs = flight.block(*FORCE), []
    if q is not None and rate is not None:
        pairs.append(("body rate", RATE, "attitude", body_rate(filled(q), flight.time_s), filled(rate), JUMP_s))
    if position is not None and velocity is not None:
        pairs.append(("velocity", VELOCITY, "position", np.gradient(filled(position), flight.time_s, axis=0),
                      filled(velocity), JUMP_s))
    if force is not None:
        thrust = np.mean(filled(flight.block(*flight.actuator_names)), axis=1, keepdims=True)
        pairs.append(("vertical specific force", ("az",), "actuator input (motor lag included)", thrust,
                      filled(force)[:, 2:], LAG_JUMP_s))
    for late, columns, than, first, second, jump_s in pairs:
        found = _stretch_offsets(flight, band(first, step), band(second, step), step)
        if not found:
            continue
        values = np.array([offset for _, _, offset in found])
        low, high, middle = values.min(), values.max(), float(np.median(values))
        if high - low > max(2.0 * step, jump_s) and len(values) > 1:
            worst = found[int(np.argmax(np.abs(values - middle)))]
            say(flight, "delay", columns, (0, len(first) - 1), "warning",
                f"{late} against {than}: the time offset is not constant, {1e3 * low:.0f} to {1e3 * high:.0f} ms over "
                f"{len(values)} stretches (median {1e3 * middle:.0f} ms; {1e3 * worst[2]:.0f} ms at {worst[0]:.0f} to "
                f"{worst[1]:.0f} s)")
        elif abs(middle) > 0.25 * step:
            say(flight, "delay", columns, (0, len(first) - 1), "note",
                f"{late} is {1e3 * abs(middle):.1f} ms {'later' if middle > 0 else 'earlier'} than {than} "
                f"({1e3 * low:.0f} to {1e3 * high:.0f} ms over {len(values)} stretches)")


def _stretch_offsets(flight: Flight, a: np.ndarray, b: np.ndarray, step: float) -> list:
    """(from_s, to_s, offset_s) of the stretches without a gap in which the two agree."""
    rows, out = round(STRETCH_s / step), []
    for first in range(0, len(a) - rows + 1, max(1, rows // 2)):
        part = slice(first, first + rows)
        time_s = flight.time_s[part]
        if time_s[-1] - time_s[0] > 1.05 * STRETCH_s:
            continue
        correlation, lag, _ = agreement(a[part], b[part], round(REACH_s / step))
        if correlation > TRUSTED and abs(lag) < 0.98 * REACH_s / step:
            out.append((time_s[0], time_s[-1], lag * step))
    return out


def actuation_offset(flight: Flight) -> None:
    """Time from the actuator inputs to the roll and pitch acceleration: the shift at which a linear mix fits best.

    The mix is fitted, so that neither rotor order nor geometry has to be known. Lag of the motors is included.
    """
    rate = flight.block(*RATE)
    inputs = flight.block(*flight.actuator_names)
    if rate is None or inputs.shape[1] < 3:
        return
    step = flight.step_s()
    stride = max(1, round(0.0025 / step))
    turned = band(np.gradient(filled(rate)[:, :2], flight.time_s, axis=0), step)
    inputs, reach = band(filled(inputs), step), round(REACH_s / step)
    middle, explained, shifts = turned[reach:-reach], [], range(-reach // 2, reach + 1, stride)
    if len(middle) < 200 or not middle.any():
        return
    for shift in shifts:
        part = inputs[reach - shift:len(inputs) - reach - shift]
        mix = np.linalg.lstsq(part, middle, rcond=None)[0]
        explained.append(1.0 - np.sum((middle - part @ mix) ** 2) / np.sum(middle ** 2))
    best = int(np.argmax(explained))
    if explained[best] < 0.3 or not 0 < best < len(explained) - 1:
        return
    left, top, right = explained[best - 1:best + 2]
    offset_s = (shifts[best] + 0.5 * stride * (left - right) / (left - 2.0 * top + right)) * step
    say(flight, "delay", RATE[:2], (0, len(turned) - 1), "note",
        f"roll and pitch acceleration come {1e3 * offset_s:.1f} ms after the actuator inputs (motor lag included; a linear "
        f"mix of the inputs explains {100 * top:.0f} % of them)")
