"""Checks of single columns: missing cells, ranges, frozen, held, interpolated, made-up and filtered samples."""

from pathlib import Path

import numpy as np

from .flight import Flight, step_of
from .problems import Finding
from .signals import filled, longest_run, on_a_line, quiet_above, third_difference_noise

GROUPS = {"position": ("px", "py", "pz"), "velocity": ("vx", "vy", "vz"), "attitude": ("qw", "qx", "qy", "qz"),
          "body rate": ("wx", "wy", "wz"), "specific force": ("ax", "ay", "az")}
HELD_SHARE = 0.3          # of the rows, from which a column is called held
INTERPOLATED_SHARE = 0.1
EVEN_SHARE = 0.98         # of a battery's rows on one line: nothing was interpolated
FROZEN_s = 0.5            # a sensor that stands still for longer in flight is frozen
MADE_UP_s = 0.1           # a straight line of this length at the end of a record is an extrapolation
UNUSABLE_s = 1.0          # and of this length it is no recording any more
MADE_UP_ROWS = 5          # and has at least so many samples
SAME_CLOCK = 0.9          # of the rows: a column with fewer samples may have a rate of its own
OUTSIDE_SHARE = 0.01      # of the rows outside a hard range, from which the record is not usable

# hard ranges: pwm is a 16-bit command (Crazyflie firmware); consumer gyroscopes end at 2000 deg/s = 34.9 rad/s and
# accelerometers at 16 g to 32 g; the others are far beyond any small multirotor
RANGES = {"position": (-1e4, 1e4, "m"), "velocity": (-150.0, 150.0, "m/s"), "body rate": (-70.0, 70.0, "rad/s"),
          "specific force": (-320.0, 320.0, "m/s^2"), "battery": (1.0, 100.0, "V")}
ACTUATOR_RANGES = {"pwm": (0.0, 65535.0), "throttle": (0.0, 1.0), "rotor_speed": (0.0, 2e4), "thrust": (0.0, 1e3),
                   "collective_thrust": (0.0, 1e3)}


def groups(flight: Flight) -> dict:
    """Name -> columns of the groups that the flight has, actuators and battery included."""
    found = {name: columns for name, columns in GROUPS.items() if all(c in flight.columns for c in columns)}
    found["actuators"] = tuple(flight.actuator_names)
    if "vbat" in flight.columns:
        found["battery"] = ("vbat",)
    return found


def check_columns(flight: Flight, actuator: str, non_finite: dict) -> None:
    """Runs every check of this module; adds findings, changes nothing."""
    missing(flight, non_finite)
    made_up(flight)
    for name, columns in groups(flight).items():
        time_s, values = flight.series(*columns)
        if not len(values):
            continue
        ranges(flight, name, columns, actuator)
        if not frozen(flight, name, columns, time_s, filled(values)):
            held(flight, name, columns, time_s, filled(values))
    actuators(flight, actuator)
    filtered(flight)
    repeated_rows(flight)


def say(flight: Flight, kind: str, columns, span, severity: str, text: str, repaired: bool = False) -> None:
    """Adds a finding that covers the times (first, last)."""
    flight.findings.append(Finding(kind, ",".join(columns), span[0], span[-1], severity, text, repaired))


def slower(flight: Flight, columns) -> bool:
    """Do these columns have samples at a rate of their own, with empty cells between them?"""
    if flight.own_clocks:
        return True
    time_s, _ = flight.series(*columns)
    if len(time_s) < 3 or len(time_s) > SAME_CLOCK * len(flight.time_s):
        return False
    steps = np.diff(time_s)
    return bool(np.percentile(steps, 80) <= 1.7 * np.median(steps))


