"""Rotor places and directions that autopilots number by convention."""

import numpy as np

from .streams import Rotor

# degrees clockwise from the nose, and +1 for counter-clockwise seen from above, motor 1 first.
# PX4 (docs, Airframes Reference) and ArduPilot (AP_MotorsMatrix) number these alike
PX4 = {"quadrotor x": ((45, 1), (-135, 1), (-45, -1), (135, -1)),
       "quadrotor +": ((90, 1), (-90, 1), (0, -1), (180, -1)),
       "hexarotor x": ((90, -1), (-90, 1), (-30, -1), (150, 1), (30, 1), (-150, -1)),
       "hexarotor +": ((0, -1), (180, 1), (-120, -1), (60, 1), (-60, 1), (120, -1)),
       "octorotor x": ((22.5, -1), (-157.5, -1), (67.5, 1), (157.5, 1), (-22.5, 1), (-112.5, 1), (-67.5, -1), (112.5, -1)),
       "octorotor +": ((0, -1), (180, -1), (45, 1), (135, 1), (-45, 1), (-135, 1), (-90, -1), (90, -1))}
# Betaflight, mixer QUADX, propellers "in": rear right, front right, rear left, front left
BETAFLIGHT = {"quadrotor x": ((135, -1), (45, 1), (-135, 1), (-45, -1))}
NAMES = {3: "tricopter", 4: "quadrotor", 6: "hexarotor", 8: "octorotor"}


def rotors(places) -> list:
    """Rotors on a circle of radius 1."""
    angles = [np.radians(angle) for angle, _ in places]
    return [Rotor(round(float(np.cos(a)), 6), round(float(-np.sin(a)), 6), direction)
            for a, (_, direction) in zip(angles, places)]


def name_of(rotors_of: list) -> str:
    """For example "quadrotor x": x where no rotor is straight ahead."""
    kind = NAMES.get(len(rotors_of), f"{len(rotors_of)} rotors")
    reach = max(np.hypot(r.x, r.y) for r in rotors_of)
    ahead = any(r.x > 0 and abs(r.y) < 0.05 * reach for r in rotors_of)
    return f"{kind} {'+' if ahead else 'x'}"


def match(theirs: list, wanted: list):
    """Order that puts the log's rotors where the vehicle's are, or None: [i] is the log's motor of the vehicle's rotor i.

    By bearing, as radii are often left at defaults in parameters; directions must agree.
    """
    if len(theirs) != len(wanted):
        return None

    def bearing(r):
        return np.exp(1j * np.arctan2(r.y, r.x))

    order = [int(np.argmin([abs(bearing(r) - bearing(w)) for r in theirs])) for w in wanted]
    far = max(abs(bearing(theirs[k]) - bearing(w)) for k, w in zip(order, wanted))
    same = all(theirs[k].direction == w.direction for k, w in zip(order, wanted))
    return order if len(set(order)) == len(order) and far < 0.6 and same else None
