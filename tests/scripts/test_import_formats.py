"""Logs of other kinds, written by the libraries that their users write them with: tlog, DataFlash, bags, Parquet, blackbox."""

import json
import os
import struct
import subprocess
import sys
import unittest
from pathlib import Path

import numpy as np
from import_fixture import MAP, ImportCase, csv, flight, without_progress
from pymavlink import DFReader

os.environ["MAVLINK20"] = "1"
ENU = MAP.replace('kind = "csv"', 'kind = "{kind}"')


class FormatCase(ImportCase):
    def take(self, path, *more) -> tuple:
        code, out, err = self.run_import(path, "--out", self.out, "--format", "json", *more)
        return code, json.loads(out)["logs"][0] if out else {}, err


class Parquet(FormatCase):
    def test_as_the_csv(self):
        import pyarrow
        import pyarrow.parquet
        columns = flight()
        path = self.folder / "log.parquet"
        pyarrow.parquet.write_table(pyarrow.table(columns), path)
        code, log, err = self.take(path, "--map", self.write("m.toml", ENU.format(kind="parquet")))
        self.assertEqual((code, err, log["findings"]), (0, "", []))
        written = self.written()
        np.testing.assert_allclose(written["pz"], columns["z"], atol=1e-8)
        np.testing.assert_allclose(written["u4"], columns["m4"], atol=1e-8)

    def test_nulls_are_no_samples(self):
        import pyarrow
        import pyarrow.parquet
        columns = {name: list(values) for name, values in flight().items()}
        for k in range(len(columns["x"])):
            if k % 5:
                for name in ("x", "y", "z", "vx", "vy", "vz"):
                    columns[name][k] = None
        path = self.folder / "log.parquet"
        pyarrow.parquet.write_table(pyarrow.table(columns), path)
        code, log, _ = self.take(path, "--map", self.write("m.toml", ENU.format(kind="parquet")))
        self.assertEqual((code, log["findings"]), (0, []))
        self.assertEqual(log["flights"][0]["rates_hz"]["position"], 20)


class Bags(FormatCase):
    def write_bag(self, columns: dict, folder: str, storage: str):
        from rosbags.rosbag1 import Writer as Writer1
        from rosbags.rosbag2 import StoragePlugin
        from rosbags.rosbag2 import Writer as Writer2
        from rosbags.typesys import Stores, get_typestore
        store = get_typestore(Stores.ROS1_NOETIC if storage == "bag" else Stores.ROS2_HUMBLE)
        types = store.types
        path = self.folder / (folder + ".bag") if storage == "bag" else self.folder / folder
        writer = Writer1(path) if storage == "bag" else Writer2(path, version=8, storage_plugin=StoragePlugin[storage])
        head = {"seq": 0} if storage == "bag" else {}
        encode = store.serialize_ros1 if storage == "bag" else store.serialize_cdr
        with writer:
            imu = writer.add_connection("/imu", "sensor_msgs/msg/Imu", typestore=store)
            pose = writer.add_connection("/odom", "geometry_msgs/msg/PoseStamped", typestore=store)
            thrust = writer.add_connection("/thrust", "std_msgs/msg/Float64", typestore=store)
            for k, t in enumerate(columns["t"]):
                now = 10**18 + round(1e9 * t)
                stamp = types["builtin_interfaces/msg/Time"](sec=now // 10**9, nanosec=now % 10**9)
                header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="", **head)
                vector = lambda *names: types["geometry_msgs/msg/Vector3"](**dict(zip("xyz", (columns[n][k] for n in names))))  # noqa: E731
                turn = types["geometry_msgs/msg/Quaternion"](**{a: columns["q" + a][k] for a in "xyzw"})
                nothing = np.zeros(9)
                writer.write(imu, now, encode(types["sensor_msgs/msg/Imu"](
                    header=header, orientation=turn, orientation_covariance=nothing, angular_velocity=vector("gx", "gy", "gz"),
                    angular_velocity_covariance=nothing, linear_acceleration=vector("ax", "ay", "az"),
                    linear_acceleration_covariance=nothing), "sensor_msgs/msg/Imu"))
                if k % 2 == 0:
                    point = types["geometry_msgs/msg/Point"](x=columns["x"][k], y=columns["y"][k], z=columns["z"][k])
                    writer.write(pose, now + 1000, encode(types["geometry_msgs/msg/PoseStamped"](
                        header=header, pose=types["geometry_msgs/msg/Pose"](position=point, orientation=turn)),
                        "geometry_msgs/msg/PoseStamped"))
                if k % 5 == 0:
                    writer.write(thrust, now, encode(types["std_msgs/msg/Float64"](data=float(0.5 + 0.05 * np.sin(t))), "std_msgs/msg/Float64"))
        return path if storage == "bag" else next(p for p in path.iterdir() if p.suffix in (".db3", ".mcap"))

    MAP = """format = "gustlab-column-map/1"
kind = "ros"
vehicle = "crazyflie"
[time]
column = "time"
[position]
columns = ["/odom.pose.position.x", "/odom.pose.position.y", "/odom.pose.position.z"]
[attitude]
columns = ["/imu.orientation.x", "/imu.orientation.y", "/imu.orientation.z", "/imu.orientation.w"]
order = "xyzw"
[rate]
columns = ["/imu.angular_velocity.x", "/imu.angular_velocity.y", "/imu.angular_velocity.z"]
[actuator]
kind = "collective_thrust"
columns = ["/thrust.data"]
scale = 2.0
"""

    def test_every_container_with_a_map(self):
        columns = flight(10.0)
        for storage in ("bag", "SQLITE3", "MCAP"):
            with self.subTest(storage):
                path = self.write_bag(columns, "b" + storage, storage)
                code, log, err = self.take(path, "--map", self.write("m.toml", self.MAP))
                self.assertEqual((code, err), (0, ""))
                self.assertEqual(log["flights"][0]["rates_hz"], {"position": 50, "velocity": 0, "attitude": 100, "body_rate": 100,
                                                                 "specific_force": 0, "u": 20, "rotor": 0, "vbat": 0})
                self.assertEqual([f for f in log["findings"] if f["kind"] == "gap"], [])
                written = self.written(log["flights"][0]["log"])
                rows = np.isfinite(written["px"])
                np.testing.assert_allclose(written["px"][rows], columns["x"][::2], atol=1e-8)
                rows = np.isfinite(written["u1"])
                np.testing.assert_allclose(written["u1"][rows], 2.0 * (0.5 + 0.05 * np.sin(columns["t"][::5])), atol=1e-8)

    def test_a_map_that_does_not_know_the_time_of_a_bag_is_told(self):
        path = self.write_bag(flight(5.0), "b", "bag")
        code, _, err = self.run_import(path, "--map", self.write("m.toml", self.MAP.replace('"time"', '"/imu.header.stamp"')))
        self.assertEqual(code, 3)
        self.assertIn("no column `/imu.header.stamp`, which [time] of the map `m` names; that of a bag is called `time`", err)

    def test_an_mcap_of_another_kind_is_no_broken_bag(self):
        from mcap.writer import Writer
        path = self.folder / "other.mcap"
        with open(path, "wb") as file:
            writer = Writer(file)
            writer.start(profile="", library="test")
            writer.finish()
        code, _, err = self.run_import(path)
        self.assertEqual((code, err), (3, f"{path}: an MCAP file without ROS 2 messages; give a bag, or the log that it was made of\n"))

    def test_a_bag_without_motors_says_what_it_has(self):
        code, log, err = self.take(self.write_bag(flight(5.0), "b", "MCAP"))
        self.assertEqual((code, log["flights"]), (3, []))
        self.assertIn("/thrust is a collective command without a known unit", err)


