"""Every file of the logs folder of the recorded flights: what the importer says of it; docs/LOGS.md has the same as a table."""

import json
import os
import unittest
from pathlib import Path

import numpy as np
from import_fixture import ImportCase
from pymavlink import DFReader

LOGS = Path(os.environ.get("GUSTLAB_FLIGHTS", ""), "logs")
# file -> (flights as (from, to) in whole seconds, rates that are known, words in the reason of what is refused)
KNOWN = {
    "px4_quad_55s.ulg": ([(7, 60)], dict(position=10, attitude=20, specific_force=198, u=49, vbat=5), "armed, on the ground"),
    "px4_hitl_jmavsim.ulg": ([(5, 70)], dict(position=10, specific_force=250, u=50), "gap: no sample for 8.9 s"),
    "px4_sitl_jmavsim_11s.ulg": ([(19, 26)], dict(position=10, u=50), "disarmed"),
    "px4_climb_28s.ulg": ([(6, 29)], dict(position=10, u=47), "the estimator was reset (heading by 0.39 rad)"),
    "px4_two_hops_9s.ulg": ([], {}, "too short: 1.0 s in the air"),
    "px4_bench_disarmed.ulg": ([], {}, "never armed"),
    "px4_vtol_gap.ulg": ([], {}, "a VTOL"),
    "px4_fixed_wing_6s.ulg": ([], {}, "a fixed-wing aircraft"),
    "ardupilot_rtl_51s.bin": ([(0, 51)], dict(position=10, u=10, vbat=10), "disarmed"),
    "ardupilot_quad_136s.bin": ([(15, 152)], dict(attitude=50, u=10, vbat=0), "too short: 1.3 s"),
    "iris_telemetry.tlog": ([], {}, "cannot be judged at 2.5 Hz"),
    "betaflight_122s.bfl": ([(1, 137)], dict(position=0, body_rate=983, u=983), "on the ground"),
    "ros1_imu_thrust_a.bag": ([], {}, "att_throttle is a collective command without a known unit"),
    "ros1_imu_thrust_b.bag": ([], {}, "att_throttle is a collective command without a known unit"),
    "ros2_pose_imu_battery.db3": ([], {}, "no motor commands"),
}


