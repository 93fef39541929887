"""Quaternion helpers on arrays; quaternions are Hamilton, scalar first, body to world, shape (n, 4).

A row without a sample is NaN and stays NaN: scipy's Rotation refuses it, and to load it takes longer than most imports.
"""

import numpy as np


def conjugate(q: np.ndarray) -> np.ndarray:
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def rotate(q: np.ndarray, vector_B: np.ndarray) -> np.ndarray:
    """Rotates body vectors (n, 3) into the world: v + 2 u x (u x v + w v), q = (w, u)."""
    u = q[:, 1:]
    t = np.cross(u, vector_B) + q[:, :1] * vector_B
    return vector_B + 2.0 * np.cross(u, t)


def increment(q: np.ndarray) -> np.ndarray:
    """Rotation vector [rad] of q[k]^-1 q[k+1] in the body frame, shape (n - 1, 3)."""
    a, b = q[:-1], q[1:]
    scalar = np.sum(a * b, axis=1)
    vector = a[:, :1] * b[:, 1:] - b[:, :1] * a[:, 1:] - np.cross(a[:, 1:], b[:, 1:])
    vector = np.where(scalar[:, None] < 0.0, -vector, vector)
    size = np.linalg.norm(vector, axis=1)
    angle = 2.0 * np.arctan2(size, np.abs(scalar))
    return vector * np.where(size > 1e-12, angle / np.maximum(size, 1e-12), 2.0)[:, None]


def body_rate(q: np.ndarray, time_s: np.ndarray) -> np.ndarray:
    """Body rate [rad/s] at the samples, by central differences of the attitude, shape (n, 3)."""
    step = increment(q) / np.diff(time_s)[:, None]
    return np.vstack([step[:1], 0.5 * (step[1:] + step[:-1]), step[-1:]])


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Hamilton product of (n, 4) and (n, 4)."""
    scalar = a[:, :1] * b[:, :1] - np.sum(a[:, 1:] * b[:, 1:], axis=1, keepdims=True)
    return np.hstack([scalar, a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:] + np.cross(a[:, 1:], b[:, 1:])])
