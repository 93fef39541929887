"""Does the importer notice what is wrong with a recording, and stay quiet when nothing is?"""

import unittest

import numpy as np
from import_fixture import MAP, ImportCase, conjugate, csv, flight, rotate

GYRO, FORCE, VELOCITY = ("gx", "gy", "gz"), ("ax", "ay", "az"), ("vx", "vy", "vz")


def attitude(columns):
    return np.column_stack([columns[name] for name in ("qw", "qx", "qy", "qz")])


class Quiet(ImportCase):
    def test_a_consistent_flight_has_nothing_to_report(self):
        code, findings, err = self.inspect(flight())
        self.assertEqual((code, findings, err), (0, [], ""))

    def test_noise_is_measured(self):
        log = self.write("log.csv", csv(flight()))
        _, out, _ = self.run_import(log, "--map", self.map, "--format", "json")
        import json
        noise = json.loads(out)["logs"][0]["flights"][0]["noise"]
        self.assertAlmostEqual(noise["wx"], 5e-3, delta=1e-3)
        self.assertAlmostEqual(noise["az"], 0.05, delta=0.01)
        # many numbers before the answer
        for more, said in (((), False), (("-v",), True)):
            self.assertEqual("noise from sample to sample" in self.run_import(log, "--map", self.map, *more)[1], said)


class Frames(ImportCase):
    def test_wrong_quaternion_order(self):
        code, findings, err = self.inspect(flight(), MAP.replace('order = "xyzw"', 'order = "wxyz"'))
        self.assertEqual(code, 3)
        self.assertFound(findings, "frame", "the other quaternion order", "error")
        self.assertIn("correct the map", err)
        self.assertFalse(self.out.exists())

    def test_inverted_attitude(self):
        _, findings, _ = self.inspect(flight(), MAP.replace('order = "xyzw"', 'order = "xyzw"\nrotates = "world_to_body"'))
        self.assertFound(findings, "frame", "world_to_body", "error")

    def test_body_frame_velocity_called_world(self):
        columns = flight()
        body = rotate(conjugate(attitude(columns)), np.column_stack([columns[n] for n in VELOCITY]))
        columns.update(zip(VELOCITY, body.T))
        code, findings, _ = self.inspect(columns)
        self.assertEqual(code, 3)
        self.assertFound(findings, "frame", 'frame = "body"', "error")

    def test_body_frame_velocity_is_turned_into_the_world(self):
        columns = flight()
        world = np.column_stack([columns[n] for n in VELOCITY])
        columns.update(zip(VELOCITY, rotate(conjugate(attitude(columns)), world).T))
        code, findings, _ = self.inspect(columns, MAP.replace('frame = "world"', 'frame = "body"'))
        self.assertEqual((code, findings), (0, []))
        np.testing.assert_allclose(self.written()["vx"], world[:, 0], atol=1e-7)

    def test_world_frame_velocity_called_body(self):
        _, findings, _ = self.inspect(flight(), MAP.replace('frame = "world"', 'frame = "body"'))
        self.assertFound(findings, "frame", 'frame = "world"', "error")

    def test_rate_in_a_body_frame_with_z_down(self):
        columns = flight()
        columns["gy"], columns["gz"] = -columns["gy"], -columns["gz"]
        code, findings, _ = self.inspect(columns)
        self.assertEqual(code, 3)
        self.assertFound(findings, "sign", "y right and z down", "error")

    def test_one_gyroscope_axis_reversed(self):
        columns = flight()
        columns["gx"] = -columns["gx"]
        self.assertFound(self.inspect(columns)[1], "sign", "opposite sign of wx", "error")

    def test_accelerometer_upside_down(self):
        columns = flight()
        columns["az"] = -columns["az"]
        self.assertFound(self.inspect(columns)[1], "sign", "along z in hover", "error")

    def test_rate_in_the_world_frame(self):
        columns = flight()
        columns.update(zip(GYRO, rotate(attitude(columns), np.column_stack([columns[n] for n in GYRO])).T))
        self.assertFound(self.inspect(columns)[1], "frame", "given in the world", "error")

    def test_unrelated_attitude_and_rate(self):
        columns = flight()
        for k, name in enumerate(GYRO):
            columns[name] = np.sin((3.0 + 1.7 * k) * columns["t"] ** 1.3)
        self.assertFound(self.inspect(columns)[1], "inconsistent", "hardly agree")