@unittest.skipUnless(LOGS.is_dir(), "GUSTLAB_FLIGHTS is not set, or has no logs: the logs of flight computers were not read")
class FlightComputers(ImportCase):
    def take(self, name: str, *more) -> tuple:
        code, out, err = self.run_import(LOGS / name, "--format", "json", "--out", self.out, *more)
        return code, json.loads(out)["logs"][0], err

    def test_every_file(self):
        for name, (flights, rates, refused) in KNOWN.items():
            with self.subTest(name):
                code, log, err = self.take(name)
                self.assertEqual([(round(f["from_s"]), round(f["to_s"])) for f in log["flights"]], flights)
                self.assertEqual(code, 0 if flights else 3, err)
                for quantity, hz in rates.items():
                    self.assertEqual(log["flights"][0]["rates_hz"][quantity], hz, quantity)
                self.assertIn(refused, " | ".join(part["why"] for part in log["refused"]))
                self.assertFalse([f for f in log["findings"] if f["severity"] == "error"])

    def test_hover_of_the_quadrotor_and_gravity(self):
        self.take("px4_quad_55s.ulg")
        written = self.written("px4_quad_55s_1.csv")
        u = np.array([np.nanmedian(written[f"u{k}"]) for k in (1, 2, 3, 4)])
        self.assertAlmostEqual(u.mean(), 0.220, delta=0.01)
        self.assertAlmostEqual(float(np.nanmedian(written["az"])), 9.81, delta=0.3)
        self.assertGreater(np.nanmax(written["pz"]), 0.9)

    def test_the_known_thrust_of_the_hardware_in_the_loop(self):
        self.take("px4_hitl_jmavsim.ulg")
        written = self.written("px4_hitl_jmavsim_1.csv")
        # 4 x 4 N linear in the command, 0.8 kg
        thrust_N = 4.0 * sum(np.nanmean(written[f"u{k}"][written["time_s"] > 20.0]) for k in (1, 2, 3, 4))
        self.assertAlmostEqual(thrust_N / (0.8 * 9.80665), 1.0, delta=0.02)

    def test_the_vtols_gap_is_said(self):
        _, log, _ = self.take("px4_vtol_gap.ulg")
        self.assertFound(log["findings"], "gap", "nothing at all was logged for 19.5 min")

    def test_the_crash_is_said(self):
        _, log, _ = self.take("ardupilot_quad_136s.bin")
        self.assertFound(log["findings"], "gap", "the vehicle's crash check fired, and the log ends")

    def test_the_description_of_a_bag_is_no_log(self):
        code, _, err = self.run_import(LOGS / "ros2_metadata.yaml", "--out", self.out)
        self.assertEqual((code, "give the .db3 or .mcap beside it" in err), (2, True), err)

    def test_a_voltage_that_reads_nothing_is_not_used(self):
        _, log, _ = self.take("ardupilot_quad_136s.bin")
        self.assertFound(log["findings"], "out_of_range", "reads 0.0 to 0.0 V: not used")

    def test_shares_of_thrust_are_the_autopilots_own_throttle(self):
        def throttle(name, message, field, time):
            log, found = DFReader.DFReader_binary(str(LOGS / name)), []
            while (m := log.recv_match(type=[message, "IMU"])) is not None:
                found.append((getattr(m, time), getattr(m, field) if m.get_type() == message else np.nan))
            at, value = np.array(found, dtype=float).T
            at = (at - at.min()) * (1e-6 if time == "TimeUS" else 1e-3)
            return at[np.isfinite(value)], value[np.isfinite(value)]

        # RATE.AOut is before the compensation for thin air, which divides by the density (0.97 here); old logs have none
        for name, message, field, time, scale, within in (("ardupilot_rtl_51s.bin", "RATE", "AOut", "TimeUS", 1.0, (1.02, 1.04)),
                                                          ("ardupilot_quad_136s.bin", "CTUN", "ThrOut", "TimeMS", 1e-3, (0.995, 1.005))):
            with self.subTest(name):
                self.take(name)
                written = self.written(name[:-4] + "_1.csv")
                rows = np.isfinite(written["u1"])
                mean = np.mean([written[f"u{k}"][rows] for k in (1, 2, 3, 4)], axis=0)
                asked = scale * np.interp(written["time_s"][rows], *throttle(name, message, field, time))
                ratio = mean[asked > 0.05] / asked[asked > 0.05]
                self.assertTrue(within[0] < np.median(ratio) < within[1], np.median(ratio))
                self.assertLess(np.subtract(*np.percentile(ratio, (75, 25))), 0.01)

    def test_blackbox_axes(self):
        self.take("betaflight_122s.bfl")
        written = self.written("betaflight_122s_1.csv")
        width = 20
        rate = np.column_stack([np.convolve(written[n], np.ones(width) / width, "same") for n in ("wx", "wy", "wz")])
        u = np.column_stack([np.convolve(written[f"u{k}"], np.ones(width) / width, "same") for k in (1, 2, 3, 4)])
        turned = np.gradient(rate, axis=0)[25:]
        mix = np.linalg.lstsq(u[:-25] - u.mean(axis=0), turned, rcond=None)[0]
        # motors rear right, front right, rear left, front left; the right ones roll left, the rear ones pitch down (y left)
        self.assertEqual([list(np.sign(column)) for column in mix.T[:2]], [[-1, -1, 1, 1], [1, -1, 1, -1]])
        # the propellers of rear right and front left turn clockwise: more of them yaws to the left
        self.assertEqual(list(np.sign(mix.T[2])), [1, -1, -1, 1])

    def test_thrust_of_the_ros_bags_by_a_map(self):
        text = """format = "gustlab-column-map/1"
kind = "ros"
vehicle = "crazyflie"
[time]
column = "time"
[rate]
columns = ["/jay/mavros/imu/data.angular_velocity.x", "/jay/mavros/imu/data.angular_velocity.y", "/jay/mavros/imu/data.angular_velocity.z"]
[acceleration]
columns = ["/jay/mavros/imu/data.linear_acceleration.x", "/jay/mavros/imu/data.linear_acceleration.y", "/jay/mavros/imu/data.linear_acceleration.z"]
[attitude]
columns = ["/jay/mavros/imu/data.orientation.w", "/jay/mavros/imu/data.orientation.x", "/jay/mavros/imu/data.orientation.y", "/jay/mavros/imu/data.orientation.z"]
order = "wxyz"
[actuator]
kind = "collective_thrust"
columns = ["/jay/mavros/setpoint_attitude/att_throttle.data"]
scale = 30.0
"""
        code, log, _ = self.take("ros1_imu_thrust_a.bag", "--map", self.write("ros.toml", text))
        self.assertEqual((code, log["flights"][0]["rates_hz"]["u"]), (0, 19), log["findings"])


if __name__ == "__main__":
    unittest.main()