class Telemetry(FormatCase):
    def write_tlog(self, rate_hz: float, seconds: float = 20.0):
        from pymavlink.dialects.v20 import ardupilotmega as mavlink

        class Sink:
            def __init__(self):
                self.bytes = b""

            def write(self, data):
                self.bytes += data

        sink, out = Sink(), b""
        link = mavlink.MAVLink(sink, srcSystem=1, srcComponent=1)
        noise = np.random.default_rng(4)
        for k in range(round(seconds * rate_hz)):
            t = k / rate_hz
            boot = round(1e3 * t)
            sink.bytes = b""
            if k % max(1, round(rate_hz)) == 0:
                link.heartbeat_send(2, 3, 128 if 2.0 <= t < 18.0 else 0, 0, 4)
            link.attitude_send(boot, 0.1 * np.sin(2 * t), 0.05, 1.0, 0.2 * np.cos(2 * t), 0.0, 0.0)
            link.local_position_ned_send(boot, np.sin(t), 0.5 * np.cos(t), -1.0 - 0.1 * np.sin(t), np.cos(t), -0.5 * np.sin(t), -0.1 * np.cos(t))
            link.raw_imu_send(1000 * boot, 0, 0, -1000, round(200 * np.cos(2 * t)), 0, 0, 0, 0, 0)
            link.servo_output_raw_send(1000 * boot, 0, *(round(v) for v in 1500 + 30 * noise.normal(size=4)), 0, 0, 0, 0)
            # the receiver's clock jitters, the vehicle's does not
            stamp = round(1e6 * (1.6e9 + t + 0.2 * noise.random()))
            # every message of a tlog has its own stamp before it
            at = 0
            while at < len(sink.bytes):
                size = sink.bytes[at + 1] + 12
                out += struct.pack(">Q", stamp) + sink.bytes[at:at + size]
                at += size
        return self.write("flight.tlog", out)

    def test_fast_telemetry_is_a_flight_on_the_vehicles_clock(self):
        code, log, err = self.take(self.write_tlog(20.0))
        self.assertEqual((code, err, log["airframe"]), (0, "", "quadrotor x"))
        self.assertEqual([log["flights"][0]["rates_hz"][k] for k in ("position", "attitude", "u")], [20, 20, 20])
        written = self.written("flight_1.csv")
        t = written["time_s"]
        np.testing.assert_allclose(np.diff(t), 0.05, atol=1e-5)
        np.testing.assert_allclose(written["py"], np.sin(t), atol=1e-3)   # north is y
        np.testing.assert_allclose(written["pz"], 1.0 + 0.1 * np.sin(t), atol=1e-3)
        np.testing.assert_allclose(written["az"], 9.80665, atol=1e-5)
        np.testing.assert_allclose(written["wx"], 0.2 * np.cos(2 * t), atol=1e-3)

    def test_slow_telemetry_cannot_be_judged(self):
        code, _, err = self.take(self.write_tlog(2.0, 60.0))
        self.assertEqual((code, "cannot be judged at 2.0 Hz" in err), (3, True), err)


