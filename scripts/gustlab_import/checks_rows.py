"""Checks of the rows: time, duplicates, gaps, and which rows are flight."""

from pathlib import Path

import numpy as np

from .checks_columns import groups, slower
from .column_map import ColumnMap
from .flight import Flight
from .problems import DATA, USAGE, Finding, ImportFailure

GAP = 1.6               # of the median step, as the diagnosis cuts
GAP_OF_STREAM, GAP_OF_STREAM_s = 3.0, 0.1   # loggers of flight computers jitter by more than one interval
AIRBORNE_HEIGHT_m = 0.1  # above the height at rest: free of contact, and of most of the ground effect
SHORTEST_STRETCH_s = 1.0


def clean_time(flight: Flight) -> None:
    """Drops rows that repeat the row before, and refuses time that runs backward or stands still."""
    step = np.diff(flight.time_s)
    block = np.column_stack(list(flight.columns.values()))
    same = np.all((block[1:] == block[:-1]) | (np.isnan(block[1:]) & np.isnan(block[:-1])), axis=1)
    twice = np.concatenate([[False], (step == 0.0) & same])
    bad = np.flatnonzero(np.concatenate([[False], (step < 0.0) | ((step == 0.0) & ~same)]))
    if len(bad):
        row = bad[0]
        why = "runs backward" if step[row - 1] < 0.0 else "stands still while other columns change"
        raise ImportFailure(f"{flight.file}:{flight.line[row]}: column `{flight.source.get('time_s', 'time_s')}`: time {why}: {flight.time_s[row]:.6f} s after "
                            f"{flight.time_s[row - 1]:.6f} s ({len(bad)} such rows); is it the right time column?", DATA)
    if np.any(twice):
        at = flight.time_s[twice]
        flight.findings.append(Finding("duplicate", "time_s", at[0], at[-1], "note",
                                       f"{int(twice.sum())} rows repeat the row before, time included: dropped", True))
        flight.keep(~twice)
    if len(flight.time_s) < 10:
        count = len(flight.time_s)
        raise ImportFailure(f"{flight.file}: only {count} sample{'s' * (count != 1)}: too few to be a flight", DATA)


def gaps(flight: Flight) -> None:
    """Says where the record has holes; runs before ground time is cut out."""
    if any(slower(flight, columns) for columns in groups(flight).values()):
        return gaps_of_streams(flight)
    step, median = np.diff(flight.time_s), flight.step_s()
    holes = np.flatnonzero(step > GAP * median)
    if len(holes):
        worst = holes[np.argmax(step[holes])]
        flight.findings.append(Finding(
            "gap", "time_s", flight.time_s[holes[0]], flight.time_s[holes[-1] + 1], "warning",
            f"{len(holes)} gaps of more than {GAP} sample intervals, the longest {1e3 * step[worst]:.1f} ms at "
            f"{flight.time_s[worst]:.2f} s (the interval is {1e3 * median:.2f} ms)"))


def gaps_of_streams(flight: Flight) -> None:
    """The same where columns have clocks of their own: each on its own."""
    for name, columns in groups(flight).items():
        time_s, _ = flight.series(*columns)
        step = np.diff(time_s)
        if len(step) < 3:
            continue
        holes = np.flatnonzero(step > max(GAP_OF_STREAM * float(np.median(step)), GAP_OF_STREAM_s))
        if len(holes):
            worst = holes[np.argmax(step[holes])]
            flight.findings.append(Finding(
                "gap", ",".join(columns), time_s[holes[0]], time_s[holes[-1] + 1], "warning",
                f"{name}: {len(holes)} gaps, the longest {step[worst]:.2f} s at {time_s[worst]:.2f} s (the interval is "
                f"{1e3 * float(np.median(step)):.0f} ms)"))


def stretches(mask: np.ndarray) -> list:
    """(first, last) row of every run of True."""
    edges = np.diff(np.concatenate([[0], mask.astype(np.int8), [0]]))
    return list(zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1))


def airborne(flight: Flight) -> np.ndarray:
    """Rows in flight: some actuator runs and, with a position, the vehicle is clear of where it rests."""
    actuators = flight.block(*flight.actuator_names)
    running = np.nanmax(np.where(np.isnan(actuators), 0.0, actuators), axis=1) > 0.0
    if "pz" not in flight.columns:
        return running
    height = flight.columns["pz"]
    at_rest = height[: int(np.argmax(running))] if running.any() and not running[0] else height[:0]
    rest = np.nanmedian(at_rest) if len(at_rest) else np.nanmin(height)
    return running & (height > rest + AIRBORNE_HEIGHT_m) if len(at_rest) else running


def keep_section(flight: Flight, column_map: ColumnMap, from_s, to_s, whole: bool) -> None:
    """Keeps --from to --to, or the section that the map gives."""
    section_from, section_to, why = column_map.section(Path(flight.file).name)
    if whole:
        section_from = section_to = None
    first = from_s if from_s is not None else section_from
    last = to_s if to_s is not None else section_to
    if first is not None or last is not None:
        when = f"before {last:g}" if first is None else f"after {first:g}" if last is None else f"between {first:g} and {last:g}"
        first = flight.time_s[0] if first is None else first
        last = flight.time_s[-1] if last is None else last
        inside = (flight.time_s >= first) & (flight.time_s <= last)
        if not inside.any():
            raise ImportFailure(f"{flight.file}: no sample {when} s (the record has "
                                f"{flight.time_s[0]:g} to {flight.time_s[-1]:g} s)", USAGE)
        flight.keep(inside)
        if from_s is None and to_s is None:
            flight.findings.append(Finding("inconsistent", "time_s", first, last, "note",
                                           "only this section is kept" + (f": {why}" if why else "")))


def keep_flight(flight: Flight) -> None:
    """Drops the time on the ground; what is left in between shows as a gap."""
    in_air, kept = airborne(flight), np.zeros(len(flight.time_s), bool)
    for first, last in stretches(in_air):
        if flight.time_s[last] - flight.time_s[first] >= SHORTEST_STRETCH_s:
            kept[first:last + 1] = True
    if kept.all():
        return
    if not kept.any():
        flight.findings.append(Finding("ground", ",".join(flight.actuator_names), flight.time_s[0], flight.time_s[-1], "error",
                                       "the vehicle never flies: no stretch of a second with running rotors above "
                                       f"{AIRBORNE_HEIGHT_m} m over where it rests"))
        return
    parts = ", ".join(f"{flight.time_s[a]:.2f} to {flight.time_s[b]:.2f} s" for a, b in stretches(kept))
    flight.findings.append(Finding("ground", "time_s", flight.time_s[0], flight.time_s[-1], "note",
                                   f"{int((~kept).sum())} rows on the ground (rotors off, or below "
                                   f"{AIRBORNE_HEIGHT_m} m over rest) are left out; flight: {parts}", True))
    flight.keep(kept)