class Units(ImportCase):
    def test_degrees_called_radians(self):
        columns = flight()
        for name in GYRO:
            columns[name] = np.degrees(columns[name])
        code, findings, _ = self.inspect(columns)
        self.assertEqual(code, 3)
        self.assertFound(findings, "unit", 'unit = "deg/s"', "error")

    def test_radians_called_degrees(self):
        _, findings, _ = self.inspect(flight(), MAP.replace('unit = "rad/s"', 'unit = "deg/s"'))
        self.assertFound(findings, "unit", 'unit = "rad/s"', "error")

    def test_g_called_metres(self):
        columns = flight()
        for name in FORCE:
            columns[name] = columns[name] / 9.80665
        code, findings, _ = self.inspect(columns)
        self.assertEqual(code, 3)
        self.assertFound(findings, "unit", 'unit = "g"', "error")

    def test_metres_called_g(self):
        self.assertFound(self.inspect(flight(), MAP.replace('"m/s^2"', '"g"'))[1], "unit", 'unit = "m/s^2"', "error")

    def test_gravity_removed(self):
        columns = flight()
        columns["az"] = columns["az"] - 9.81
        self.assertFound(self.inspect(columns)[1], "inconsistent", "gravity was removed", "error")

    def test_velocity_in_centimetres(self):
        columns = flight()
        for name in VELOCITY:
            columns[name] = 100.0 * columns[name]
        self.assertFound(self.inspect(columns)[1], "unit", "times the derivative of the position", "error")

    def test_velocity_that_is_ten_percent_large(self):
        columns = flight()
        columns["vx"] = 1.1 * columns["vx"]
        self.assertFound(self.inspect(columns)[1], "inconsistent", "vx 1.1", "warning")

    def test_pwm_beyond_sixteen_bits(self):
        columns = flight()
        columns["m2"][500:700] = 90000.0
        code, findings, _ = self.inspect(columns)
        self.assertEqual(code, 3)
        self.assertFound(findings, "out_of_range", "outside 0 to 65535", "error")


class Quaternions(ImportCase):
    def test_norm_drift_is_repaired(self):
        columns = flight()
        for name in ("qx", "qy", "qz", "qw"):
            columns[name] = columns[name] * 1.01
        code, findings, _ = self.inspect(columns)
        self.assertEqual(code, 0)
        self.assertTrue(self.assertFound(findings, "inconsistent", "normalised", "note")["repaired"])
        written = self.written()
        np.testing.assert_allclose(sum(written["q" + k] ** 2 for k in "wxyz"), 1.0, atol=1e-7)

    def test_norm_that_is_off(self):
        columns = flight()
        columns["qw"][800] += 0.1
        code, findings, _ = self.inspect(columns)
        self.assertEqual(code, 3)
        self.assertIn("log.csv:802: column `qw`", self.assertFound(findings, "inconsistent", "|q| is", "error")["says"])

    def test_sign_flips_are_removed(self):
        columns = flight()
        for name in ("qx", "qy", "qz", "qw"):
            columns[name][300:900] *= -1.0
        code, findings, _ = self.inspect(columns)
        self.assertEqual(code, 0)
        self.assertTrue(self.assertFound(findings, "sign", "changes its sign 2 times")["repaired"])
        self.assertLess(np.max(np.abs(np.diff(self.written()["qw"]))), 0.1)


class Rows(ImportCase):
    def test_gap(self):
        columns = {name: np.delete(values, np.arange(700, 730)) for name, values in flight().items()}
        self.assertIn("310.0 ms at 6.99 s", self.assertFound(self.inspect(columns)[1], "gap", "1 gaps")["says"])

    def test_duplicate_rows_are_dropped(self):
        columns = {name: np.insert(values, 50, values[50]) for name, values in flight().items()}
        code, findings, _ = self.inspect(columns)
        self.assertEqual(code, 0)
        self.assertTrue(self.assertFound(findings, "duplicate", "1 rows repeat")["repaired"])
        self.assertEqual(len(self.written()["time_s"]), 2000)

    def test_repeated_values_at_new_times(self):
        columns = flight()
        for name in columns.keys() - {"t"}:
            columns[name][100:103] = columns[name][99]
        self.assertFound(self.inspect(columns)[1], "duplicate", "3 rows repeat every value", "warning")

    def test_time_that_runs_backward(self):
        columns = flight()
        columns["t"][400] = 3.0
        code, _, err = self.inspect(columns)
        self.assertEqual(code, 3)
        self.assertIn("log.csv:402: column `t`: time runs backward", err)
        self.assertFalse(self.out.exists())

    def test_time_that_stands_still(self):
        columns = flight()
        columns["t"][400] = columns["t"][399]
        code, _, err = self.inspect(columns)
        self.assertEqual(code, 3)
        self.assertIn("stands still while other columns change", err)

    def test_not_a_number_becomes_no_sample(self):
        text = csv(flight()).splitlines()
        cells = text[41].split(",")
        cells[5] = "nan"
        text[41] = ",".join(cells)
        log = self.write("log.csv", "\n".join(text) + "\n")
        code, out, _ = self.run_import(log, "--map", self.map, "--out", self.out)
        self.assertEqual(code, 0)
        self.assertIn("not a number or infinite (first at log.csv:42)", out)
        self.assertTrue(np.isnan(self.written()["vy"][40]))

    def test_ground_is_left_out(self):
        columns = flight()
        for name in ("m1", "m2", "m3", "m4"):
            columns[name][:300] = 0.0
            columns[name][1800:] = 0.0
        columns["z"][:300] = 0.05
        code, findings, _ = self.inspect(columns, 'trim = "airborne"\n' + MAP)
        self.assertEqual(code, 0)
        self.assertFound(findings, "ground", "flight: 3.00 to 17.99 s")
        self.assertEqual(len(self.written()["time_s"]), 1500)

    def test_rotors_never_run(self):
        columns = flight()
        for name in ("m1", "m2", "m3", "m4"):
            columns[name][:] = 0.0
        code, findings, _ = self.inspect(columns)
        self.assertEqual(code, 3)
        self.assertFound(findings, "ground", "zero all the time", "error")