class DataFlash(FormatCase):
    """The format's own description (AP_Logger): FMT messages, then packed ones, each after 0xA3 0x95 and its number."""

    LAYOUT = {"Q": "Q", "f": "f", "C": "H", "H": "H", "B": "B", "c": "h", "N": "16s", "Z": "64s", "n": "4s", "h": "h", "M": "B"}

    def write_log(self, version: str = "ArduCopter V4.5.1 (abcdef01)", speeds_every: int = 0, parameters=(), pulses=None, crash_s=None, ends_s=20.0,
                  says_when=True, motors_every=2):
        out, formats = b"", {}

        def define(number, name, kinds, columns):
            nonlocal out
            size = 3 + struct.calcsize("<" + "".join(self.LAYOUT[k] for k in kinds))
            formats[name] = (number, kinds)
            out += b"\xa3\x95\x80" + struct.pack("<BB4s16s64s", number, size, name.encode(), kinds.encode(), columns.encode())

        def put(name, *values):
            nonlocal out
            number, kinds = formats[name]
            out += b"\xa3\x95" + bytes([number]) + struct.pack("<" + "".join(self.LAYOUT[k] for k in kinds), *values)

        out += b"\xa3\x95\x80" + struct.pack("<BB4s16s64s", 128, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns")
        define(1, "MSG", "QZ", "TimeUS,Message")
        define(2, "PARM", "QNf", "TimeUS,Name,Value")
        define(3, "ATT", "Qccc", "TimeUS,Roll,Pitch,Yaw")
        define(4, "IMU", "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ")
        define(5, "XKF1", "QBffffff", "TimeUS,C,VN,VE,VD,PN,PE,PD")
        define(6, "RCOU", "QHHHHHHHH", "TimeUS,C1,C2,C3,C4,C5,C6,C7,C8")
        define(7, "EV", "QB", "TimeUS,Id")
        define(8, "BAT", "Qf", "TimeUS,Volt")
        define(9, "XKF4", "QBB", "TimeUS,C,PI")
        define(10, "ESC", "QBf", "TimeUS,Instance,RPM")
        define(11, "ERR", "BB", "Subsys,ECode")   # as old firmwares write it: without a time
        put("MSG", 10**6, version.encode())
        for name, value in (("FRAME_CLASS", 1), ("FRAME_TYPE", 1), ("AHRS_EKF_TYPE", 3), ("MOT_PWM_MIN", 1100), ("MOT_PWM_MAX", 1900),
                            ("SERVO1_FUNCTION", 33), ("SERVO2_FUNCTION", 34), ("SERVO3_FUNCTION", 36), ("SERVO4_FUNCTION", 35), *parameters):
            put("PARM", 10**6, name.encode(), float(value))
        noise = np.random.default_rng(5)
        for k in range(round(100 * ends_s)):
            t = 0.01 * k
            us = 10**6 + round(1e6 * t)
            for event, at in ((10, 2.0), (28, 3.0), (18, 17.0), (11, 18.0)) if says_when else ():
                if abs(t - at) < 1e-9:
                    put("EV", us, event)
            put("ATT", us, round(100 * 5.0 * np.sin(2 * t)), 100, 9000)
            for core in (0, 1):
                put("IMU", us, core, np.radians(10.0 * np.cos(2 * t)), 0.0, 0.0, 0.1 * core, 0.0, -9.81)
                put("XKF1", us, core, np.cos(t), 0.0, -0.1 * np.cos(t), np.sin(t) + core, 0.0,
                    -2.0 - 0.1 * np.sin(t) if 3.0 <= t <= 17.0 else -1.0)
            put("XKF4", us, 0, 1)
            for output in range(4) if speeds_every and k % speeds_every == 0 else ():
                # one speed controller answers after the other
                put("ESC", us + 300 * output, output, 5000.0 + 1000.0 * output + 50.0 * np.sin(t))
            if crash_s is not None and abs(t - crash_s) < 1e-9:
                put("ERR", 12, 1)
            if k % motors_every == 0:
                others = noise.normal(size=2)
                put("RCOU", us, *(pulses(t) if pulses else (1500, 1480, *(round(v) for v in 1500 + 20 * others))), 0, 0, 65000, 65000)
                put("BAT", us, 12.0 - 0.02 * t)
        return self.write("flight.bin", out)

    def test_flight(self):
        code, log, err = self.take(self.write_log())
        self.assertEqual((code, err), (0, ""))
        self.assertEqual((log["autopilot"], log["airframe"]), ("ArduCopter V4.5.1", "quadrotor x"))
        self.assertEqual((log["flights"][0]["from_s"], log["flights"][0]["to_s"]), (3.0, 17.0))
        self.assertEqual(log["flights"][0]["rates_hz"], {"position": 100, "velocity": 100, "attitude": 100, "body_rate": 100,
                                                         "specific_force": 100, "u": 50, "rotor": 0, "vbat": 50})
        written = self.written("flight_1.csv")
        t = written["time_s"]
        np.testing.assert_allclose(written["py"], np.sin(t) + 1.0, atol=1e-5)   # core 1 is the one that flew
        np.testing.assert_allclose(written["pz"], 2.0 + 0.1 * np.sin(t), atol=1e-5)
        np.testing.assert_allclose(written["az"], 9.81, atol=1e-5)
        np.testing.assert_allclose(written["wx"], np.radians(10.0 * np.cos(2 * t)), atol=1e-5)
        # heading east: the nose points along x, and the vehicle stands upright
        q = np.column_stack([written["q" + k] for k in "wxyz"])
        self.assertLess(np.abs(1 - 2 * (q[:, 2] ** 2 + q[:, 3] ** 2) - np.cos(np.radians(1.0))).max(), 1e-3)
        rows = np.isfinite(written["u1"])
        np.testing.assert_allclose(written["u1"][rows], 0.5, atol=1e-9)
        self.assertIn("core 1 of 2", (self.out / "flight_1.meta.toml").read_text())
        # motor 3 is on output 4
        self.assertIn("RCOU C1 to C3", log["flights"][0]["sources"]["u"])

    def test_a_crash_check_without_a_time_cuts_and_is_said(self):
        _, log, _ = self.take(self.write_log(crash_s=10.0))
        self.assertEqual([part["why"] for part in log["refused"] if 9.9 < part["to_s"] < 10.1], ["the vehicle's crash check fired"])
        self.assertEqual([(round(flight["from_s"], 1), round(flight["to_s"], 1)) for flight in log["flights"]], [(3.0, 10.0), (10.0, 17.0)])
        # the last that a log says
        _, log, _ = self.take(self.write_log(crash_s=14.99, ends_s=15.0))
        self.assertEqual([finding["says"] for finding in log["findings"] if "crash" in finding["says"]],
                         ["the vehicle's crash check fired, and the log ends: the last seconds may be a fall"])

    def test_a_log_that_ends_in_the_air_says_so(self):
        said = [[finding["says"] for finding in self.take(self.write_log(**more), "--out", self.out.with_name(name))[1]["findings"]
                 if "ends in the air" in finding["says"]] for name, more in (("whole", {}), ("half", {"ends_s": 10.0}))]
        self.assertEqual(said[0], [])
        self.assertRegex(said[1][0], r"the log ends in the air, after 9\.\d\d s: it was cut off, or logging stopped in flight")

    # seconds were left out as on the ground: within a hand's breadth of the height of the last sample
    def test_a_log_that_is_cut_in_the_air_is_flight_to_its_end(self):
        _, log, _ = self.take(self.write_log(says_when=False, ends_s=12.0, motors_every=10))
        self.assertEqual([(f["from_s"], round(f["to_s"], 1)) for f in log["flights"]], [(0.0, 12.0)])
        self.assertEqual(log["refused"], [])
        self.assertTrue([f for f in log["findings"] if f["says"].startswith("the log ends in the air, after 11.9")], log["findings"])

    def test_speeds_of_the_controllers_follow_the_outputs(self):
        _, log, _ = self.take(self.write_log(speeds_every=2))
        self.assertEqual(log["flights"][0]["rates_hz"]["rotor"], 50)
        written = self.written("flight_1.csv")
        rows = np.isfinite(written["rotor1"])
        # motors 3 and 4 are on outputs 4 and 3
        for k, base in enumerate((5000.0, 6000.0, 8000.0, 7000.0), 1):
            wanted = (base + 50.0 * np.sin(written["time_s"][rows])) * 2.0 * np.pi / 60.0
            np.testing.assert_allclose(written[f"rotor{k}"][rows], wanted, rtol=1e-5)
        _, log, _ = self.take(self.write_log(speeds_every=20), "--out", self.out.with_name("slow"))
        self.assertEqual(log["flights"][0]["rates_hz"]["rotor"], 0)
        self.assertTrue(any("more seldom than the motors' commands" in f["says"] for f in log["findings"]))

    # thrust of the outputs in flight
    @staticmethod
    def asked(t):
        return [0.2 + 0.15 * np.sin(1.3 * t + k) for k in range(4)]

    def shares(self, parameters, pulse) -> tuple:
        """(largest distance of u from what was asked, what is said of it) of a flight whose pulses an autopilot made"""
        log = self.write_log(parameters=parameters, pulses=lambda t: [round(pulse(share)) for share in self.asked(t)])
        _, entry, _ = self.take(log, "--out", self.out)
        written = self.written("flight_1.csv")
        rows = np.isfinite(written["u1"])
        # motors 3 and 4 are on outputs 4 and 3
        wanted = np.array([self.asked(t) for t in written["time_s"][rows]])[:, [0, 1, 3, 2]]
        got = np.column_stack([written[f"u{k}"][rows] for k in (1, 2, 3, 4)])
        return np.abs(got - wanted).max(), entry["flights"][0]["sources"]["u"]

    def test_outputs_are_behind_the_thrust_curve(self):
        low, high, first, last = 1100.0, 1900.0, 0.12, 0.95
        for curve in (0.65, 1.0, -0.4):
            with self.subTest(curve):
                # as the autopilot does it: the positive root of e s^2 + (1 - e) s = share
                def pulse(share, e=curve):
                    s = ((e - 1.0) + np.sqrt((1.0 - e) ** 2 + 4.0 * e * share)) / (2.0 * e)
                    return low + (high - low) * (first + (last - first) * s)
                apart, says = self.shares((("MOT_SPIN_MIN", first), ("MOT_SPIN_MAX", last), ("MOT_THST_EXPO", curve)), pulse)
                self.assertLess(apart, 1.6e-3)  # half a microsecond at the steepest
                self.assertIn(f"MOT_THST_EXPO {curve:.3g} from 0.12 to 0.95", says)

    def test_without_a_range_of_their_own_motors_have_that_of_the_stick(self):
        parameters = (("MOT_PWM_MIN", 0), ("MOT_PWM_MAX", 0), ("RCMAP_THROTTLE", 5), ("RC5_MIN", 991), ("RC5_MAX", 2016),
                      ("MOT_TCRV_ENABLE", 1), ("MOT_TCRV_MIDPCT", 40), ("MOT_TCRV_MAXPCT", 90))
        apart, says = self.shares(parameters, lambda share: 991 + 1025 * np.interp(share, (0.0, 0.5, 1.0), (0.0, 0.4, 0.9)))
        self.assertLess(apart, 0.7e-3)
        self.assertIn("991 to 2016 us", says)

    def test_unknown_curves_are_said(self):
        apart, says = self.shares((), lambda share: 1100 + 800 * share)
        self.assertLess(apart, 0.7e-3)
        self.assertIn("not led back", says)

    def test_the_text_of_a_log_gives_the_same_flight(self):
        binary = self.write_log()
        log = DFReader.DFReader_binary(str(binary))
        lines = [f"FMT, {f.type}, {f.len}, {f.name}, {f.format}, {','.join(f.columns)}" for f in log.formats.values()]
        lines.sort(key=lambda line: not line.startswith("FMT, 128,"))
        while (m := log.recv_msg()) is not None:
            if m.get_type() != "FMT":
                lines.append(", ".join([m.get_type()] + [str(getattr(m, name)) for name in m.get_fieldnames()]))
        text = self.write("text.log", "\n".join(lines) + "\n")
        flights = [self.take(path)[1]["flights"] for path in (binary, text)]
        for flight in flights:
            del flight[0]["log"]
        self.assertEqual(*flights)
        self.assertEqual(*((self.out / f"{name}_1.csv").read_bytes() for name in ("flight", "text")))

    def test_damage_is_one_finding_and_not_a_line_for_each_byte(self):
        data = bytearray(self.write_log().read_bytes())
        data[len(data) // 2:len(data) // 2 + 900] = bytes(900)
        log = self.write("holes.bin", bytes(data))
        script = Path(__file__).resolve().parents[2] / "scripts" / "import_log.py"
        # what compiled code writes to the process's stderr
        done = subprocess.run([sys.executable, str(script), str(log), "--format", "json"], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, without_progress(done.stderr)), (0, ""))
        damage = [f["says"] for f in json.loads(done.stdout)["logs"][0]["findings"] if "damaged in places" in f["says"]]
        self.assertEqual(len(damage), 1)
        self.assertRegex(damage[0], r"\((8|9)\d\d bytes that are no message\)")

    def test_a_plane_is_refused(self):
        code, _, err = self.take(self.write_log("ArduPlane V4.5.1 (abcdef01)"))
        self.assertEqual((code, "ArduPlane, not a multirotor" in err), (3, True), err)


def blackbox(columns: dict) -> bytes:
    """A log as Betaflight's format page says: every frame an I frame, every field a variable byte; `columns` hold integers."""
    def vb(value):
        value = (value << 1) ^ (value >> 63)   # zigzag: signed
        out = bytearray()
        while value > 127:
            out.append(value & 127 | 128)
            value >>= 7
        return bytes(out) + bytes([value])

    zeros = ",".join("0" for _ in columns)
    head = ["Product:Blackbox flight data recorder by Nicholas Sherlock", "Data version:2", "I interval:1", "P interval:1/1",
            f"Field I name:{','.join(columns)}", f"Field I signed:{zeros}", f"Field I predictor:{zeros}", f"Field I encoding:{zeros}",
            f"Field P predictor:{zeros}", f"Field P encoding:{zeros}", "Firmware type:Cleanflight",
            "Firmware revision:Betaflight 4.5.0 (77d01ba3b) STM32F405", "acc_1G:2048", "motorOutput:48,2047", "vbatcellvoltage:330,350,430", "looptime:125"]
    frames = b"".join(b"I" + b"".join(map(vb, map(int, row))) for row in zip(*columns.values()))
    return "".join(f"H {line}\n" for line in head).encode() + frames + b"E\xffEnd of log\x00"


class Blackbox(ImportCase):
    def columns(self, seconds=12.0, rate_hz=500):
        """On the ground, in the air from 2 to 10 s, on the ground."""
        t = np.arange(int(seconds * rate_hz)) / rate_hz
        flying, shake = (t > 2.0) & (t < 10.0), np.random.default_rng(1).standard_normal((8, len(t)))
        sway = np.where(flying, np.sin(4.0 * t), 0.0)
        # rates in degrees a second, the board 40 a second in roll at most
        rows = {"loopIteration": np.arange(len(t)), "time": 1e6 * t, **{f"gyroADC[{k}]": (40.0 * sway if k == 0 else 0.0) + shake[k] for k in range(3)},
                **{f"accSmooth[{k}]": (2048.0 if k == 2 else 0.0) + 20.0 * shake[3 + k] for k in range(3)},
                **{f"motor[{k}]": np.where(flying, 48.0 + 1999.0 * 0.4, 48.0) + np.where(flying, 60.0 * shake[6] + (30.0, 30.0, -30.0, -30.0)[k] * sway, 0.0)
                   for k in range(4)},
                "vbatLatest": np.full(len(t), 1580.0) - 3.0 * t}
        return {name: np.round(values).astype(int) for name, values in rows.items()}

    def test_a_log_becomes_a_flight_in_si_units(self):
        columns = self.columns()
        code, out, err = self.run_import(self.write("log.bbl", blackbox(columns)), "--out", self.out, "--vehicle", "iris", "--format", "json")
        self.assertEqual(code, 0, err)
        found = json.loads(out)["logs"][0]
        self.assertEqual((found["kind"], found["autopilot"], len(found["flights"])), ("betaflight-blackbox", "Betaflight 4.5.0", 1))
        self.assertEqual((round(found["flights"][0]["from_s"]), round(found["flights"][0]["to_s"])), (2, 10))
        self.assertEqual(found["flights"][0]["rates_hz"]["body_rate"], 500)
        log = self.written()
        at = np.round(500.0 * (log["time_s"] + found["flights"][0]["from_s"] - log["time_s"][0])).astype(int)
        np.testing.assert_allclose(log["wx"], np.radians(columns["gyroADC[0]"][at]), atol=1e-5)
        np.testing.assert_allclose(log["az"], 9.80665 / 2048.0 * columns["accSmooth[2]"][at], atol=1e-3)
        self.assertAlmostEqual(float(np.nanmedian(log["u1"])) / 65535.0, 0.4, 2)   # the vehicle file takes pwm
        self.assertAlmostEqual(float(np.nanmean(log["vbat"])), 15.6, 1)

    def test_a_damaged_byte_is_said_or_refused_and_never_a_crash(self):
        whole = blackbox(self.columns(6.0))
        head = whole.index(b"I\x00")
        for at in (40, head - 30, head + 500, len(whole) // 2, len(whole) - 20):
            damaged = bytearray(whole)
            damaged[at] ^= 0xFF
            code, out, err = self.run_import(self.write("log.bbl", bytes(damaged)), "--format", "json")
            self.assertIn(code, (0, 3), err)
            self.assertNotIn("Traceback", err)
        code, _, err = self.run_import(self.write("log.bbl", whole[:head + 100]))
        self.assertEqual((code, "too few" in err), (3, True), err)

    def test_electrical_turns_become_speeds_of_the_rotors(self):
        from types import SimpleNamespace

        from gustlab_import.read_blackbox import _recording
        names = ["time", *(f"motor[{k}]" for k in range(4)), *(f"eRPM[{k}]" for k in range(4))]
        # 12 poles are 6 pairs: 600 hundreds of electrical turns a minute are 10000 rpm
        rows = [[1000 * k, 1000, 1000, 1000, 1000, 600, 660, 720, 780] for k in range(200)]
        log = SimpleNamespace(main_field_names=names, main_frames=rows, frame_defs={}, stats={}, sys_config={"motor_poles": 12})
        speeds = _recording("a.bbl", b"", log, 1).streams["rotor"]
        np.testing.assert_allclose(speeds.values[0], np.array([10000, 11000, 12000, 13000]) * 2 * np.pi / 60)
        self.assertEqual(round(speeds.rate_hz()), 1000)


class Frames(FormatCase):
    """A recording in aviation frames comes out as the same one in the flight log's."""

    def test_ned_and_frd(self):
        columns = flight()
        plain = self.take(self.write("log.csv", csv(columns)), "--map", self.map)
        wanted = self.written()
        aviation = dict(columns)
        for a, b, c in (("x", "y", "z"), ("vx", "vy", "vz")):
            aviation[a], aviation[b], aviation[c] = columns[b], columns[a], -columns[c]
        for a in ("gy", "gz", "ay", "az"):
            aviation[a] = -columns[a]
        q = np.column_stack([columns["q" + k] for k in "wxyz"])
        first = np.sqrt(0.5) * np.column_stack([-(q[:, 1] + q[:, 2]), q[:, 0] + q[:, 3], q[:, 0] - q[:, 3], q[:, 2] - q[:, 1]])
        turned = np.column_stack([-first[:, 1], first[:, 0], first[:, 3], -first[:, 2]])
        for k, name in enumerate("wxyz"):
            aviation["q" + name] = turned[:, k]
        text = MAP.replace('columns = ["x", "y", "z"]', 'columns = ["x", "y", "z"]\nframe = "ned"').replace('"world"', '"ned"')
        text = text.replace('order = "xyzw"', 'order = "xyzw"\nframe = "ned"').replace('unit = "rad/s"', 'unit = "rad/s"\nframe = "frd"')
        text = text.replace('unit = "m/s^2"', 'unit = "m/s^2"\nframe = "frd"')
        self.out = self.folder / "aviation"   # another log of the same name is not written over the first
        code, log, err = self.take(self.write("log.csv", csv(aviation)), "--map", self.write("m.toml", text))
        self.assertEqual((code, err, log["findings"], plain[1]["findings"]), (0, "", [], []))
        for name, values in self.written().items():
            if name[0] == "q":
                continue
            np.testing.assert_allclose(values, wanted[name], atol=1e-7, err_msg=name)
        same = sum(self.written()["q" + k] * wanted["q" + k] for k in "wxyz")
        np.testing.assert_allclose(np.abs(same), 1.0, atol=1e-6)

    def test_signs(self):
        columns = flight()
        columns["gy"], columns["gz"] = -columns["gy"], -columns["gz"]
        code, log, _ = self.take(self.write("log.csv", csv(columns)), "--map",
                                 self.write("m.toml", MAP.replace('unit = "rad/s"', 'unit = "rad/s"\nsigns = [1, -1, -1]')))
        self.assertEqual((code, log["findings"]), (0, []))

    def test_angles_in_degrees_and_pulses(self):
        columns = flight()
        w, x, y, z = (columns["q" + k] for k in "wxyz")
        columns["r"] = np.degrees(np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)))
        columns["p"] = np.degrees(np.arcsin(2 * (w * y - z * x)))
        columns["h"] = np.degrees(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
        text = MAP.replace('columns = ["qx", "qy", "qz", "qw"]\norder = "xyzw"', 'columns = ["r", "p", "h"]\norder = "rpy"\nunit = "deg"')
        text = text.replace('kind = "pwm"', 'kind = "throttle"\nrange = [0, 65535]')
        code, log, err = self.take(self.write("log.csv", csv(columns)), "--map", self.write("m.toml", text))
        self.assertEqual((code, err), (0, ""))
        written = self.written()
        np.testing.assert_allclose(np.abs(sum(written["q" + k] * columns["q" + k] for k in "wxyz")), 1.0, atol=1e-6)
        np.testing.assert_allclose(written["u2"], columns["m2"] / 65535.0, atol=1e-8)


class Rates(FormatCase):
    """50 Hz columns in 250 Hz rows: no warning, and no made-up rate."""

    def slow(self, seed: int = 1) -> dict:
        columns = flight(20.0, 250.0, seed)
        for k, name in enumerate(("x", "y", "z", "vx", "vy", "vz", "qx", "qy", "qz", "qw")):
            columns[name] = np.where(np.arange(len(columns["t"])) % 5 == 0, columns[name], np.nan)
        return columns

    def test_empty_cells_between_samples(self):
        code, log, err = self.take(self.write("log.csv", csv(self.slow())), "--map", self.map)
        self.assertEqual((code, err, log["findings"]), (0, "", []))
        self.assertEqual([log["flights"][0]["rates_hz"][k] for k in ("position", "attitude", "body_rate")], [50, 50, 250])

    def test_noisy_positions_do_not_make_the_velocity_a_multiple(self):
        columns, noise = flight(40.0, 50.0), np.random.default_rng(6)
        for name in ("x", "y", "z"):
            columns[name] = columns[name] + noise.normal(0, 0.01, len(columns[name]))
        code, log, _ = self.take(self.write("log.csv", csv(columns)), "--map", self.map)
        self.assertEqual((code, [f for f in log["findings"] if "multiple" in f["says"]]), (0, []))

    def test_held_columns_have_their_real_rate(self):
        columns = flight(20.0, 250.0)
        for name in ("x", "y", "z", "vx", "vy", "vz", "qx", "qy", "qz", "qw"):
            columns[name] = np.repeat(columns[name][::5], 5)
        _, log, _ = self.take(self.write("log.csv", csv(columns)), "--map", self.map)
        held = [f for f in log["findings"] if f["kind"] == "held"]
        self.assertTrue(held and all("at about 50 Hz" in f["says"] for f in held), held)

    def test_one_warning_not_sixteen(self):
        columns = flight()
        for name in columns.keys() - {"t"}:
            columns[name][700:703] = np.nan
        _, log, _ = self.take(self.write("log.csv", csv(columns)), "--map", self.map)
        self.assertEqual(len([f for f in log["findings"] if f["kind"] == "gap"]), 1, log["findings"])


class TopicRates(unittest.TestCase):
    def test_neither_gaps_nor_bursts_count(self):
        from gustlab_import.streams import rate_of
        fast = np.arange(0.0, 20.0, 0.005)
        self.assertAlmostEqual(rate_of(np.concatenate([fast, 900.0 + fast])), 200.0, delta=1e-6)
        self.assertEqual(rate_of(np.concatenate([5.2 + 4e-6 * np.arange(90), np.arange(6.5, 20.0)])), 1.0)
        self.assertEqual(rate_of(np.array([3.0, 3.0])), 0.0)


class WrongMaps(FormatCase):
    """Each wrong key of a map: exit 2 or 3, one line, no traceback."""

    def test_each(self):
        log = self.write("log.csv", csv(flight(3.0)))
        cases = {'`columns` must be a list of names': MAP.replace('columns = ["x", "y", "z"]', 'columns = "xyz"'),
                 '`column` must be a text in quotes': MAP.replace('column = "t"', "column = 5"),
                 '`unit` must be a text in quotes': MAP.replace('unit = "rad/s"', "unit = 1"),
                 '[rate] signs = [1, -1]': MAP.replace('unit = "rad/s"', 'unit = "rad/s"\nsigns = [1, -1]'),
                 '`signs` must be a list of numbers from -1 to 1': MAP.replace('unit = "rad/s"', 'unit = "rad/s"\nsigns = [1, -7, 1]'),
                 '[actuator] range = [5, 2]': MAP.replace('kind = "pwm"', 'kind = "throttle"\nrange = [5, 2]'),
                 '[attitude] has a unit and quaternions have none': MAP.replace('order = "xyzw"', 'order = "xyzw"\nunit = "deg"'),
                 '[attitude] needs 3 columns, not 4': MAP.replace('order = "xyzw"', 'order = "rpy"'),
                 '`zero` must be true or false': MAP.replace('column = "t"', 'column = "t"\nzero = "yes"'),
                 'frame = "nwu" is not known; one of: enu, ned': MAP.replace('columns = ["x", "y", "z"]', 'columns = ["x", "y", "z"]\nframe = "nwu"'),
                 'kind = "xls" is not known': MAP.replace('kind = "csv"', 'kind = "xls"'),
                 'rows are 0.01 us apart': MAP.replace('column = "t"', 'column = "t"\nunit = "us"'),
                 'no column `q0`': MAP.replace('"qx", "qy"', '"q0", "qy"')}
        for words, text in cases.items():
            with self.subTest(words):
                code, _, err = self.take(log, "--map", self.write("m.toml", text))
                self.assertEqual((code in (2, 3), words in err, len(err.strip().splitlines())), (True, True, 1), err)
                self.assertFalse(self.out.exists())

    def test_microseconds_called_milliseconds(self):
        columns = flight(3.0)
        columns["t"] = np.round(1e6 * columns["t"])
        code, _, err = self.take(self.write("log.csv", csv(columns)), "--map",
                                 self.write("m.toml", MAP.replace('column = "t"', 'column = "t"\nunit = "ms"')))
        self.assertEqual((code, "[time] unit is too large (is it in ms or us?)" in err), (3, True), err)

    def test_command_lines(self):
        log = self.write("log.csv", csv(flight(3.0)))
        ulg = self.write("a.xyz", b"nothing that is known" * 9)
        bag = self.folder / "bag"
        bag.mkdir()
        self.write("bag/bag_0.db3", b"SQLite format 3\0")
        cases = {f"bag: a folder; give the log in it: {bag / 'bag_0.db3'}": [bag], "`gustlab defaults column-map` prints one": [log],
                 "needs a column map": [log], "no vehicle of this name": [log, "--map", self.map, "--vehicle", "crazyfly"],
                 "no built-in map and no file of this name": [log, "--map", "nothing.toml"],
                 "no log format that is known begins like this": [ulg], "cannot be read": [self.folder / "missing.ulg"],
                 "invalid seconds value": [log, "--map", self.map, "--from", "soon"],
                 "the following arguments are required": ["--out", self.out]}
        for words, arguments in cases.items():
            with self.subTest(words):
                code, _, err = self.run_import(*arguments, *([] if "--out" in arguments else ["--out", self.out]))
                self.assertEqual((code in (2, 3), words in err, len(err.strip().splitlines())), (True, True, 1), err)
                self.assertFalse(self.out.exists())


if __name__ == "__main__":
    unittest.main()
