"""`gustlab identify` against PySINDy on the same flight logs: the same coefficients to 1e-6.

Θ and Ẏ are formed here a second time, from the columns of the logs, with PySINDy's differentiation and scipy's filters.
"""

import json
import os
import subprocess
import tempfile
import unittest
import warnings
from pathlib import Path

import numpy as np

try:
    import pysindy
except ImportError:
    pysindy = None

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("GUSTLAB_PROGRAM", ROOT / "build" / "release" / "gustlab")

# models/crazyflie: mass, thrust coefficient; MuJoCo's gravity
MASS_KG, COEFFICIENT, GRAVITY = 0.0282, 1.7965e-8, 9.81
SIDECAR = 'format = "gustlab-flight/1"\nvehicle = "crazyflie"\nactuator = "rotor_speed"\nsource = "simulation"\n'
TERMS = ["1", "theta", "phi", "T sin theta", "T cos theta", "T sin phi", "T cos phi"]


def make_flight(phase, rows=1500):
    """Columns of a flight that rocks about hover under a force; velocity is noisy and its grid uneven."""
    rng = np.random.default_rng(7 + int(10 * phase))
    t = 0.02 * (np.arange(rows) + 0.2 * rng.uniform(-0.5, 0.5, rows))
    roll = 0.3 * np.sin(1.9 * t + phase) + 0.15 * np.sin(4.3 * t)
    pitch = 0.25 * np.cos(1.3 * t + 2 * phase) + 0.2 * np.sin(3.1 * t)
    thrust = 0.277 + 0.08 * np.sin(2.3 * t + phase) + 0.05 * np.cos(5.1 * t)
    velocity = np.column_stack([np.sin(1.1 * t + phase), np.cos(1.3 * t), 0.5 * np.sin(0.9 * t)])
    velocity += 0.001 * rng.standard_normal(velocity.shape)
    speed = np.sqrt(thrust / 4 / COEFFICIENT)
    cr, sr, cp, sp = np.cos(roll / 2), np.sin(roll / 2), np.cos(pitch / 2), np.sin(pitch / 2)
    position = np.vstack([np.zeros(3), np.cumsum(np.diff(t)[:, None] * (velocity[1:] + velocity[:-1]) / 2, axis=0)])
    columns = {"time_s": t}
    columns |= dict(zip(("px", "py", "pz", "vx", "vy", "vz"), np.column_stack([position, velocity]).T))
    columns |= {"qw": cr * cp, "qx": sr * cp, "qy": cr * sp, "qz": -sr * sp}
    columns |= {f"rotor{i}": speed for i in (1, 2, 3, 4)}
    return columns


def write_flight(columns, path):
    table = np.column_stack(list(columns.values()))
    np.savetxt(path, table, fmt="%.17g", delimiter=",", header=",".join(columns), comments="")
    path.with_suffix(".meta.toml").write_text(SIDECAR, encoding="utf-8")


def regression(columns, smooth=lambda x: x, derivative=None):
    """Θ and the residual force, formed from the columns."""
    roll = np.arctan2(2 * (columns["qw"] * columns["qx"] + columns["qy"] * columns["qz"]),
                      1 - 2 * (columns["qx"] ** 2 + columns["qy"] ** 2))
    pitch = np.arcsin(2 * (columns["qw"] * columns["qy"] - columns["qz"] * columns["qx"]))
    thrust = COEFFICIENT * sum(columns[f"rotor{i}"] ** 2 for i in (1, 2, 3, 4))
    # yaw is zero: R e₃ = (cos φ sin θ, −sin φ, cos φ cos θ)
    known = thrust[:, None] * np.column_stack([np.cos(roll) * np.sin(pitch), -np.sin(roll), np.cos(roll) * np.cos(pitch)])
    velocity = np.column_stack([columns["vx"], columns["vy"], columns["vz"]])
    if derivative is None:
        acceleration = pysindy.FiniteDifference(order=2)._differentiate(smooth(velocity), columns["time_s"])
    else:
        acceleration = derivative(velocity)
    target = MASS_KG * (acceleration + [0, 0, GRAVITY]) - smooth(known)
    roll, pitch, thrust = smooth(np.column_stack([roll, pitch, thrust])).T
    theta = np.column_stack([np.ones_like(roll), pitch, roll, thrust * np.sin(pitch), thrust * np.cos(pitch),
                             thrust * np.sin(roll), thrust * np.cos(roll)])
    return theta, target


