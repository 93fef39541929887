"""Which parts of a recording are flights: armed, in the air, without gaps and resets; and why the rest is refused."""

import re

import numpy as np

from .streams import POSITION, Recording, Stream

SHORTEST_s = 3.0        # of a flight: shorter ones hold no window of a second beside the ends
GAP_s = 1.0             # without any sample of the fastest stream: a flight is cut there
SLOWEST_Hz = 5.0        # position and motors both slower than this cannot be judged
HEIGHT_WINDOW_s, HEIGHT_OFF_m = 2.0, 1.5    # height against its velocity: barometers drift by less
BROWN_OUT_SHARE = 0.65  # of the flight's median: 2.5 V of a cell at 3.8 V, below what a cell gives unharmed; a hard pull takes a quarter
BROWN_OUT_s = 0.1       # one low reading is an error or a hard pull, however many rows repeat it
BROWN_OUT_V = 4.3       # of a supply of 5 V: processors and sensors are specified down to here
RUNNING_SHARE = 0.4     # of the median command of the running motors: below it, over a second, the vehicle does not fly
END_s = 0.25            # between the motors' last sample and a log's end
LONGEST_DIVE_s = 4.0    # with idle motors
CLEAR_m = 0.1           # above where it stood: below that the ground may carry a part of the weight
ON_THE_GROUND = ("armed, on the ground", "on the ground", "disarmed")   # how these reasons begin
NEEDED = ("position", "specific_force", "body_rate")


def split(recording: Recording) -> tuple:
    """([(from_s, to_s)], [(from_s, to_s, why)]) in the order of time; together they cover the log."""
    whole = (0.0, recording.end_s)
    never = "disarmed: the vehicle was never armed" if recording.armed == [] else ""
    if why := recording.no_flight or never or not_judged(recording):
        return [], [(*whole, why)]
    armed = [whole] if recording.armed is None else [both for part in recording.armed if (both := common(whole, rounded(part)))]
    refused = [(*part, "disarmed") for part in without(whole, armed)]
    flying = flying_of(recording)
    flights = []
    for span in armed:
        inside = [both for part in flying if (both := common(span, part))]
        refused += [(*part, "armed, on the ground" if recording.armed else "on the ground") for part in without(span, inside)]
        for part in inside:
            lifted = off_the_ground(recording, part)
            refused += [(*piece, f"on the ground: the height is within {CLEAR_m:g} m of where it stood") for piece in without(part, lifted)]
            kept, why = cut(recording, lifted[0]) if lifted else ([], [])
            refused += why
            flights += kept
    for span in list(flights):
        if why := nothing_to_judge(recording, *span):
            flights.remove(span)
            refused.append((*span, why))
    return sorted(flights), sorted(part for part in refused if part[1] - part[0] > 0.05)


def nothing_to_judge(recording: Recording, from_s: float, to_s: float) -> str:
    """Why this stretch of a log is no flight, or an empty text."""
    if to_s - from_s < SHORTEST_s:
        return f"too short: {to_s - from_s:.1f} s in the air, {SHORTEST_s:g} s are needed"
    sampled = [name for name, stream in recording.streams.items() if len(stream.between(from_s, to_s).time_s)]
    if "u" not in sampled and "rotor" not in sampled:
        return "no motor commands and no rotor speeds were logged there"
    return "" if any(name in sampled for name in NEEDED) else "neither position nor specific force nor body rate was logged there"


def reasons(refused: list) -> list:
    """Why a log gave no flight: of reasons that differ in their numbers alone that of the longest part. That the vehicle stood is none beside others."""
    longest = {}
    for _, _, why in sorted(refused, key=lambda part: part[0] - part[1]):
        longest.setdefault(re.sub(r"\d+(\.\d+)?", "", why), why)
    return [why for why in longest.values() if not why.startswith(ON_THE_GROUND)] or list(longest.values())