def missing(flight: Flight, non_finite: dict) -> None:
    """Cells that are empty for no reason: not between the samples of a slower column, nor a whole column."""
    grouped = groups(flight)
    known = {column for columns in grouped.values() for column in columns}
    grouped.update({name: (name,) for name in flight.columns if name not in known})
    for name, columns in grouped.items():
        empty = np.isnan(flight.block(*columns))
        if flight.own_clocks and name not in GROUPS:
            continue
        if slower(flight, columns):
            empty = empty[~empty.all(axis=1)]
            rows = flight.series(*columns)[0]
        else:
            rows = flight.time_s
        holes = np.flatnonzero(empty.any(axis=1))
        if not len(holes):
            continue
        line = next((non_finite[flight.source.get(c)] for c in columns if flight.source.get(c) in non_finite), None)
        what = f"not a number or infinite (first at {Path(flight.file).name}:{line})" if line else "empty"
        severity = "error" if len(holes) > 0.5 * len(rows) and name == "actuators" else "warning"
        some = [c for c, any_empty in zip(columns, empty.any(axis=0)) if any_empty]
        say(flight, "gap", some, rows[holes[[0, -1]]], severity,
            f"{len(holes)} of {len(rows)} cells are {what}: written as no sample")


def ranges(flight: Flight, name: str, columns, actuator: str) -> None:
    time_s, values = flight.series(*columns)
    low, high, unit = RANGES.get(name, (-np.inf, np.inf, ""))
    if name == "actuators":
        low, high = ACTUATOR_RANGES[actuator]
        unit = {"rotor_speed": "rad/s", "thrust": "N", "collective_thrust": "N"}.get(actuator, actuator)
    slack = 1e-3 * (high - low) if np.isfinite(high) else 0.0
    outside = np.any((values < low - slack) | (values > high + slack), axis=1)
    if outside.any():
        rows = np.flatnonzero(outside)
        severity = "error" if outside.mean() > OUTSIDE_SHARE and name != "battery" else "warning"
        where = flight.where(int(np.searchsorted(flight.time_s, time_s[rows[0]])), columns[0])
        say(flight, "out_of_range", columns, time_s[rows[[0, -1]]], severity,
            f"{len(rows)} rows lie outside {low:g} to {high:g} {unit} (from {np.nanmin(values):.6g} to "
            f"{np.nanmax(values):.6g}; first at {where})")


def frozen(flight: Flight, name: str, columns, time_s: np.ndarray, values: np.ndarray) -> bool:
    """True when the group never changes; says so, and says stretches in which a sensor stands still."""
    same = np.all(values[1:] == values[:-1], axis=1)
    if same.all():
        severity = "warning" if name in ("battery", "specific force") else "error"
        if not (name == "actuators" and not values.any()):
            say(flight, "frozen", columns, time_s, severity,
                f"{name} never changes ({', '.join(f'{v:g}' for v in values[0])}): " +
                ("what falls with it can only be told by time" if name == "battery" else "nothing that depends on it can be told"))
        return True
    if name in ("battery", "actuators"):
        return False
    running = np.interp(time_s, *_mean_input(flight)) > 0.0
    run = longest_run(same & running[1:])
    if run and time_s[run[1] + 1] - time_s[run[0]] > FROZEN_s:
        length = time_s[run[1] + 1] - time_s[run[0]]
        severity = "error" if length > 0.2 * (time_s[-1] - time_s[0]) else "warning"
        say(flight, "frozen", columns, time_s[[run[0], run[1] + 1]], severity, f"{name} stands still for {length:.2f} s in flight")
    return False


def _mean_input(flight: Flight) -> tuple:
    """(time_s, mean over the rotors) of the actuator inputs; zero where there is none."""
    time_s, values = flight.series(*flight.actuator_names)
    return (time_s, np.maximum(np.nanmax(values, axis=1), 0.0)) if len(time_s) else (flight.time_s, 0.0 * flight.time_s)


def held(flight: Flight, name: str, columns, time_s: np.ndarray, values: np.ndarray) -> None:
    """Says when samples repeat the one before, or were interpolated, and how often there really was a new one."""
    live = np.any(values != 0.0, axis=1)[1:-1]
    if not live.any():
        return
    same = float(np.mean(np.all(values[1:-1] == values[:-2], axis=1)[live]))
    line = float(np.mean(on_a_line(time_s, values)[1:-1][live]))
    rate = 1.0 / step_of(time_s)
    if name == "battery" and line > EVEN_SHARE:
        return  # a voltage that falls evenly
    if same > HELD_SHARE or line > INTERPOLATED_SHARE:
        how = [f"repeats the row before in {100 * same:.0f} %"] if same > 0.005 else []
        how += [f"lies on a straight line between its neighbours (interpolated) in {100 * line:.0f} %"] if line > 0.005 else []
        say(flight, "held", columns, time_s, "note",
            f"{name}: {' and '.join(how)} of the rows: real samples at about {rate * (1.0 - same - line):.0f} Hz, the record "
            f"at {rate:.0f} Hz")


