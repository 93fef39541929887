"""Checks between columns: quaternion, frames, signs, units and time offsets, each against an independent column."""

import itertools

import numpy as np

from .checks_columns import say
from .flight import MAX_NORM_ERROR, Flight, step_of
from .rotations import body_rate, conjugate, rotate
from .signals import agreement, band, boxcar, filled
from .streams import ATTITUDE, FORCE, POSITION, RATE, VELOCITY

REACH_s = 0.2           # largest time offset that is looked for
STRETCH_s = 4.0         # offsets are measured on stretches of this length, half overlapping
JUMP_s = 0.02           # spread of the offsets from which they are called not constant
LAG_JUMP_s = 0.06       # the same across a motor, whose lag alone spreads by 40 ms with the frequency of the commands
TRUSTED = 0.6           # correlation from which a stretch's offset counts
MULTIPLE = 0.98         # correlation from which one column may be called a multiple of another
CLEARLY = 0.3           # by how much another reading must correlate better to be called right
STANDARD_GRAVITY = 9.80665  # m/s^2, CGPM 1901
SLOWEST_s = 0.055       # samples farther apart tell no offsets between streams
FEWEST = 60             # samples that a comparison needs
LEAST_MOVED_mps = 0.05   # standard deviation, from which a velocity is compared with the position


def check_motion(flight: Flight) -> None:
    """Runs every check of this module; normalises quaternions and removes their sign flips."""
    quaternion(flight)
    attitude_against_rate(flight)
    velocity_against_position(flight)
    specific_force(flight)
    if not any(f.severity == "error" and f.kind in ("sign", "frame") for f in flight.findings):
        offsets(flight)
        actuation_offset(flight)


def paired(flight: Flight, first, second) -> tuple:
    """(time_s, a, b) of two groups on the clock of the slower, the faster averaged over its intervals; None if one is not there."""
    if flight.block(*first) is None or flight.block(*second) is None:
        return None
    (t_a, a), (t_b, b) = flight.series(*first), flight.series(*second)
    if min(len(t_a), len(t_b)) < FEWEST:
        return None
    a, b = filled(a), filled(b)
    if len(t_a) == len(t_b) and np.array_equal(t_a, t_b):
        return t_a, a, b
    time_s = t_a if step_of(t_a) >= step_of(t_b) else t_b
    time_s = time_s[(time_s >= max(t_a[0], t_b[0])) & (time_s <= min(t_a[-1], t_b[-1]))]
    if len(time_s) < FEWEST:
        return None
    return time_s, resampled(t_a, a, time_s), resampled(t_b, b, time_s)


def resampled(time_s: np.ndarray, values: np.ndarray, wanted_s: np.ndarray) -> np.ndarray:
    """Values at other times: of a faster series the mean over an interval around them."""
    if np.array_equal(time_s, wanted_s):
        return values
    half = 0.5 * step_of(wanted_s) if step_of(wanted_s) > 1.5 * step_of(time_s) else 0.0
    if half == 0.0:
        return np.column_stack([np.interp(wanted_s, time_s, column) for column in values.T])
    steps = np.diff(time_s)[:, None]
    whole = np.vstack([np.zeros((1, values.shape[1])), np.cumsum(0.5 * steps * (values[1:] + values[:-1]), axis=0)])
    ends = [np.clip(wanted_s + side * half, time_s[0], time_s[-1]) for side in (1.0, -1.0)]
    high, low = [np.column_stack([np.interp(end, time_s, column) for column in whole.T]) for end in ends]
    width = np.broadcast_to((ends[0] - ends[1])[:, None], high.shape)
    return np.divide(high - low, width, out=np.full(high.shape, np.nan), where=width > 0.0)


def as_central(values: np.ndarray) -> np.ndarray:
    """Mean of a series from the sample before to the one after (Simpson's rule), as a central difference is one."""
    out = values.copy()
    out[1:-1] = (values[:-2] + 4.0 * values[1:-1] + values[2:]) / 6.0
    return out


def _series_filled(flight: Flight, columns) -> tuple:
    time_s, values = flight.series(*columns)
    return time_s, filled(values)


def surely_off(correlation: float, gain: float, tolerance: float) -> bool:
    """Is a gain not 1, whichever of the two series is noisy? (Noise in the regressor makes a gain too small: the truth lies
    between the regression of b on a and the inverse of that of a on b; Frisch 1934, Fuller 1987, section 1.1.)"""
    low, high = sorted((gain, gain / max(correlation, 1e-9) ** 2))
    return low > 1.0 + tolerance or high < 1.0 - tolerance


