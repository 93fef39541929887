"""Motor commands: pulses to 0..1, and motors between slow samples from the set points that they were allocated from; and what
speed controllers report."""

import numpy as np

from .problems import Finding
from .streams import stream

EXACT = 1e-3        # of full scale: as far as an allocated motor may be from the sample of the same instant
LINEAR = (0.02, 0.98)  # motors at a limit are not linear in the set points
FASTER = 1.5        # set points must come this many times as often as motors to be worth it


ENOUGH_Hz = 100.0   # speeds that come so often show a rotor's lag, whatever the rate of the commands


def put_speeds(out, time_s, rpm, source: str) -> None:
    """Rotor speeds that speed controllers report become `rotor`, where they come often enough to drive a body.

    out    the Recording, with its motor commands
    rpm    (n, N), mechanical, in the order of u1...uN; NaN or zero where nothing was received
    A log with measured speeds is judged by them in place of its commands, so speeds that come more seldom than these would hide
    what the commands tell: they are said and not used.
    """
    rpm = np.abs(np.asarray(rpm, dtype=float))
    live = np.isfinite(rpm).all(axis=1) & (rpm > 0.0).all(axis=1)
    if not live.any():
        return
    names = [f"rotor{k + 1}" for k in range(rpm.shape[1])]
    speeds = stream(names, np.asarray(time_s)[live], rpm[live] * (2.0 * np.pi / 60.0), source)
    commands = out.streams.get("u")
    if commands is not None and speeds.rate_hz() < min(ENOUGH_Hz, 0.9 * commands.rate_hz()):
        out.findings.append(Finding("held", "rotor", float(speeds.time_s[0]), float(speeds.time_s[-1]), "note",
                                    f"rotor speeds of {source} come at {speeds.rate_hz():.0f} Hz, more seldom than the motors' commands at "
                                    f"{commands.rate_hz():.0f} Hz: not used"))
        return
    out.put("rotor", speeds)


def thrust_share(signal: np.ndarray, factor: float) -> np.ndarray:
    """PX4's signal to a motor -> the share of thrust that it stands for (THR_MDL_FAC): what actuator_motors holds."""
    return factor * signal**2 + (1.0 - factor) * signal if 0.0 < factor <= 1.0 else signal


def pulse_share(pulses: np.ndarray, low: float, high: float) -> np.ndarray:
    """Pulse widths [us] or DShot values -> 0..1 of the range, clipped at its ends (1000 and below is off)."""
    return np.clip((np.asarray(pulses, dtype=float) - low) / (high - low), 0.0, 1.0)


def allocated_motors(stamps, asked, published_s, motor_stamps, motors, motor_times_s):
    """((time_s, motors), what to say) with motors at the times of the set points too; (None, why not) otherwise.

    stamps, asked, published_s   (n,), (n, 4) torque x, y, z and thrust, (n,) s: the set points
    motor_stamps, motors, motor_times_s   (m,), (m, N) and (m,): the samples of the motors
    Stamps of both are of the gyroscope sample that the command answers, so that equal stamps are one run of the loop. The
    allocation is a linear map (PX4's pseudo-inverse, normalised) fitted to those; parameters often hold defaults. Motors
    that it puts at a limit are left out, as the desaturation there is not linear.
    """
    if len(stamps) < FASTER * len(motor_stamps):
        return None, ""
    place = np.searchsorted(stamps, motor_stamps)
    same = (place < len(stamps)) & (np.take(stamps, np.minimum(place, len(stamps) - 1)) == motor_stamps)
    inside = same & np.all((motors > LINEAR[0]) & (motors < LINEAR[1]), axis=1)
    rows = place[inside]
    terms = np.column_stack([asked, np.ones(len(asked))])
    if len(rows) < 20:
        return None, "the motors were not completed: too few samples of the same instant as a set point"
    mix = np.linalg.lstsq(terms[rows], motors[inside], rcond=None)[0]
    worst = float(np.abs(terms[rows] @ mix - motors[inside]).max())
    if worst > EXACT:
        return None, f"the motors were not completed: the set points miss their samples by up to {worst:.3f}"
    made = terms @ mix
    late_s = float(np.median(motor_times_s[inside] - published_s[rows]))
    new = np.all((made > LINEAR[0]) & (made < LINEAR[1]), axis=1) & ~np.isin(stamps, motor_stamps)
    time_s = np.concatenate([motor_times_s, published_s[new] + late_s])
    order = np.argsort(time_s, kind="stable")
    return (time_s[order], np.vstack([motors, made[new]])[order]), f"agree to {worst:.0e} in {len(rows)} samples"