def made_up(flight: Flight) -> None:
    """Straight lines at the end of a record: the stream had stopped, and something extrapolated it."""
    first_s, ends, names, count = np.inf, [], [], 0
    for name, columns in groups(flight).items():
        time_s, values = flight.series(*columns)
        if name == "battery" or len(values) < MADE_UP_ROWS:
            continue
        values = filled(values)
        real = np.flatnonzero(~on_a_line(time_s, values)[:-1])
        last = real[-1] if len(real) else 0
        if time_s[-1] - time_s[last] < MADE_UP_s or len(time_s) - 1 - last < MADE_UP_ROWS:
            continue
        names.append(name)
        ends += zip(columns, values[-1])
        if time_s[last] < first_s:
            first_s, count = time_s[last], len(time_s) - 1 - last
    if not names:
        return
    length = flight.time_s[-1] - first_s
    says = (f"{', '.join(names)}: nothing was received after {first_s:.2f} s; the last {count} rows "
            f"({length:.2f} s) go on in a straight line and are no measurement")
    if length > UNUSABLE_s:
        says = (f"corrupt: {says} (at the end {', '.join(f'{c} {v:.6g}' for c, v in ends)}); what was recorded can be kept "
                f"with --to {np.floor(10.0 * first_s) / 10.0:g}")
    say(flight, "inconsistent", [c for c, _ in ends], (first_s, flight.time_s[-1]),
        "error" if length > UNUSABLE_s else "note", says)


def actuators(flight: Flight, actuator: str) -> None:
    columns = flight.actuator_names
    time_s, values = flight.series(*columns)
    values = filled(values)
    off = ~np.any(values > 0.0, axis=1)
    if off.all():
        say(flight, "ground", columns, flight.time_s, "error", "every actuator input is zero all the time")
    elif off.any():
        say(flight, "ground", columns, time_s[np.flatnonzero(off)[[0, -1]]], "note",
            f"all rotors are off in {100 * off.mean():.0f} % of the rows")
    top = ACTUATOR_RANGES[actuator][1]
    for k, column in enumerate(columns):
        full = values[:, k] >= top * (1.0 - 1e-6)
        if actuator in ("pwm", "throttle") and full.mean() > 0.005:
            say(flight, "out_of_range", (column,), time_s[np.flatnonzero(full)[[0, -1]]], "note",
                f"saturated at {top:g} in {100 * full.mean():.1f} % of the rows")


def filtered(flight: Flight) -> None:
    """Says which groups were low-pass filtered: their spectra do not end in a noise floor."""
    for name, columns in groups(flight).items():
        time_s, values = flight.series(*columns)
        values = filled(values)
        if name == "battery" or len(values) < 256 or np.all(values[1:] == values[:-1]):
            continue
        corner = np.array([quiet_above(values[:, k]) for k in range(values.shape[1])])
        if np.mean(~np.isnan(corner)) > 0.5:
            say(flight, "filtered", columns, time_s, "warning",
                f"{name}: nothing faster than about {np.nanmedian(corner) / step_of(time_s):.0f} Hz is left: low-pass filtered "
                "(its noise is not independent from sample to sample)")


def repeated_rows(flight: Flight) -> None:
    block = np.column_stack(list(flight.columns.values()))
    same = np.all((block[1:] == block[:-1]) | (np.isnan(block[1:]) & np.isnan(block[:-1])), axis=1)
    same &= (~np.isnan(block[1:])).sum(axis=1) > 1
    same &= np.interp(flight.time_s, *_mean_input(flight))[1:] > 0.0
    rows = np.flatnonzero(same)
    if len(rows):
        say(flight, "duplicate", ("time_s",), (flight.time_s[rows[0]], flight.time_s[rows[-1] + 1]), "warning",
            f"{len(rows)} rows repeat every value of the row before at a new time")


def noise(flight: Flight) -> dict:
    """Column -> standard deviation of its noise from third differences, for the report."""
    return {column: third_difference_noise(flight.columns[column])
            for name, columns in groups(flight).items() if name not in ("actuators", "battery") for column in columns}