class Columns(ImportCase):
    def test_frozen_battery(self):
        columns = flight()
        columns["bat"][:] = 3.9
        self.assertFound(self.inspect(columns)[1], "frozen", "battery never changes", "warning")

    def test_frozen_pose_for_a_second(self):
        columns = flight()
        for name in ("x", "y", "z"):
            columns[name][600:710] = columns[name][600]
        found = self.assertFound(self.inspect(columns)[1], "frozen", "position stands still for 1.09 s", "warning")
        self.assertAlmostEqual(found["from_s"], 6.0)

    def test_frozen_rate(self):
        columns = flight()
        for name in GYRO:
            columns[name][:] = 0.0
        self.assertEqual(self.inspect(columns)[0], 3)

    def test_held_rate(self):
        columns = flight()
        for name in GYRO:
            columns[name] = np.repeat(columns[name][::4], 4)
        self.assertIn("at about 25 Hz", self.assertFound(self.inspect(columns)[1], "held", "body rate")["says"])

    def test_interpolated_commands(self):
        columns = flight()
        for name in ("m1", "m2", "m3", "m4"):
            columns[name] = np.interp(columns["t"], columns["t"][::5], columns[name][::5])
        self.assertIn("at about 20 Hz", self.assertFound(self.inspect(columns)[1], "held", "interpolated")["says"])

    def test_telemetry_that_was_extrapolated(self):
        columns, last = flight(), 1700
        for name in GYRO + FORCE + ("m1", "m2", "m3", "m4"):
            slope = columns[name][last] - columns[name][last - 1]
            columns[name][last:] = columns[name][last] + slope * np.arange(len(columns[name]) - last)
        code, findings, err = self.inspect(columns)
        self.assertEqual(code, 3)
        self.assertFound(findings, "inconsistent", "corrupt: body rate, specific force, actuators: nothing was received")
        self.assertIn("--to 16.9", err)
        code, findings, _ = self.inspect(columns, MAP, "--to", 16.9)
        self.assertEqual((code, findings), (0, []))

    def test_low_pass_filtered_rate(self):
        columns, width = flight(), 60
        frequency = np.fft.rfftfreq(len(columns["t"]), 0.01)
        for name in GYRO:
            columns[name] = np.fft.irfft(np.fft.rfft(columns[name]) / (1.0 + (frequency / 12.0) ** width), len(columns["t"]))
        self.assertFound(self.inspect(columns)[1], "filtered", "body rate: nothing faster than about 1", "warning")

    def test_saturated_command(self):
        columns = flight()
        columns["m3"][1000:1400] = 65535.0
        self.assertFound(self.inspect(columns)[1], "out_of_range", "saturated at 65535 in 20.0 %", "note")


class Offsets(ImportCase):
    def test_late_pose(self):
        columns, late = flight(seconds=22.0), flight(seconds=22.0)
        for name in GYRO:
            columns[name] = columns[name][3:]
        columns = {name: (values if name in GYRO else late[name][:len(late[name]) - 3]) for name, values in columns.items()}
        found = self.assertFound(self.inspect(columns)[1], "delay", "body rate is 30", "note")
        self.assertIn("earlier than attitude", found["says"])

    def test_offset_that_jumps(self):
        columns = flight(seconds=40.0)
        for name in GYRO:
            columns[name][2000:] = np.roll(columns[name], -10)[2000:]
        self.assertFound(self.inspect(columns)[1], "delay", "the time offset is not constant, -10", "warning")

    def test_late_commands(self):
        columns = flight(seconds=30.0)
        wave = np.random.default_rng(3).normal(0, 1, (4, 3000))
        wave = np.array([np.convolve(row, np.hanning(15), "same") for row in wave])
        torque = wave[2] + wave[3] - wave[0] - wave[1], wave[1] + wave[2] - wave[0] - wave[3]
        for name, values in zip(("m1", "m2", "m3", "m4"), wave):
            columns[name] = 38000.0 + 1000.0 * values
        for name, values in zip(GYRO, torque):
            columns[name] = columns[name] * 0.0 + np.cumsum(np.roll(values, 5)) * 0.02
        found = self.assertFound(self.inspect(columns)[1], "delay", "after the actuator inputs")
        self.assertRegex(found["says"], r"come (4[5-9]|5[0-5])\.\d ms after")


if __name__ == "__main__":
    unittest.main()
