"""From aviation frames (world north-east-down, body forward-right-down) to the flight log's (z up, y left)."""

import numpy as np

from .rotations import multiply

# NED to ENU is half a turn about the horizontal north-east diagonal; FLU to FRD half a turn about the body's x axis
_NED_TO_ENU = np.array([[0.0, np.sqrt(0.5), np.sqrt(0.5), 0.0]])
_FLU_TO_FRD = np.array([[0.0, 1.0, 0.0, 0.0]])


def enu(vector_NED: np.ndarray) -> np.ndarray:
    """(n, 3) north, east, down -> east, north, up."""
    return np.column_stack([vector_NED[:, 1], vector_NED[:, 0], -vector_NED[:, 2]])


def flu(vector_FRD: np.ndarray) -> np.ndarray:
    """(n, 3) forward, right, down -> forward, left, up."""
    return vector_FRD * np.array([1.0, -1.0, -1.0])


def attitude_enu(q: np.ndarray) -> np.ndarray:
    """Body to NED -> the same body to ENU."""
    return multiply(np.broadcast_to(_NED_TO_ENU, q.shape), q)


def attitude_flu(q: np.ndarray) -> np.ndarray:
    """FRD body to a world -> FLU body to that world."""
    return multiply(q, np.broadcast_to(_FLU_TO_FRD, q.shape))


def yaw_enu(yaw_NED_rad: np.ndarray) -> np.ndarray:
    return 0.5 * np.pi - yaw_NED_rad


def from_euler(roll_rad, pitch_rad, yaw_rad) -> np.ndarray:
    """Quaternion (n, 4) of yaw, then pitch, then roll (aerospace sequence)."""
    halves = [0.5 * np.asarray(angle, dtype=float) for angle in (roll_rad, pitch_rad, yaw_rad)]
    (cr, cp, cy), (sr, sp, sy) = [np.cos(a) for a in halves], [np.sin(a) for a in halves]
    return np.column_stack([cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy,
                            cr * cp * sy - sr * sp * cy])