@unittest.skipIf(pysindy is None, "PySINDy is not installed (scripts/setup.sh --test installs it)")
class Agreement(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.flights = [make_flight(0.0), make_flight(1.0)]
        cls.paths = [Path(cls.folder.name) / f"flight{i}.csv" for i in range(len(cls.flights))]
        for columns, path in zip(cls.flights, cls.paths):
            write_flight(columns, path)
        parts = [regression(columns) for columns in cls.flights]
        cls.theta, cls.target = np.vstack([p[0] for p in parts]), np.vstack([p[1] for p in parts])

    def identify(self, *options, paths=None):
        command = [PROGRAM, "identify", *(paths or self.paths), "--known", "thrust", "--format", "json", *options]
        done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        found = json.loads(done.stdout)
        self.assertEqual(found["terms"], TERMS)
        self.assertEqual(found["targets"], ["fx", "fy", "fz"])
        return found

    def assert_same(self, found, optimizer, theta=None, target=None):
        theta, target = (self.theta, self.target) if theta is None else (theta, target)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            optimizer.fit(theta, target)
        ours, theirs = np.array(found["coefficients"]), np.array(optimizer.coef_)
        self.assertTrue(np.any(theirs != 0.0))
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-6 * max(1.0, np.abs(theirs).max()))
        np.testing.assert_array_equal(ours != 0.0, np.abs(theirs) > 1e-14)
        residual = target - theta @ ours.T
        self.assertAlmostEqual(found["error_fit"], np.sqrt(np.mean(residual**2)), delta=1e-9)
        self.assertAlmostEqual(found["condition_number"] / np.linalg.cond(theta), 1.0, delta=1e-6)

    def test_stlsq(self):
        for threshold in (0.0, 0.002, 0.05, 0.3):
            with self.subTest(threshold=threshold):
                found = self.identify("--optimizer", "stlsq", "--lambda", threshold)
                self.assert_same(found, pysindy.STLSQ(threshold=threshold, alpha=0.05, max_iter=1000))

    def test_stlsq_with_normalized_columns_and_no_refit(self):
        found = self.identify("--optimizer", "stlsq", "--lambda", 0.1, "--ridge", 0.01, "--normalize", "--no-refit")
        self.assert_same(found, pysindy.STLSQ(threshold=0.1, alpha=0.01, max_iter=1000, normalize_columns=True, unbias=False))

    def test_sr3(self):
        for penalty, weight in (("l0", 1e-4), ("l0", 1e-2), ("l1", 1e-2), ("l1", 0.3), ("l2", 0.1)):
            with self.subTest(penalty=penalty, weight=weight):
                found = self.identify("--optimizer", "sr3", "--penalty", penalty, "--lambda", weight, "--nu", 0.5)
                self.assertTrue(found["converged"])
                self.assert_same(found, pysindy.SR3(reg_weight_lam=weight, regularizer=penalty, relax_coeff_nu=0.5,
                                                    tol=1e-10, max_iter=100000, unbias=False))

    def test_sr3_with_constraints(self):
        # by feature, as PySINDy wants them: coefficient of term j on target t is entry 3 j + t
        C, d = np.zeros((2, 21)), np.array([0.0, -0.02])
        C[0, 3 * 3 + 0] = C[0, 3 * 5 + 1] = 1.0
        C[1, 3 * 0 + 2] = 1.0
        for penalty, weight in (("l0", 1e-4), ("l1", 1e-2), ("l2", 0.1)):
            with self.subTest(penalty=penalty):
                found = self.identify("--optimizer", "sr3", "--penalty", penalty, "--lambda", weight, "--nu", 0.5,
                                      "--constraint", "fx[T sin theta] + fy[T sin phi] = 0", "--constraint", "fz[1] = -0.02")
                self.assertTrue(found["converged"])
                self.assert_same(found, pysindy.ConstrainedSR3(
                    reg_weight_lam=weight, regularizer=penalty, relax_coeff_nu=0.5, tol=1e-10, max_iter=100000,
                    constraint_lhs=C, constraint_rhs=d, constraint_order="feature", equality_constraints=True, unbias=False))

    def test_running_mean_and_trimmed_edges(self):
        def mean(x, window=7):
            # what touches the ends is cut off below
            return np.apply_along_axis(np.convolve, 0, x, np.ones(window) / window, mode="same")

        columns = self.flights[0]
        theta, target = regression(columns, smooth=mean)
        t = columns["time_s"]
        inside = (t >= t[0] + 0.5) & (t <= t[-1] - 0.5)
        found = self.identify("--optimizer", "stlsq", "--lambda", 0.002, "--smooth", 7, "--trim", 0.5, paths=self.paths[:1])
        self.assertEqual(found["samples"], np.count_nonzero(inside))
        self.assert_same(found, pysindy.STLSQ(threshold=0.002, max_iter=1000), theta[inside], target[inside])

    def test_savitzky_golay(self):
        from scipy.signal import savgol_filter

        # scipy's filter wants an even grid
        columns = dict(make_flight(2.0), time_s=0.02 * np.arange(1500))
        path = Path(self.folder.name) / "even.csv"
        write_flight(columns, path)
        theta, target = regression(columns, smooth=lambda x: savgol_filter(x, 11, 3, axis=0),
                                   derivative=lambda x: savgol_filter(x, 11, 3, deriv=1, delta=0.02, axis=0))
        found = self.identify("--optimizer", "stlsq", "--lambda", 0.002, "--derivative", "savitzky_golay", paths=[path])
        self.assert_same(found, pysindy.STLSQ(threshold=0.002, max_iter=1000), theta, target)


if __name__ == "__main__":
    unittest.main()
