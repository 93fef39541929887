"""Motor commands: pulses to 0..1, and motors between slow samples from the set points that they were allocated from."""

import numpy as np

EXACT = 1e-3        # of full scale: as far as an allocated motor may be from the sample of the same instant
LINEAR = (0.02, 0.98)  # motors at a limit are not linear in the set points
FASTER = 1.5        # set points must come this many times as often as motors to be worth it


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