def quaternion(flight: Flight) -> None:
    """|q| and sign flips: repaired when that needs no guess."""
    if flight.block(*ATTITUDE) is None:
        return
    time_s, q = flight.series(*ATTITUDE)
    rows = np.searchsorted(flight.time_s, time_s)
    norm = np.linalg.norm(q, axis=1)
    bad = np.flatnonzero(np.abs(norm - 1.0) > MAX_NORM_ERROR)
    if len(bad):
        say(flight, "inconsistent", ATTITUDE, time_s[bad[[0, -1]]], "error",
            f"|q| is {norm[bad[0]]:.4f} at {flight.where(rows[bad[0]], 'qw')} and off by more than {MAX_NORM_ERROR} in "
            f"{len(bad)} rows: these columns are no unit quaternion")
        return
    off = float(np.nanmax(np.abs(norm - 1.0)))
    if off > 1e-5:
        say(flight, "inconsistent", ATTITUDE, time_s, "note", f"|q| is off by up to {off:.1e}: normalised", True)
        q = q / norm[:, None]
    turn = np.nansum(q[1:] * q[:-1], axis=1)
    flips = np.flatnonzero(turn < 0.0)
    if len(flips):
        say(flight, "sign", ATTITUDE, (time_s[flips[0]], time_s[flips[-1] + 1]), "note",
            f"the quaternion changes its sign {len(flips)} times (the same attitude): made continuous", True)
        q = q * np.concatenate([[1.0], np.cumprod(np.where(turn < 0.0, -1.0, 1.0))])[:, None]
    for k, name in enumerate(ATTITUDE):
        flight.columns[name][rows] = q[:, k]


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
    pair = paired(flight, ATTITUDE, RATE)
    if pair is None or any(f.severity == "error" and f.column == ",".join(ATTITUDE) for f in flight.findings):
        return
    time_s, q, rate = pair
    step, found = step_of(time_s), []
    reach = round(REACH_s / step)
    for meaning, q_read, rate_read in _readings(q, rate):
        turned = body_rate(q_read / np.maximum(np.linalg.norm(q_read, axis=1, keepdims=True), 1e-9), time_s)
        found.append((*agreement(band(turned, step), band(as_central(rate_read), step), reach), meaning))
    correlation, _, gain, _ = found[0]
    best = max(found[1:], key=lambda entry: entry[0])
    columns = ATTITUDE + RATE
    if best[0] > max(correlation + CLEARLY, TRUSTED):
        kind = "sign" if "sign" in best[3] else "frame"
        say(flight, kind, columns, time_s, "error",
            f"the quaternion contradicts the body rate (correlation {correlation:.2f}); they agree ({best[0]:.2f}) with "
            f"{best[3]}: correct the map")
    elif correlation < 0.5 and np.std(band(rate, step)) > 0.2 and best[0] < TRUSTED:
        say(flight, "inconsistent", columns, time_s, "warning",
            f"the quaternion and the body rate hardly agree (correlation {correlation:.2f}), and no other order, frame or "
            "sign helps")
    elif correlation > 0.5 and not 0.1 < gain < 10.0:
        unit = 'degrees: unit = "deg/s"' if gain > 1.0 else 'radians: unit = "rad/s"'
        say(flight, "unit", RATE, time_s, "error",
            f"the body rate is {gain:.3g} times the rate at which the attitude turns: it is in {unit}")
    elif correlation > 0.95 and surely_off(correlation, gain, 0.1):
        say(flight, "inconsistent", RATE, time_s, "warning",
            f"the body rate is {gain:.3f} times the rate at which the attitude turns")
    upright(flight, time_s, q)


def upright(flight: Flight, time_s: np.ndarray, q: np.ndarray) -> None:
    up = float(np.mean(1.0 - 2.0 * (q[:, 1] ** 2 + q[:, 2] ** 2)))
    if up < 0.3 and not any(f.severity == "error" for f in flight.findings):
        say(flight, "frame", ATTITUDE, time_s, "error",
            f"the vehicle's z axis points {np.degrees(np.arccos(np.clip(up, -1, 1))):.0f} deg away from up on average: "
            "wrong quaternion order, or frames with z down")


def velocity_against_position(flight: Flight) -> None:
    """Is the velocity the derivative of the position, in which frame, unit and sign?"""
    pair = paired(flight, POSITION, VELOCITY)
    if pair is None:
        return
    rows, position, velocity = pair
    step, q = step_of(rows), flight.block(*ATTITUDE)
    if q is not None:
        q = resampled(*_series_filled(flight, ATTITUDE), rows)
        q /= np.maximum(np.linalg.norm(q, axis=1, keepdims=True), 1e-9)
    reach = round(REACH_s / step)
    moved = boxcar(np.gradient(position, rows, axis=0), round(0.05 / step))
    velocity = boxcar(as_central(velocity), round(0.05 / step))
    # in hover both say little; a position in another unit leaves only one of them small
    if np.std(moved) < LEAST_MOVED_mps and np.std(velocity) < 5.0 * LEAST_MOVED_mps or not moved.any():
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
        readings += [('in the body frame: frame = "body"', rotate(q, velocity)),
                     ('already in the world frame: frame = "world"', rotate(conjugate(q), velocity))]
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
            f"the velocity is {f'{gain:.0f}' if gain >= 100.0 else f'{gain:.3g}'} times the derivative of the position: wrong unit")
    else:
        scale(flight, rows, moved, velocity, reach)


