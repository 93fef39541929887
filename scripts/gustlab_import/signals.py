"""Small signal helpers of the checks; arrays are (n,) or (n, m), one row per sample."""

import numpy as np

REFERENCE_BAND = (0.06, 0.10)  # of the sample rate: above the motion of the vehicle, below any anti-alias corner
TOP_BAND = (0.40, 0.50)


def filled(values: np.ndarray) -> np.ndarray:
    """Copies the values with holes bridged by straight lines, for the checks only."""
    out = np.array(values, dtype=float)
    flat = out.reshape(len(out), -1)
    for column in flat.T:
        hole = np.isnan(column)
        if hole.any() and not hole.all():
            column[hole] = np.interp(np.flatnonzero(hole), np.flatnonzero(~hole), column[~hole])
    return np.nan_to_num(out)


def boxcar(values: np.ndarray, width: int) -> np.ndarray:
    """Centred moving average over an odd number of rows; the ends average what is there."""
    width = max(1, width | 1)
    half = width // 2
    total = np.vstack([np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)])
    first = np.clip(np.arange(len(values)) - half, 0, len(values))
    last = np.clip(np.arange(len(values)) + half + 1, 0, len(values))
    return (total[last] - total[first]) / (last - first)[:, None]


def band(values: np.ndarray, step_s: float) -> np.ndarray:
    """Keeps about 0.5 to 10 Hz: what a vehicle does, without offsets and without noise."""
    smooth = boxcar(values, round(0.05 / step_s))
    return smooth - boxcar(smooth, round(1.0 / step_s))


def agreement(a: np.ndarray, b: np.ndarray, reach: int) -> tuple:
    """(correlation, lag, gain): the shift of b against a, in rows, at which they agree best.

    a, b are (n, m); columns count with their own size. A positive lag means that b is late. The lag is refined by a
    parabola through the three best values. gain is b over a at the best whole lag, NaN when nothing correlates.
    """
    reach = int(min(reach, len(a) // 3))
    middle = a[reach:len(a) - reach]
    if reach < 1 or not np.any(middle) or not np.any(b):
        return 0.0, 0.0, np.nan
    scores = np.empty(2 * reach + 1)
    size_a = np.sum(middle * middle)
    for k in range(2 * reach + 1):
        part = b[k:k + len(middle)]
        scores[k] = np.sum(middle * part) / np.sqrt(max(size_a * np.sum(part * part), 1e-300))
    best = int(np.argmax(scores))
    lag = float(best - reach)
    if 0 < best < 2 * reach:
        left, top, right = scores[best - 1:best + 2]
        curve = left - 2.0 * top + right
        lag += 0.5 * (left - right) / curve if curve < 0.0 else 0.0
    part = b[best:best + len(middle)]
    return float(scores[best]), lag, float(np.sum(middle * part) / size_a)


def third_difference_noise(values: np.ndarray) -> float:
    """Standard deviation of white noise on a smooth signal: median |d3 y| / (0.6745 sqrt 20)."""
    steps = np.abs(np.diff(values[~np.isnan(values)], 3))
    return float(np.median(steps) / (0.6745 * np.sqrt(20.0))) if len(steps) else np.nan


def spectrum(values: np.ndarray, segment: int = 256) -> np.ndarray:
    """Averaged periodogram (Hann windows, half overlapping, straight line removed) at 0 to half the sample rate."""
    segment = min(segment, len(values))
    window, ramp = np.hanning(segment), np.arange(segment) - (segment - 1) / 2.0
    power, count = np.zeros(segment // 2 + 1), 0
    for first in range(0, len(values) - segment + 1, max(1, segment // 2)):
        part = values[first:first + segment] - np.mean(values[first:first + segment])
        part = part - ramp * (ramp @ part) / (ramp @ ramp)
        power += np.abs(np.fft.rfft(part * window)) ** 2
        count += 1
    return power / max(count, 1)


def quiet_above(values: np.ndarray) -> float:
    """Fraction of the sample rate above which the signal holds (almost) no power, or NaN where noise reaches the top.

    A sampled sensor ends in a noise floor; a record that was low-pass filtered does not.
    """
    power = spectrum(values)
    frequency = np.linspace(0.0, 0.5, len(power))
    reference = np.median(power[(frequency >= REFERENCE_BAND[0]) & (frequency < REFERENCE_BAND[1])])
    top = np.median(power[(frequency >= TOP_BAND[0]) & (frequency <= TOP_BAND[1])])
    if reference <= 0.0 or top > 1e-5 * reference:
        return np.nan
    loud = np.flatnonzero(power > 1e-3 * reference)
    return float(frequency[min(loud[-1] + 1, len(frequency) - 1)]) if len(loud) else 0.0


def on_a_line(time_s: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Rows (n,) whose every column lies on the straight line between its neighbours, and moves: interpolated rows."""
    out = np.zeros(len(values), bool)
    if len(values) < 3:
        return out
    share = ((time_s[1:-1] - time_s[:-2]) / (time_s[2:] - time_s[:-2]))[:, None]
    bend = np.abs(values[1:-1] - (values[:-2] + share * (values[2:] - values[:-2])))
    slope = np.abs(values[2:] - values[:-2])
    out[1:-1] = np.all(bend <= 1e-3 * slope + 1e-9, axis=1) & np.any(slope > 1e-6, axis=1)
    return out


def longest_run(mask: np.ndarray) -> tuple:
    """(first, last) row of the longest run of True, or None."""
    edges = np.diff(np.concatenate([[0], mask.astype(np.int8), [0]]))
    starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    if not len(starts):
        return None
    k = int(np.argmax(ends - starts))
    return int(starts[k]), int(ends[k])