def not_judged(recording: Recording) -> str:
    """Why nothing in this log can be compared with a simulation, or an empty text."""
    streams = recording.streams
    if "u" not in streams and "rotor" not in streams:
        return "no motor commands and no rotor speeds are in the log" + (f": {recording.facts['no_motors']}"
                                                                        if "no_motors" in recording.facts else "")
    if not any(name in streams for name in NEEDED):
        return "neither position nor specific force nor body rate is in the log"
    inputs = max(streams[name].rate_hz() for name in ("u", "rotor") if name in streams)
    motion = max(streams[name].rate_hz() for name in NEEDED if name in streams)
    if inputs < SLOWEST_Hz and motion < SLOWEST_Hz:
        return f"cannot be judged at {max(inputs, motion):.1f} Hz (telemetry; {SLOWEST_Hz:g} Hz are needed): take the vehicle's own log"
    return ""


def flying_of(recording: Recording) -> list:
    """Spans in the air, by the vehicle's own judgement or else by its motors."""
    return recording.flying if recording.flying is not None else running(recording)


def running(recording: Recording) -> list:
    """Spans in which the motors carry something, for logs that do not say when the vehicle flies. What runs in the motors' first or last
    sample does so to the log's end beside it."""
    inputs = recording.streams.get("u") or recording.streams["rotor"]
    mean = np.nanmean(inputs.values, axis=1)
    if not np.any(mean > 0.0):
        return []
    width = max(1, round(inputs.rate_hz()))
    smooth = np.convolve(np.pad(mean, (width // 2, width - 1 - width // 2), mode="edge"), np.ones(width) / width, "valid")
    on = smooth > RUNNING_SHARE * float(np.median(mean[mean > 0.02 * mean.max()]))
    edges = np.flatnonzero(np.diff(np.concatenate([[0], on.astype(int), [0]])))
    times = np.append(inputs.time_s, inputs.time_s[-1])
    times[0] = 0.0 if times[0] <= END_s else times[0]
    times[-1] = recording.end_s if times[-1] >= recording.end_s - END_s else times[-1]
    parts = [(float(times[a]), float(times[b])) for a, b in zip(edges[::2], edges[1::2])]
    out = parts[:1]
    for part in parts[1:]:
        # a dive with the motors idle is flight
        out[-1:] = [(out[-1][0], part[1])] if part[0] - out[-1][1] < LONGEST_DIVE_s else [out[-1], part]
    return out


def off_the_ground(recording: Recording, part: tuple) -> list:
    """[part] from where the vehicle has left the height at which it stood until it is back at the one where it comes to stand.

    Landing detectors let go when the throttle rises and find the ground late. A log that begins or ends in the air has no such height.
    """
    position = recording.streams.get("position")
    time_s, height = _axis(position) if position is not None else ([], [])
    if len(time_s) < 2 or part[1] - part[0] < SHORTEST_s:
        return [part]
    before, after = np.searchsorted(time_s, part[0]) - 1, np.searchsorted(time_s, part[1], "right")
    times, inside = np.concatenate([part[:1], time_s[before + 1:after], part[1:]]), height[before + 1:after]
    begins, ends = part
    if before >= 0:
        away = np.flatnonzero(np.abs(inside - height[before]) > CLEAR_m)
        begins = float(times[away[0] + (away[0] > 0)]) if len(away) else ends
    if after < len(time_s):
        away = np.flatnonzero(np.abs(inside - height[after]) > CLEAR_m)
        ends = float(times[away[-1] + 1 + (away[-1] == len(inside) - 1)]) if len(away) else begins
    return [(begins, ends)] if ends > begins else []


def cut(recording: Recording, span: tuple) -> tuple:
    """One time in the air without its gaps, resets, brown-outs and stretches whose height contradicts their velocity."""
    holes = gaps(recording, span) + contradictions(recording, span) + brown_outs(recording, span)
    marks = [(t, t, why) for t, why in recording.breaks if span[0] < t < span[1]]
    kept = without(span, [(a, b) for a, b, _ in holes])
    for time_s, _, _ in marks:
        kept = [piece for part in kept for piece in
                (((part[0], time_s - 1e-6), (time_s, part[1])) if part[0] < time_s < part[1] else (part,))]
    return kept, holes + [(max(span[0], t - 0.06), t, why) for t, _, why in marks]


def gaps(recording: Recording, span: tuple) -> list:
    """Times without any sample of the fastest of the streams that a flight needs."""
    fastest = max((s.between(*span) for name, s in recording.streams.items() if name in NEEDED), key=lambda s: len(s.time_s))
    times = np.concatenate([[span[0]], fastest.time_s, [span[1]]])
    wide = np.flatnonzero(np.diff(times) > GAP_s)
    return [(float(times[k]), float(times[k + 1]), f"gap: no sample for {times[k + 1] - times[k]:.1f} s") for k in wide]


def brown_outs(recording: Recording, span: tuple) -> list:
    """Stretches in which the battery or the board's supply collapsed."""
    out = []
    for name, volts in (("the battery", recording.streams.get("vbat")), ("the board's supply", recording.supply)):
        volts = volts and volts.between(*span)
        if not volts or len(volts.time_s) < 10:
            continue
        usual = float(np.nanmedian(volts.values))
        low = volts.values[:, 0] < (BROWN_OUT_SHARE * usual if name == "the battery" else BROWN_OUT_V)
        if usual < BROWN_OUT_V and name != "the battery":
            continue
        edges = np.flatnonzero(np.diff(np.concatenate([[0], low.astype(int), [0]])))
        times = np.concatenate([[span[0]], volts.time_s, [span[1]]])
        out += [(float(times[a]), float(times[b + 1]), f"brown-out: {name} fell from {usual:.1f} to {np.nanmin(volts.values[a:b]):.1f} V")
                for a, b in zip(edges[::2], edges[1::2]) if volts.time_s[b - 1] - volts.time_s[a] >= BROWN_OUT_s]
    return out


def contradictions(recording: Recording, span: tuple) -> list:
    """Stretches of two seconds in which the height moves otherwise than its velocity says."""
    position, velocity = recording.streams.get("position"), recording.streams.get("velocity")
    if position is None or velocity is None:
        return []
    height, climb = _axis(position.between(*span)), _axis(velocity.between(*span))
    if min(len(height[0]), len(climb[0])) < 10:
        return []
    steps = np.diff(climb[0])
    moved = np.concatenate([[0.0], np.cumsum(0.5 * steps * (climb[1][1:] + climb[1][:-1]))])
    drift = height[1] - np.interp(height[0], climb[0], moved)
    later = np.searchsorted(height[0], height[0] + HEIGHT_WINDOW_s)
    inside = later < len(drift)
    off = np.abs(drift[later[inside]] - drift[inside])
    bad = np.flatnonzero(off > HEIGHT_OFF_m)
    if not len(bad):
        return []
    pieces = np.split(bad, np.flatnonzero(np.diff(height[0][bad]) > HEIGHT_WINDOW_s) + 1)
    return [(float(height[0][p[0]]), float(height[0][p[-1]] + HEIGHT_WINDOW_s),
             f"the height contradicts its velocity by {off[p].max():.1f} m in {HEIGHT_WINDOW_s:g} s") for p in pieces]


def _axis(stream: Stream) -> tuple:
    """(time_s, third column) without the rows that have no sample of it."""
    there = np.isfinite(stream.values[:, len(POSITION) - 1])
    return stream.time_s[there], stream.values[there, len(POSITION) - 1]


def common(a: tuple, b: tuple):
    both = max(a[0], b[0]), min(a[1], b[1])
    return both if both[1] > both[0] else None


def rounded(span: tuple) -> tuple:
    return round(span[0], 6), round(span[1], 6)


def without(span: tuple, parts: list) -> list:
    """What is left of a span without the parts."""
    left, at = [], span[0]
    for part in sorted(parts):
        if part[0] > at:
            left.append((at, min(part[0], span[1])))
        at = max(at, part[1])
    return left + ([(at, span[1])] if at < span[1] else [])
