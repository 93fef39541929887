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
    """Signal to a motor -> the share of thrust that the autopilot takes it for (PX4's THR_MDL_FAC, ArduPilot's MOT_THST_EXPO)."""
    return factor * signal**2 + (1.0 - factor) * signal if -1.0 <= factor <= 1.0 else signal


def pulse_share(pulses: np.ndarray, low: float, high: float) -> np.ndarray:
    """Pulse widths [us] or DShot values -> 0..1 of the range, clipped at its ends (1000 and below is off)."""
    return np.clip((np.asarray(pulses, dtype=float) - low) / (high - low), 0.0, 1.0)


def ardupilot_range(parameters: dict) -> tuple:
    """(lowest, highest) pulse of the motors [us]: MOT_PWM_MIN and MAX, or where these are not set those of the throttle stick."""
    stick = f"RC{int(parameters.get('RCMAP_THROTTLE', 3))}_"
    for low, high in (("MOT_PWM_MIN", "MOT_PWM_MAX"), (stick + "MIN", stick + "MAX")):
        if 0 < parameters.get(low, 0) < parameters.get(high, 0):
            return float(parameters[low]), float(parameters[high])
    return 1000.0, 2000.0


def ardupilot_share(signal: np.ndarray, parameters: dict) -> tuple:
    """(share of thrust, what to say) of ArduPilot's signal to a motor, 0..1 of its range.

    From 3.5 on (Thrust_Linearization): thrust begins at MOT_SPIN_MIN, ends at MOT_SPIN_MAX and has MOT_THST_EXPO between them. To
    3.2: two straight lines through half the thrust at MOT_TCRV_MIDPCT and all of it at MOT_TCRV_MAXPCT. What the autopilot adds
    for an empty battery stays in, because the motor got it.
    """
    first, last = parameters.get("MOT_SPIN_MIN"), parameters.get("MOT_SPIN_MAX", 1.0)
    if first is not None and first < last and "MOT_THST_EXPO" in parameters:
        curve = float(np.clip(parameters["MOT_THST_EXPO"], -1.0, 1.0))
        return (thrust_share(np.clip((signal - first) / (last - first), 0.0, 1.0), curve),
                f"as shares of thrust (MOT_THST_EXPO {curve:.3g} from {first:.3g} to {last:.3g})")
    middle, last = 0.01 * parameters.get("MOT_TCRV_MIDPCT", 0), 0.01 * parameters.get("MOT_TCRV_MAXPCT", 0)
    if parameters.get("MOT_TCRV_ENABLE", 0) == 1 and 0.0 < middle < last:
        return np.interp(signal, (0.0, middle, last), (0.0, 0.5, 1.0)), f"as shares of thrust (half at {middle:.3g}, all at {last:.3g}: MOT_TCRV)"
    return signal, "not led back through a thrust curve: the log's parameters name none that is known"


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
