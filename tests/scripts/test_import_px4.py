"""PX4 logs that the test writes: frames, rates, allocation, flights and refusals."""

import json
import os
import re
import subprocess
import tomllib
import unittest
from pathlib import Path

import jsonschema
import numpy as np
from import_fixture import ImportCase, flight
from gustlab_import.ulog_damage import without_damage
from ulog_fixture import MIX, ULogFile, px4_flight

SCHEMA = json.loads((Path(__file__).resolve().parents[2] / "schemas" / "import.schema.json").read_text(encoding="utf-8"))


def synthetic(seconds: float = 20.0, seed: int = 1) -> dict:
    columns = flight(seconds, 250.0, seed)
    t = columns["t"]

    def block(names):
        return np.column_stack([columns[name] for name in names.split()])

    torque = np.column_stack([0.05 * np.sin(7.0 * t), 0.04 * np.sin(9.0 * t + 1.0), 0.03 * np.sin(5.0 * t + 2.0)])
    return {"time_s": t, "p": block("x y z"), "v": block("vx vy vz"), "q": block("qw qx qy qz"), "w": block("gx gy gz"),
            "a": block("ax ay az"), "torque": torque, "thrust": 0.5 + 0.05 * np.sin(2.3 * t)}


class PX4(ImportCase):
    def take(self, log: ULogFile, *more) -> tuple:
        """(exit code, the log's entry of import.json, stderr)"""
        path = self.write("flight.ulg", log.bytes())
        code, out, err = self.run_import(path, "--out", self.out, "--format", "json", *more)
        if out:
            jsonschema.validate(json.loads(out), SCHEMA)
        return code, json.loads(out)["logs"][0] if out else {}, err

    def test_frames_rates_and_times(self):
        truth = synthetic()
        code, log, err = self.take(px4_flight(truth))
        self.assertEqual((code, err, len(log["flights"])), (0, "", 1))
        self.assertEqual((log["kind"], log["airframe"]), ("px4-ulog", "quadrotor x"))
        self.assertEqual(log["flights"][0]["rates_hz"], {"position": 10, "velocity": 10, "attitude": 21, "body_rate": 250,
                                                         "specific_force": 250, "u": 50, "rotor": 0, "vbat": 5})
        self.assertEqual((log["flights"][0]["from_s"], log["flights"][0]["to_s"]), (3.0, 17.0))
        written = self.written("flight_1.csv")
        for names, key in ((("px", "py", "pz"), "p"), (("vx", "vy", "vz"), "v"), (("wx", "wy", "wz"), "w"), (("ax", "ay", "az"), "a")):
            rows = np.isfinite(written[names[0]])
            place = np.rint(written["time_s"][rows] * 250).astype(int)
            np.testing.assert_allclose(written["time_s"][rows], truth["time_s"][place], atol=1.1e-6)
            np.testing.assert_allclose(np.column_stack([written[n][rows] for n in names]), truth[key][place], rtol=1e-6, atol=1e-6)
        rows = np.isfinite(written["qw"])
        q = np.column_stack([written[n][rows] for n in ("qw", "qx", "qy", "qz")])
        same = np.abs(np.sum(q * truth["q"][np.rint(written["time_s"][rows] * 250).astype(int)], axis=1))
        np.testing.assert_allclose(same, 1.0, atol=1e-6)
        self.assertFalse([f for f in log["findings"] if f["severity"] == "error"], log["findings"])

    def test_motors_between_samples_come_from_the_set_points(self):
        truth = synthetic()
        _, log, _ = self.take(px4_flight(truth))
        self.assertRegex(log["flights"][0]["sources"]["u"], r"actuator_motors\[0\] 10 Hz and torque and thrust set points 50 Hz \(agree to")
        written = self.written("flight_1.csv")
        rows = np.isfinite(written["u1"])
        u = np.column_stack([written[f"u{k}"][rows] for k in (1, 2, 3, 4)])
        place = np.rint((written["time_s"][rows] - 2e-4) * 250).astype(int)
        wanted = np.column_stack([truth["torque"], truth["thrust"]])[place] @ MIX.T
        np.testing.assert_allclose(u, wanted, atol=2e-6)

    def with_speeds(self, rate_hz: int, functions=None, swapped=False):
        """A log whose four speed controllers report 6000 to 9000 rpm; the written flight, if any, and the log's entry"""
        truth = synthetic()
        log, every = px4_flight(truth), slice(0, None, 250 // rate_hz)
        rpm = np.zeros((len(truth["time_s"]), 8), dtype=int)
        rpm[:, :4] = np.rint(np.array([6000, 7000, 8000, 9000]) + 100 * np.sin(truth["time_s"])[:, None])
        if swapped:
            rpm[:, :4] = rpm[:, [3, 2, 1, 0]]
        log.esc_status(truth["time_s"][every], rpm[every], functions)
        _, entry, _ = self.take(log)
        return self.written("flight_1.csv"), entry

    def test_speeds_that_the_controllers_report(self):
        written, log = self.with_speeds(125)
        rows = np.isfinite(written["rotor1"])
        self.assertEqual(log["flights"][0]["rates_hz"]["rotor"], 125)
        for k, base in enumerate((6000, 7000, 8000, 9000), 1):
            wanted = np.rint(base + 100 * np.sin(written["time_s"][rows])) * 2 * np.pi / 60
            np.testing.assert_allclose(written[f"rotor{k}"][rows], wanted, rtol=1e-6)

    def test_speeds_go_to_the_motor_that_they_are_of(self):
        written, _ = self.with_speeds(125, functions=[104, 103, 102, 101, 0, 0, 0, 0], swapped=True)
        rows = np.isfinite(written["rotor1"])
        np.testing.assert_allclose(written["rotor1"][rows].mean(), 6000 * 2 * np.pi / 60, rtol=0.01)
        np.testing.assert_allclose(written["rotor4"][rows].mean(), 9000 * 2 * np.pi / 60, rtol=0.01)

    def test_speeds_that_come_too_seldom_are_said_and_not_used(self):
        written, log = self.with_speeds(5)
        self.assertNotIn("rotor1", written)
        self.assertIn("rotor speeds of esc_status[0] come at 5 Hz, more seldom than the motors' commands at 50 Hz: not used",
                      [f["says"] for f in log["findings"]])

    def test_outputs_are_behind_the_thrust_curve_and_motors_before_it(self):
        truth = synthetic()
        share = np.column_stack([truth["torque"], truth["thrust"]]) @ MIX.T
        factor = 0.3
        # as the driver does it: the signal whose thrust f s^2 + (1 - f) s is the share
        signal = (np.sqrt((1 - factor)**2 + 4 * factor * share) - (1 - factor)) / (2 * factor)
        pulses = np.zeros((len(signal), 16))
        pulses[:, :4] = 1000.0 + 1000.0 * signal
        log = px4_flight(truth, motors_logged=False)
        log.parameter("THR_MDL_FAC", factor)
        log.topic("actuator_outputs", truth["time_s"], {"uint32_t noutputs": np.full(len(pulses), 4), "float[16] output": pulses})
        _, entry, _ = self.take(log)
        self.assertIn("back through THR_MDL_FAC 0.3", entry["flights"][0]["sources"]["u"])
        written = self.written("flight_1.csv")
        rows = np.isfinite(written["u1"])
        place = np.rint(written["time_s"][rows] * 250).astype(int)
        np.testing.assert_allclose(np.column_stack([written[f"u{k}"][rows] for k in (1, 2, 3, 4)]), share[place], atol=2e-6)

    def test_set_points_that_contradict_the_motors_are_not_used(self):
        truth = synthetic()
        log = px4_flight(truth)
        shaken = dict(truth, torque=truth["torque"] + 0.02 * np.random.default_rng(2).normal(size=truth["torque"].shape))
        other = px4_flight(shaken)
        # the motors of one flight beside the set points of another
        numbers = {name: k for k, name in enumerate(log.formats)}
        keep = [numbers["vehicle_torque_setpoint"]]
        take = [d for d in other.data if d[0] >= 0 and int.from_bytes(d[1][3:5], "little") in keep]
        log.data = [d for d in log.data if d[0] < 0 or int.from_bytes(d[1][3:5], "little") not in keep] + take
        _, entry, _ = self.take(log)
        self.assertEqual(entry["flights"][0]["rates_hz"]["u"], 10)
        self.assertIn("the set points miss their samples", (self.out / "flight_1.meta.toml").read_text())

    def test_the_instance_that_holds_the_motors(self):
        _, log, _ = self.take(px4_flight(synthetic(), instance=1))
        self.assertIn("actuator_motors[1]", log["flights"][0]["sources"]["u"])

    def test_motors_go_into_the_vehicles_order(self):
        self.write("q.xml", '<mujoco><worldbody><body><site name="a" pos="-1 1 0"/><site name="b" pos="1 1 0"/>'
                            '<site name="c" pos="1 -1 0"/><site name="d" pos="-1 -1 0"/></body></worldbody></mujoco>')
        rotors = "".join(f'[[rotor]]\nsite = "{s}"\ndirection = "{d}"\n' for s, d in (("a", "ccw"), ("b", "cw"), ("c", "ccw"), ("d", "cw")))
        vehicle = self.write("vehicle.toml", 'format = "gustlab-vehicle/1"\nname = "q"\nmjcf = "q.xml"\n' + rotors
                             + "[thrust]\nhover = 0.5\n")
        _, log, _ = self.take(px4_flight(synthetic()), "--vehicle", vehicle)
        # back left, front left, front right, back right are PX4's motors 2, 3, 1, 4
        self.assertIn("the log's motors 2, 3, 1, 4", log["flights"][0]["sources"]["u"])
        self.assertEqual(tomllib.loads((self.out / "flight_1.meta.toml").read_text())["vehicle"], "../vehicle.toml")

    def test_a_vehicle_with_another_number_of_rotors(self):
        code, _, err = self.take(px4_flight(synthetic()), "--vehicle", self.hexa())
        self.assertEqual((code, "4 motors are logged and the vehicle ../hexa.toml has 6 rotors" in err), (2, True), err)

    def hexa(self):
        self.write("h.xml", "<mujoco><worldbody><body>" + "".join(f'<site name="r{k}" pos="{np.cos(k)} {np.sin(k)} 0"/>' for k in range(6))
                   + "</body></worldbody></mujoco>")
        return self.write("hexa.toml", 'format = "gustlab-vehicle/1"\nmjcf = "h.xml"\n'
                          + "".join(f'[[rotor]]\nsite = "r{k}"\ndirection = "cw"\n' for k in range(6)))

    def test_refusals(self):
        cases = {"disarmed: the vehicle was never armed": dict(armed=(90.0, 99.0)),
                 "a fixed-wing aircraft (MAV_TYPE 1), not a multirotor": dict(mav_type=1),
                 "a VTOL (tiltrotor, tailsitter or other) (MAV_TYPE 22), not a multirotor": dict(mav_type=22),
                 "too short: 2.0 s in the air, 3 s are needed": dict(flying=(5.0, 7.0))}
        for why, options in cases.items():
            with self.subTest(why):
                code, log, err = self.take(px4_flight(synthetic(), **options))
                self.assertEqual((code, log["flights"]), (3, []))
                self.assertIn(why, err)
                self.assertIn(why, [part["why"] for part in log["refused"]])
                self.assertEqual(sorted(p.name for p in self.out.iterdir()), ["import.json"])

    def test_a_log_that_px4_wrote(self):
        log = Path(__file__).resolve().parents[1] / "data" / "logs" / "px4_sitl_jmavsim.ulg"
        code, out, err = self.run_import(log, "--out", self.out, "--format", "json")
        said = json.loads(out)["logs"][0]
        self.assertEqual((code, err, said["autopilot"], said["airframe"]), (0, "", "PX4", "quadrotor x"))
        (found,) = said["flights"]
        self.assertEqual((round(found["from_s"], 2), round(found["to_s"], 2), found["rows"]), (19.31, 26.4, 1775))
        self.assertEqual(found["rates_hz"], {"position": 10, "velocity": 10, "attitude": 21, "body_rate": 250, "specific_force": 250, "u": 50, "rotor": 0, "vbat": 5})
        self.assertEqual([f["kind"] for f in said["findings"] if f["severity"] != "note"], [])
        # the estimator's own hover throttle was 0.492, and at rest a specific force is gravity
        written = self.written("px4_sitl_jmavsim_1.csv")
        self.assertAlmostEqual(np.nanmedian(np.column_stack([written[f"u{k}"] for k in range(1, 5)])), 0.492, delta=0.01)
        self.assertAlmostEqual(np.nanmedian(written["az"]), 9.8, delta=0.1)

    def test_a_vehicle_is_written_beside_the_flights_of_its_log(self):
        log = Path(__file__).resolve().parents[1] / "data" / "logs" / "px4_sitl_jmavsim.ulg"
        code, _, err = self.run_import(log, "--out", self.out)
        self.assertEqual((code, err), (0, ""))
        # it says where the motors are, and at which throttle it hovers
        self.assertIn("px4_sitl_jmavsim.ulg does not say what the vehicle weighs (--mass 1.2kg); import again with this,", self.no_vehicle)
        numbers = ("--mass", "1.5kg")
        code, _, err = self.run_import(log, "--out", self.out, *numbers)
        self.assertEqual((code, self.no_vehicle), (0, ""), err)
        self.assertIn("out/my_vehicle/vehicle.toml: written, and says of each number where it comes from\n", err)
        # as `vehicle new` writes it
        again = self.folder / "again" / "my_vehicle"
        subprocess.run([os.environ["GUSTLAB_PROGRAM"], "vehicle", "new", *numbers, "--from-log", log, "--out", again], check=True, capture_output=True)
        for name in ("vehicle.toml", "my_vehicle.xml"):
            self.assertEqual((self.out / "my_vehicle" / name).read_bytes(), (again / name).read_bytes())
        sidecar = self.out / "px4_sitl_jmavsim_1.meta.toml"
        self.assertEqual(tomllib.loads(sidecar.read_text())["vehicle"], "my_vehicle/vehicle.toml")
        first = sidecar.read_bytes()
        # once more, and with the vehicle that is there
        for more in (numbers, ()):
            self.assertEqual(self.run_import(log, "--out", self.out, *more)[0], 0)
            self.assertEqual((sidecar.read_bytes(), self.no_vehicle), (first, ""))
        code, _, err = self.run_import(log, "--out", self.out, "--mass", "1.6kg")
        self.assertEqual(code, 2)
        self.assertIn("is there already, and otherwise (a vehicle is never overwritten)", err)

    def test_a_report_in_two_commands(self):
        log = Path(__file__).resolve().parents[1] / "data" / "logs" / "px4_sitl_jmavsim.ulg"
        for words in (("import", log, "--out", "logs", "--mass", "1.5kg"), ("diagnose", "logs/px4_sitl_jmavsim_1.csv", "--out", "report")):
            done = subprocess.run([os.environ["GUSTLAB_PROGRAM"], *words], cwd=self.folder, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(done.stdout.startswith("my_vehicle: "))
        # seven seconds beside the ground: at most a push, and never a number that the log itself gave
        found = json.loads((self.folder / "report" / "diagnosis.json").read_text(encoding="utf-8"))
        self.assertFalse({"mass", "thrust_scale", "thrust_curve"} & {effect["effect"] for effect in found["effects"]})
        self.assertTrue((self.folder / "report" / "report.html").is_file())

    def test_what_describes_a_vehicle_is_what_vehicle_new_takes(self):
        from gustlab_import.new_vehicle import OPTIONS
        said = subprocess.run([os.environ["GUSTLAB_PROGRAM"], "vehicle", "new", "--help"], check=True, capture_output=True, text=True).stdout
        takes = set(re.findall(r"^ +--([a-z-]+)", said, re.MULTILINE)) - {"from-log", "out"}
        self.assertEqual(takes, set(OPTIONS))

    def test_the_reasons_are_said_once_and_on_stderr_they_are_reasons(self):
        from gustlab_import.segments import reasons
        refused = [(0.0, 2.0, "armed, on the ground"), (2.0, 2.8, "too short: 0.8 s in the air, 3 s are needed"), (2.7, 2.8, "the estimator was reset (z by 0.15 m)"),
                   (3.0, 4.0, "too short: 1.0 s in the air, 3 s are needed"), (4.0, 9.0, "on the ground: the height is within 0.1 m of where it stood"),
                   (9.0, 10.0, "disarmed")]
        self.assertEqual(reasons(refused), ["too short: 1.0 s in the air, 3 s are needed", "the estimator was reset (z by 0.15 m)"])
        # a log that never left the ground has no other
        self.assertEqual(reasons([(0.0, 2.0, "disarmed"), (2.0, 9.0, "armed, on the ground")]), ["armed, on the ground", "disarmed"])
        path = self.write("hop.ulg", px4_flight(synthetic(), flying=(5.0, 7.0)).bytes())
        code, _, err = self.run_import(path)
        self.assertEqual((code, err), (3, f"{path}: no flight: too short: 2.0 s in the air, 3 s are needed\n"))

    def test_refused_parts_and_flights_cover_the_log(self):
        _, log, _ = self.take(px4_flight(synthetic()))
        self.assertEqual([(p["from_s"], p["to_s"], p["why"]) for p in log["refused"]][:2], [(0.0, 2.0, "disarmed"), (2.0, 3.0, "armed, on the ground")])

    def test_a_battery_that_reads_nothing(self):
        log = px4_flight(synthetic())
        log.topic("battery_status", np.arange(100) * 0.2, {"float voltage_v": np.zeros(100)}, 1)
        _, entry, _ = self.take(log)
        self.assertEqual(entry["flights"][0]["rates_hz"]["vbat"], 5)

    def test_what_the_landing_detector_takes_for_flight_on_the_ground_is_cut(self):
        truth = synthetic()
        t, height = truth["time_s"], truth["p"][:, 2]
        height[(t < 5.05) | (t > 14.95)] = 0.06
        _, log, _ = self.take(px4_flight(truth))
        self.assertEqual([(f["from_s"], f["to_s"]) for f in log["flights"]], [(5.1, 14.9)])
        why = [(part["from_s"], part["to_s"]) for part in log["refused"] if part["why"].startswith("on the ground")]
        self.assertEqual(why, [(3.0, 5.1), (14.9, 17.0)])
        height[:] = 0.06
        self.out = self.out.parent / "on_the_ground"
        code, log, _ = self.take(px4_flight(truth))
        self.assertEqual((code, log["flights"]), (3, []))

    def test_a_gap_cuts_a_flight(self):
        log = px4_flight(synthetic(30.0), armed=(1.0, 29.0), flying=(2.0, 28.0))
        log.data = [d for d in log.data if not 13_000_000 < d[0] < 15_000_000]
        _, entry, _ = self.take(log)
        self.assertEqual([(f["from_s"], f["to_s"]) for f in entry["flights"]], [(2.0, 12.0), (14.0, 28.0)])
        self.assertIn("gap: no sample for 2.0 s", [part["why"] for part in entry["refused"]])

    def test_a_reset_of_the_estimator_cuts_a_flight(self):
        _, entry, _ = self.take(px4_flight(synthetic(), reset_s=9.0))
        self.assertEqual([(round(f["from_s"], 1), round(f["to_s"], 1)) for f in entry["flights"]], [(3.0, 9.0), (9.0, 17.0)])
        self.assertIn("the estimator was reset (z by 0.70 m)", [part["why"] for part in entry["refused"]])

    def test_a_height_that_contradicts_its_velocity_is_cut(self):
        truth = synthetic()
        truth["p"][:, 2] += 4.0 * np.clip(truth["time_s"] - 9.0, 0.0, 1.0)
        _, entry, _ = self.take(px4_flight(truth))
        self.assertEqual(len(entry["flights"]), 2)
        self.assertLess(entry["flights"][0]["to_s"], 9.0)
        self.assertGreater(entry["flights"][1]["from_s"], 10.0)
        self.assertTrue([part for part in entry["refused"] if "the height contradicts its velocity by 4.0 m" in part["why"]])

    def test_a_brown_out_is_cut_and_one_low_reading_is_not(self):
        at = np.arange(100) * 0.2
        for topic, key, usual, low in (("battery_status", "voltage_v", 16.5, 9.9), ("system_power", "voltage5v_v", 5.1, 4.1)):
            volts = np.full(100, usual)
            volts[[40, 50, 51, 52]] = low    # at 8 s, and from 10.0 to 10.4 s
            log = px4_flight(synthetic())
            log.topic(topic, at, {f"float {key}": volts}, 1 if topic == "battery_status" else 0)
            _, entry, _ = self.take(log)
            self.assertEqual([(round(f["from_s"], 1), round(f["to_s"], 1)) for f in entry["flights"]], [(3.0, 9.8), (10.6, 17.0)], topic)
            whose = "the battery" if topic == "battery_status" else "the board's supply"
            self.assertIn(f"brown-out: {whose} fell from {usual} to {low} V", [part["why"] for part in entry["refused"]])

    def test_what_cannot_be_told_names_the_setting(self):
        _, log, _ = self.take(px4_flight(synthetic()))
        lag = next(limit for limit in log["cannot_tell"] if limit["effect"] == "motor_lag")
        self.assertEqual(lag["why"], "motors are logged at 50 Hz, which shows no lag below 20 ms, nor a lag from a delay")
        self.assertIn("SDLOG_PROFILE", lag["setting"])

    def test_same_log_same_bytes_and_no_place(self):
        log = px4_flight(synthetic())
        log.topic("vehicle_gps_position", np.arange(10.0), {"float lat": np.full(10, 47.4), "float lon": np.full(10, 8.5)})
        self.take(log)
        first = {p.name: p.read_bytes() for p in self.out.iterdir()}
        self.take(log)
        self.assertEqual(first, {p.name: p.read_bytes() for p in self.out.iterdir()})
        self.assertNotIn(b"latitude", b"".join(first.values()))

    def test_says_what_is_in_it_without_out(self):
        code, out, err = self.run_import(self.write("flight.ulg", px4_flight(synthetic()).bytes()))
        self.assertEqual((code, err), (0, ""))
        for words in ("flight flight_1: 3.00 to 17.00 s", "position: 10 Hz (vehicle_local_position[0])", "enough to judge: forces",
                      "torques only where the motors' commands are smooth: at 50 Hz",
                      "cannot tell motor_lag", "refused: 0.00 to 2.00 s: disarmed"):
            self.assertIn(words, out)
        self.assertFalse(self.out.exists())


class OutputFolder(ImportCase):
    def log(self, name: str, *more):
        return self.run_import(self.write(name, px4_flight(synthetic(**dict(more))).bytes()), "--out", self.out, "-q")

    def test_imports_add_up(self):
        self.log("a.ulg")
        self.log("b.ulg")
        document = json.loads((self.out / "import.json").read_text())
        self.assertEqual([log["file"] for log in document["logs"]], ["a.ulg", "b.ulg"])
        self.assertEqual(len(list(self.out.glob("*.csv"))), 2)

    def test_what_is_imported_again_is_replaced_whole(self):
        two = px4_flight(synthetic(30.0), armed=(1.0, 29.0), flying=(2.0, 28.0))
        two.data = [d for d in two.data if not 13_000_000 < d[0] < 15_000_000]
        log = self.write("a.ulg", two.bytes())
        self.run_import(log, "--out", self.out)
        self.assertEqual(sorted(p.name for p in self.out.glob("*.csv")), ["a_1.csv", "a_2.csv"])
        self.assertEqual(self.run_import(log, "--out", self.out)[2], "")
        _, _, err = self.run_import(log, "--out", self.out, "--to", 11.0)
        self.assertEqual(sorted(p.name for p in self.out.glob("a_*")), ["a_1.csv", "a_1.meta.toml"])
        self.assertIn("imported again, and otherwise than before: a_1.csv, a_2.csv replaced or removed", err)

    def test_flights_of_another_log_are_never_replaced(self):
        self.log("a.ulg")
        first = {p.name: p.read_bytes() for p in self.out.iterdir()}
        (self.folder / "b").mkdir()
        other = px4_flight(synthetic(seed=2)).bytes()
        for name, words in (("b/a.ulg", "another log of this name was imported into"), ("a.bin", "a_1.csv in")):
            with self.subTest(name):
                code, _, err = self.run_import(self.write(name, other), "--out", self.out, "-q")
                self.assertEqual((code, words in err, len(err.strip().splitlines())), (2, True, 1), err)
                self.assertIn("give another --out, or rename the log", err)
                self.assertEqual(first, {p.name: p.read_bytes() for p in self.out.iterdir()})
        # the same bytes from another folder are the same log
        self.assertEqual(self.run_import(self.write("b/a.ulg", (self.folder / "a.ulg").read_bytes()), "--out", self.out, "-q")[0], 0)
        # two of one name in one call
        self.write("b/a.ulg", other)
        code, _, err = self.run_import(self.folder / "a.ulg", self.folder / "b/a.ulg", "--out", self.folder / "new")
        self.assertEqual((code, "use two --out" in err, (self.folder / "new").exists()), (2, True, False), err)

    def test_nothing_of_others_is_replaced(self):
        self.out.mkdir()
        for name in ("a_1.csv", "import.json"):
            with self.subTest(name):
                (self.out / name).write_text("mine")
                code, _, err = self.log("a.ulg")
                self.assertEqual((code, f"{name}: is there already, and no import wrote it" in err), (2, True), err)
                self.assertEqual([(p.name, p.read_text()) for p in self.out.iterdir()], [(name, "mine")])
                (self.out / name).unlink()


class Damaged(ImportCase):
    """Whatever is wrong with the bytes: one message, exit 3, never a traceback."""

    def test_logs_that_are_none(self):
        good = px4_flight(synthetic(6.0), armed=(0.0, 6.0), flying=(0.5, 5.5)).bytes()
        cases = {"empty.ulg": b"", "text.ulg": b"hello, world\n" * 20, "head.ulg": good[:16], "formats.ulg": good[:400],
                 "zeros.ulg": good[:16] + bytes(4000), "empty.bin": b"", "text.log": b"hello, world\n" * 20, "head.log": b"FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n",
                 "noise.bin": b"\xa3\x95" + bytes(range(256)) * 8,
                 "empty.tlog": b"", "text.tlog": b"hello, world\n" * 50, "noise.bag": b"#ROSBAG V2.0\n" + bytes(500),
                 "noise.db3": b"SQLite format 3\0" + bytes(500), "noise.mcap": b"\x89MCAP0\r\n" + bytes(200), "noise.bbl": bytes(300),
                 "head.bbl": b"H Product:Blackbox flight data recorder by Nicholas Sherlock\nH Data version:2\n",
                 "noise.parquet": b"PAR1" + bytes(100), "noise.xyz": bytes(300), "folder.ulg": None}
        for name, content in cases.items():
            with self.subTest(name):
                path = self.folder / name
                path.mkdir() if content is None else path.write_bytes(content)
                code, out, err = self.run_import(path, "--out", self.out)
                self.assertIn(code, (2, 3, 4), err)
                self.assertIn(name, err)
                self.assertEqual(len(err.strip().splitlines()), 1, err)
                self.assertFalse(self.out.exists() and list(self.out.glob("*.csv")))

    def test_a_damaged_log_is_said_beside_the_document_and_not_in_it(self):
        log = px4_flight(synthetic())
        # samples of a topic that was never announced, as after lost bytes
        log.data.append((log.start_us, log.message(b"D", b"\x63\x00" + bytes(16))))
        path = self.write("holes.ulg", log.bytes())
        code, out, _ = self.run_import(path, "--format", "json")
        self.assertEqual(code, 0)
        said = [f["says"] for f in json.loads(out)["logs"][0]["findings"]]
        self.assertTrue(any(line.startswith("the file is damaged in places") for line in said), said)

    def test_a_log_that_was_cut_off_keeps_what_is_there_and_says_where_it_ends(self):
        good = px4_flight(synthetic()).bytes()
        code, out, err = self.run_import(self.write("cut.ulg", good[:int(0.6 * len(good)) + 1]), "--out", self.out)
        self.assertEqual((code, err), (0, ""))
        last_s = self.written("cut_1.csv")["time_s"][-1]
        self.assertLess(last_s, 14.0)
        said = re.search(r"WARNING gap: .*the file ends early, within a message \(\d+ of \d+ bytes\): ([0-9.]+) s were read; it was cut off", out)
        self.assertAlmostEqual(float(said.group(1)), last_s, delta=0.02)
        self.assertIn("the file ends early", (self.out / "cut_1.meta.toml").read_text())
        self.assertNotIn("the log ends", out)
        self.assertNotIn("ends", self.run_import(self.write("whole.ulg", good))[1])

    def test_a_log_that_was_cut_off_between_messages_ends_in_the_air(self):
        good = px4_flight(synthetic()).bytes()
        _, _, cut = without_damage(half := good[:int(0.6 * len(good))])
        code, out, _ = self.run_import(self.write("cut.ulg", half[:-cut[0]]))
        self.assertEqual(code, 0)
        self.assertNotIn("the file ends", out)
        self.assertRegex(out, r"note    gap: .*the log ends in the air, after [0-9.]+ s: it was cut off, or logging stopped in flight")

    def damaged(self, harm) -> tuple:
        """(what import says, columns written) of a log with a kilobyte and more of its middle harmed."""
        good = px4_flight(synthetic()).bytes()
        first = len(good) // 2
        self.out = self.folder / f"out_{len(list(self.folder.iterdir()))}"   # another log of the same name is not written over the first
        code, out, err = self.run_import(self.write("bad.ulg", good[:first] + harm(good[first:first + 3000]) + good[first + 3000:]), "--out", self.out)
        self.assertEqual((code, err), (0, ""))
        return out, self.written("bad_1.csv")

    def test_bytes_that_are_no_messages_are_counted_and_placed(self):
        noise = np.random.default_rng(3).bytes(3000)
        for name, harm, least in (("zeros", lambda part: bytes(len(part)), 3000), ("noise", lambda _: noise, 2900), ("hole", lambda _: b"", 1)):
            with self.subTest(name):
                out, _ = self.damaged(harm)
                found = re.search(r"the file is damaged in places: (\d+) bytes from byte (\d+) on are no messages, and of ([0-9.]+) to ([0-9.]+) s everything or "
                                  "something is missing", out)
                self.assertTrue(found, out)
                lost, _, from_s, to_s = (float(x) for x in found.groups())
                self.assertTrue(least <= lost <= 3200, lost)
                # 42 kB/s
                self.assertTrue(0.02 < to_s - from_s < 0.3 and 9.5 < from_s < 10.5, found.group())
                self.assertIn("bytes from byte", (self.out / "bad_1.meta.toml").read_text())

    def test_a_time_that_cannot_be_moves_nothing(self):
        out, columns = self.damaged(lambda part: part)
        log = px4_flight(synthetic())
        whole, at = log.bytes(), 0
        # the highest byte of a time in the middle of the log, of the fastest topic
        stamps = [match.start() for match in re.finditer(rb"D\x00\x00", whole)]
        at = stamps[len(stamps) // 2] + 3
        self.out = self.folder / "wrong_time"
        self.run_import(self.write("bad.ulg", whole[:at + 7] + b"\x01" + whole[at + 8:]), "--out", self.out)
        self.assertEqual(len(columns["time_s"]) - len(self.written("bad_1.csv")["time_s"]) in (0, 1), True)
        self.assertIn("the file is damaged in places: ", (self.out / "bad_1.meta.toml").read_text())

    def test_any_byte_may_be_wrong(self):
        good, random = px4_flight(synthetic(8.0), armed=(0.0, 8.0), flying=(0.5, 7.5)).bytes(), np.random.default_rng(7)
        for _ in range(30):
            bad = bytearray(good)
            head = random.random() < 0.5
            for at in random.integers(16, 3000 if head else len(bad), 20):
                bad[at] = random.integers(256)
            code, _, err = self.run_import(self.write("bad.ulg", bytes(bad)))
            self.assertIn(code, (0, 3), err)
            self.assertLessEqual(len(err.strip().splitlines()), 1, err)


if __name__ == "__main__":
    unittest.main()