def scale(flight: Flight, time_s: np.ndarray, moved: np.ndarray, velocity: np.ndarray, reach: int) -> None:
    off = []
    for k, name in enumerate(VELOCITY):
        correlation, _, gain = agreement(moved[:, k:k + 1], velocity[:, k:k + 1], reach)
        if correlation > MULTIPLE and surely_off(correlation, gain, 0.03) and np.std(moved[:, k]) > 0.05:
            off.append(f"{name} {gain:.3f}")
    if off:
        say(flight, "inconsistent", VELOCITY, time_s, "warning",
            f"the velocity is a multiple of the derivative of the position: {', '.join(off)} (two estimators, or a scale)")


def specific_force(flight: Flight) -> None:
    """Unit and sign from gravity: over a flight the accelerometer reads about +9.81 m/s^2 along body z."""
    if flight.block(*FORCE) is None:
        return
    rows, force = _series_filled(flight, FORCE)
    if not len(force):
        return
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
    pairs = []
    if pair := paired(flight, ATTITUDE, RATE):
        time_s, q, rate = pair
        pairs.append(("body rate", RATE, "attitude", time_s, body_rate(q, time_s), as_central(rate), JUMP_s))
    if pair := paired(flight, POSITION, VELOCITY):
        time_s, position, velocity = pair
        pairs.append(("velocity", VELOCITY, "position", time_s, np.gradient(position, time_s, axis=0), as_central(velocity), JUMP_s))
    if pair := paired(flight, flight.actuator_names, FORCE):
        time_s, inputs, force = pair
        pairs.append(("vertical specific force", ("az",), "actuator input (motor lag included)", time_s,
                      np.mean(inputs, axis=1, keepdims=True), force[:, 2:], LAG_JUMP_s))
    for late, columns, than, time_s, first, second, jump_s in pairs:
        step = step_of(time_s)
        found = _stretch_offsets(time_s, band(first, step), band(second, step), step) if step < SLOWEST_s else []
        if not found:
            continue
        values = np.array([offset for _, _, offset in found])
        low, high, middle = values.min(), values.max(), float(np.median(values))
        if high - low > max(2.0 * step, jump_s) and len(values) > 1:
            worst = found[int(np.argmax(np.abs(values - middle)))]
            say(flight, "delay", columns, time_s, "warning",
                f"{late} against {than}: the time offset is not constant, {1e3 * low:.0f} to {1e3 * high:.0f} ms over "
                f"{len(values)} stretches (median {1e3 * middle:.0f} ms; {1e3 * worst[2]:.0f} ms at {worst[0]:.0f} to "
                f"{worst[1]:.0f} s)")
        elif abs(middle) > 0.25 * step:
            say(flight, "delay", columns, time_s, "note",
                f"{late} is {1e3 * abs(middle):.1f} ms {'later' if middle > 0 else 'earlier'} than {than} "
                f"({1e3 * low:.0f} to {1e3 * high:.0f} ms over {len(values)} stretches)")


def _stretch_offsets(time_s: np.ndarray, a: np.ndarray, b: np.ndarray, step: float) -> list:
    """(from_s, to_s, offset_s) of the stretches without a gap in which the two agree."""
    rows, out = round(STRETCH_s / step), []
    for first in range(0, len(a) - rows + 1, max(1, rows // 2)):
        part = slice(first, first + rows)
        times = time_s[part]
        if times[-1] - times[0] > 1.05 * STRETCH_s:
            continue
        correlation, lag, _ = agreement(a[part], b[part], round(REACH_s / step))
        if correlation > TRUSTED and abs(lag) < 0.98 * REACH_s / step:
            out.append((times[0], times[-1], lag * step))
    return out


def actuation_offset(flight: Flight) -> None:
    """Time from the actuator inputs to the roll and pitch acceleration: the shift at which a linear mix fits best.

    The mix is fitted, so that neither rotor order nor geometry has to be known. Lag of the motors is included.
    """
    pair = paired(flight, RATE, flight.actuator_names)
    if pair is None or pair[2].shape[1] < 3 or step_of(pair[0]) > SLOWEST_s:
        return
    time_s, rate, inputs = pair
    step = step_of(time_s)
    stride = max(1, round(0.0025 / step))
    turned = band(np.gradient(rate[:, :2], time_s, axis=0), step)
    inputs, reach = band(inputs, step), round(REACH_s / step)
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
    say(flight, "delay", RATE[:2], time_s, "note",
        f"roll and pitch acceleration come {1e3 * offset_s:.1f} ms after the actuator inputs (motor lag included; a linear "
        f"mix of the inputs explains {100 * top:.0f} % of them)")
