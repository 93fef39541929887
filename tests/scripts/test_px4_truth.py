"""A vehicle that differs from its file, logged as PX4's default profile logs it: from the ULog to the truth in two commands."""

import csv
import json
import os
import subprocess
import unittest
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from ulog_fixture import MIX, px4_flight

PROGRAM = os.environ["GUSTLAB_PROGRAM"]
COEFFICIENT, FULL_N = 1.2e-5, 6.5  # N/(rad/s)^2, and of a rotor at full command

# PX4's motors 1 to 4: front right, back left, front left, back right
MJCF = """<mujoco><compiler inertiafromgeom="false"/><worldbody><body name="quad" pos="0 0 1"><freejoint/>
<inertial pos="0 0 0" mass="1.2" diaginertia="0.012 0.012 0.02"/><geom type="box" size="0.15 0.15 0.04"/>
<site name="m1" pos="0.17 -0.17 0"/><site name="m2" pos="-0.17 0.17 0"/><site name="m3" pos="0.17 0.17 0"/><site name="m4" pos="-0.17 -0.17 0"/>
</body></worldbody></mujoco>
"""
VEHICLE = 'format = "gustlab-vehicle/1"\nname = "quad"\nmjcf = "quad.xml"\n' + "".join(
    f'[[rotor]]\nsite = "m{k}"\ndirection = "{turn}"\n' for k, turn in enumerate(("ccw", "ccw", "cw", "cw"), 1)) + f"""
[thrust]
coefficient = {COEFFICIENT}
torque_ratio = 0.016
max_speed_radps = {np.sqrt(FULL_N / COEFFICIENT):.1f}
radius_m = 0.127
[actuator]
throttle_thrust = [0.0, {FULL_N}, 0.0]
[[effect]]
type = "motor_lag"
time_constant = 0.03
"""
MASS, DRAG = 0.08, 0.3
REAL = f"""format = "gustlab-experiment/1"
name = "real"
vehicle = "quad/vehicle.toml"
trajectories = ["multisine", "lemniscate"]
controllers = ["geometric"]
first_replicate = 0
replicates = 2
duration_s = 30
step_s = 0.002
[controller.geometric]
rate_hz = 100
[[effect]]
type = "gust"
sigma_xy = 0.3
sigma_z = 0.15
correlation_time = 1.0
[[effect]]
type = "measurement_noise"
rate_sd = 0.002
accelerometer_sd = 0.05
"""
# of what the estimator logs; the loops fly what is smooth
POSITION_m, VELOCITY_mps, ATTITUDE_rad = 0.005, 0.01, 0.001
CONCEALED = f"""[[effect]]
type = "mass"
delta = {MASS}
[[effect]]
type = "rotor_drag"
at_hover = {DRAG}
"""
MINE = {"mass", "rotor_drag", "gust"}


def flown(path: Path, seed: int) -> dict:
    """A flight log of 500 rows a second as px4_flight takes it: 250 a second, inertial samples means over the interval before them."""
    noise = np.random.default_rng(seed)
    with open(path, encoding="utf-8") as file:
        names, *rows = csv.reader(file)
    table = dict(zip(names, np.array(rows, dtype=float).T))

    def block(*columns):
        return np.column_stack([table[name] for name in columns])

    def noisy(values, sd):
        return values + noise.normal(0.0, sd, values.shape)

    def means(values):
        # Simpson's rule over two rows
        return np.vstack([values[:1], (values[:-2:2] + 4.0 * values[1:-1:2] + values[2::2]) / 6.0])

    odd = len(table["time_s"]) - (len(table["time_s"]) + 1) % 2
    table = {name: values[:odd] for name, values in table.items()}
    share = COEFFICIENT * block("u1", "u2", "u3", "u4")**2 / FULL_N
    asked = np.linalg.solve(MIX, share.T).T
    q = noisy(block("qw", "qx", "qy", "qz")[::2], ATTITUDE_rad / 2.0)
    return {"time_s": table["time_s"][::2], "p": noisy(block("px", "py", "pz")[::2], POSITION_m), "v": noisy(block("vx", "vy", "vz")[::2], VELOCITY_mps),
            "q": q / np.linalg.norm(q, axis=1, keepdims=True), "w": means(block("wx", "wy", "wz")), "a": means(block("ax", "ay", "az")),
            "torque": asked[::2, :3], "thrust": asked[::2, 3]}


class Truth(unittest.TestCase):
    def setUp(self):
        folder = TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "quad").mkdir()
        (self.folder / "quad" / "quad.xml").write_text(MJCF)
        (self.folder / "quad" / "vehicle.toml").write_text(VEHICLE)

    def call(self, *arguments):
        done = subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=900)
        self.assertEqual(done.returncode, 0, f"{arguments}\n{done.stdout}\n{done.stderr}")

    def diagnosis(self, experiment: str) -> dict:
        """What two commands say of three ULogs of this vehicle"""
        (self.folder / "real.toml").write_text(experiment)
        for seed, (name, trajectory, replicate) in enumerate((("one", "multisine", "0"), ("two", "lemniscate", "0"), ("three", "multisine", "1"))):
            self.call("run", "real.toml", "--trajectory", trajectory, "--controller", "geometric", "--replicate", replicate, "--out", name)
            log = px4_flight(flown(self.folder / name / "flight.csv", seed), armed=(0.5, 29.5), flying=(1.0, 29.0))
            (self.folder / f"{name}.ulg").write_bytes(log.bytes())
        self.call("import", "one.ulg", "two.ulg", "three.ulg", "--out", "logs", "--vehicle", "quad/vehicle.toml")
        document = json.loads((self.folder / "logs" / "import.json").read_text())
        for log in document["logs"]:
            self.assertEqual([flight["rates_hz"]["u"] for flight in log["flights"]], [50], log)
            self.assertEqual([flight["rates_hz"]["position"] for flight in log["flights"]], [10], log)
        self.call("diagnose", "logs/one_1.csv", "logs/two_1.csv", "--holdout", "logs/three_1.csv", "--out", "diagnosis")
        return json.loads((self.folder / "diagnosis" / "diagnosis.json").read_text())

    @pytest.mark.slow
    def test_weight_and_drag_are_named_with_their_sizes(self):
        found = self.diagnosis(REAL + CONCEALED)
        sizes = {effect["effect"]: {name: value["value"] for name, value in effect["parameters"].items()} for effect in found["effects"]}
        self.assertLessEqual({"mass", "rotor_drag"}, set(sizes), sizes)
        self.assertLessEqual(set(sizes), MINE, sizes)
        self.assertAlmostEqual(sizes["mass"]["delta"], MASS, delta=0.3 * MASS)
        self.assertAlmostEqual(sizes["rotor_drag"]["at_hover"], DRAG, delta=0.3 * DRAG)

    @pytest.mark.slow
    def test_a_vehicle_that_is_as_its_file_says_is_given_no_name(self):
        found = self.diagnosis(REAL)
        self.assertLessEqual({effect["effect"] for effect in found["effects"]}, {"gust"}, found["effects"])


if __name__ == "__main__":
    unittest.main()
