"""ArduPilot DataFlash and MAVLink telemetry logs (pymavlink) -> Recording."""

import contextlib
import hashlib
import os
import sys
import tempfile
import warnings
from collections import defaultdict
from pathlib import Path

import numpy as np

from . import airframes, frames
from .motors import ardupilot_range, ardupilot_share, pulse_share, put_speeds
from .problems import Finding, ImportFailure
from .progress import stage
from .streams import ATTITUDE, BATTERY, FORCE, POSITION, RATE, VELOCITY, Recording, rate_of, spans, stream
from .tables import read_bytes

STANDARD_GRAVITY = 9.80665
# EV.Id (AP_Logger, LogEvent): what arms, disarms, lands and takes off
ARMED, DISARMED, LANDED, FLYING = (10, 15), (11,), (18,), (28,)
CRASH_CHECK = 12                       # ERR.Subsys
LAST_s = 0.1                            # before a log's end: nothing that flew comes after it
MOTOR_FUNCTIONS = range(33, 41)        # SERVOn_FUNCTION of motors 1 to 8
FRAMES = {(1, 0): "quadrotor +", (1, 1): "quadrotor x", (2, 0): "hexarotor +", (2, 1): "hexarotor x", (3, 0): "octorotor +",
          (3, 1): "octorotor x"}
NO_MULTIROTOR = {1: "a fixed-wing aircraft", 4: "a helicopter", 10: "a ground vehicle", 11: "a boat", 12: "a submarine",
                 **{number: "a VTOL" for number in range(19, 26)}}
SETTINGS = {"rate": "LOG_BITMASK: set bits 0 (fast attitude), 10 (RC output) and 18 (fast IMU), and INS_LOG_BAT_MASK for bursts",
            "battery": "LOG_BITMASK: set bit 9 (current), and a power module (BATT_MONITOR)",
            "pose": "LOG_BITMASK: set bits 0 or 1 (attitude) and an estimator with position (EK3_ENABLE)"}
TELEMETRY = {"rate": "SRn_* stream rates (50 Hz and more), or better the vehicle's own DataFlash log",
             "battery": "SRn_EXT_STAT", "pose": "SRn_POSITION and SRn_EXTRA1"}


def read_dataflash(path: Path) -> Recording:
    from pymavlink import DFReader  # a second to import
    data = read_bytes(path)
    if not data.startswith((b"\xa3\x95", b"FMT,")):
        raise ImportFailure(f"{path}: byte 0: a DataFlash log begins with A3 95, or as text with FMT; is it another kind of log?")
    try:
        with warnings.catch_warnings(), _set_aside() as said:
            warnings.simplefilter("ignore")
            log = DFReader.DFReader_text(str(path)) if data.startswith(b"FMT,") else DFReader.DFReader_binary(str(path))
            messages = _collect(log, lambda m: m.get_type(), _dataflash_time)
    except Exception as error:  # pymavlink raises whatever a damaged byte leads to
        raise ImportFailure(f"{path}: the DataFlash log cannot be read ({type(error).__name__}: {error}); fetch it again") from error
    if not messages:
        raise ImportFailure(f"{path}: the DataFlash log holds no messages (cut off after its formats?); fetch it again")
    recording = _DataFlash(str(path), data, messages).recording()
    if lost := sum(line.startswith(b"bad header") for line in said[0].splitlines()):
        recording.findings.append(Finding("gap", "time_s", 0.0, recording.end_s, "warning", f"the file is damaged in places ({lost} bytes that are no message)"))
    return recording


@contextlib.contextmanager
def _set_aside():
    """What pymavlink and its compiled reader write to stderr, a line for each byte or message that they skip: a list of one bytes object."""
    said = [b""]
    sys.stderr.flush()
    real = os.dup(2)
    with tempfile.TemporaryFile() as file:
        os.dup2(file.fileno(), 2)
        try:
            with open(2, "w", closefd=False) as text, contextlib.redirect_stderr(text):
                yield said
        finally:
            os.dup2(real, 2)
            os.close(real)
            file.seek(0)
            said[0] = file.read()


def _dataflash_time(message) -> float:
    """Seconds of the vehicle's clock."""
    if hasattr(message, "TimeUS"):
        return message.TimeUS * 1e-6
    # GPS.TimeMS is of the week
    return message.TimeMS * 1e-3 if hasattr(message, "TimeMS") and message.get_type() != "GPS" else np.nan


def _collect(log, kind, time) -> dict:
    """type -> list of (time_s, message)"""
    out = defaultdict(list)
    stage("reading", lambda: 0.01 * log.percent)
    while (message := log.recv_msg()) is not None:
        if message.get_type() not in ("FMT", "FMTU", "UNIT", "MULT", "BAD_DATA"):
            out[kind(message)].append((time(message), message))
    return dict(out)


class _Messages:
    """What both formats share: columns of message types, on the vehicle's clock from the log's start on."""

    def __init__(self, name: str, data: bytes, messages: dict, kind: str, settings: dict):
        self.messages = messages
        times = [t for many in messages.values() for t, _ in many if np.isfinite(t)]
        if not times:
            raise ImportFailure(f"{name}: no message has a time; fetch the log again")
        # parameters may carry the time of the start of the computer
        self.zero = min((t for label, many in messages.items() if len(many) >= 20 and label != "PARM" for t, _ in many
                         if np.isfinite(t)), default=min(times))
        self.out = Recording(name, hashlib.sha256(data).hexdigest(), kind, end_s=max(times) - self.zero, settings=settings)
        for label, many in sorted(messages.items(), key=lambda item: str(item[0])):
            self.out.topics.append((str(label), len(many), rate_of(np.array([t for t, _ in many if np.isfinite(t)]))))

    def get(self, label, *names: str):
        """(time_s (n,), values (n, len(names))) of a message type, or None."""
        many = self.messages.get(label)
        if not many or not all(hasattr(many[0][1], name) for name in names):
            return None
        return (np.array([t for t, _ in many]) - self.zero,
                np.array([[getattr(m, name) for name in names] for _, m in many], dtype=float))

    def put(self, name: str, columns, label, names, convert) -> bool:
        """Reads a stream; False when the message or a field of it is not there."""
        found = self.get(label, *names)
        if found is None or name in self.out.streams:
            return name in self.out.streams
        self.out.put(name, stream(columns, found[0], convert(found[1]), str(label)))
        return name in self.out.streams


class _DataFlash(_Messages):
    def __init__(self, name: str, data: bytes, messages: dict):
        super().__init__(name, data, messages, "ardupilot-dataflash", SETTINGS)
        self.parameters = {m.Name: m.Value for _, m in messages.get("PARM", [])}

    def recording(self) -> Recording:
        self.vehicle()
        self.states()
        self.pose()
        self.inertial()
        self.motors()
        self.battery()
        return self.out

    def vehicle(self) -> None:
        said = [m.Message for _, m in self.messages.get("MSG", [])]
        version = next((text for text in said if text.startswith(("ArduCopter", "ArduPlane", "ArduRover", "ArduSub"))), "")
        self.out.autopilot = version.split(" (")[0] or "ArduPilot"
        p = self.parameters
        if version.startswith(("ArduPlane", "ArduRover", "ArduSub")):
            self.out.no_flight = f"{version.split(' ')[0]}, not a multirotor"
        frame_class = int(p.get("FRAME_CLASS", 1)) or 1
        frame_type = int(p.get("FRAME_TYPE", p.get("FRAME", 1)))
        name = FRAMES.get((frame_class, 0 if frame_type == 0 else 1))
        self.out.airframe = name or f"FRAME_CLASS {frame_class}"
        self.out.rotors = airframes.rotors(airframes.PX4[name]) if name else []
        keep = ("LOG_BITMASK", "MOT_THST_EXPO", "MOT_SPIN_MIN", "MOT_SPIN_MAX", "MOT_THST_HOVER", "INS_GYRO_FILTER", "SCHED_LOOP_RATE")
        self.out.facts.update({key: float(f"{p[key]:.7g}") for key in keep if key in p})

    def states(self) -> None:
        events = [(t - self.zero, m.Id) for t, m in self.messages.get("EV", [])]
        # of old logs events have no time of their own: the message before them tells
        events = [(t, e) for t, e in events if np.isfinite(t)] or self.untimed_events()
        self.out.armed = self.state(events, ARMED, DISARMED)
        self.out.flying = self.state(events, FLYING, LANDED)
        self.crashes()

    def crashes(self) -> None:
        """Cuts where the crash check fired; a log that ends there has nothing to cut, and says it."""
        for t, m in self.messages.get("ERR", []):
            if m.Subsys != CRASH_CHECK or m.ECode != 1:
                continue
            at = t - self.zero if np.isfinite(t) else m._timestamp - self.first_stamp()
            if at < self.out.end_s - LAST_s:
                self.out.breaks.append((at, "the vehicle's crash check fired"))
            else:
                self.out.findings.append(Finding("gap", "time_s", self.out.end_s, self.out.end_s, "warning",
                                                 "the vehicle's crash check fired, and the log ends: the last seconds may be a fall"))

    def untimed_events(self) -> list:
        return [(m._timestamp - self.first_stamp(), m.Id) for _, m in self.messages.get("EV", [])]

    def first_stamp(self) -> float:
        return next(m._timestamp - (t - self.zero) for many in self.messages.values() for t, m in many if np.isfinite(t))

    def state(self, events: list, begin: tuple, end: tuple):
        """Spans of a state; before the first event it was the opposite of what that event made it. None without events."""
        mine = [(t, e in begin) for t, e in events if e in begin + end]
        if not mine:
            return None
        time_s = np.array([0.0] + [t for t, _ in mine])
        return spans(time_s, [not mine[0][1]] + [on for _, on in mine], self.out.end_s)

    def pose(self) -> None:
        self.put("attitude", ATTITUDE, "ATT", ("Roll", "Pitch", "Yaw"), lambda v: frames.attitude_flu(frames.attitude_enu(
            frames.from_euler(*np.radians(v).T))))
        wanted = {2: "NKF", 3: "XKF"}.get(int(self.parameters.get("AHRS_EKF_TYPE", 0)))
        for prefix in dict.fromkeys(p for p in (wanted, "XKF", "NKF", "EKF") if p):
            label, says = self.primary(prefix)
            if self.put("position", POSITION, label, ("PN", "PE", "PD"), frames.enu):
                self.put("velocity", VELOCITY, label, ("VN", "VE", "VD"), frames.enu)
                self.out.facts["estimator"] = says
                break

    def primary(self, prefix: str) -> tuple:
        """(message of the core that flew, what to say)"""
        fourth = self.messages.get(prefix + "4", [])
        core = int(getattr(fourth[-1][1], "PI", 0)) if fourth else 0
        labels = [prefix + "1", prefix + "6"]
        if any(hasattr(m, "C") for _, m in self.messages.get(prefix + "1", [])[:1]):
            # newer logs have one message for all cores
            mine = [(t, m) for t, m in self.messages[prefix + "1"] if int(m.C) == core]
            self.messages[f"{prefix}1[{core}]"] = mine
            return f"{prefix}1[{core}]", f"core {core} of {len({int(m.C) for _, m in self.messages[prefix + '1']})} ({prefix}4.PI)"
        label = labels[min(core, 1)]
        return label, f"core {core} ({label})"

    def inertial(self) -> None:
        label = "IMU"
        if any(hasattr(m, "I") for _, m in self.messages.get("IMU", [])[:1]):
            self.messages["IMU[0]"] = [(t, m) for t, m in self.messages["IMU"] if int(m.I) == 0]
            label = "IMU[0]"
        self.put("body_rate", RATE, label, ("GyrX", "GyrY", "GyrZ"), frames.flu)
        self.put("specific_force", FORCE, label, ("AccX", "AccY", "AccZ"), frames.flu)
        count = len({str(k) for k in self.messages if str(k) in ("IMU", "IMU2", "IMU3")})
        if count > 1:
            self.out.facts["imu"] = f"the first of {count}"

    def motors(self) -> None:
        channels = sorted((int(key[5:-9]), int(value)) for key, value in self.parameters.items()
                          if key.startswith("SERVO") and key.endswith("_FUNCTION") and int(value) in MOTOR_FUNCTIONS)
        count = len(self.out.rotors) or 4
        numbers = [c for _, c in sorted((function, c) for c, function in channels)] or list(range(1, count + 1))
        first = self.messages.get("RCOU", [(0, None)])[0][1]
        names = [f"{'Ch' if hasattr(first, 'Ch1') else 'C'}{number}" for number in numbers]
        found = self.get("RCOU", *names)
        if found is None:
            self.out.facts["no_motors"] = "there is no RCOU message (LOG_BITMASK bit 10)"
            return
        low, high = ardupilot_range(self.parameters)
        share, says = ardupilot_share(pulse_share(found[1], low, high), self.parameters)
        self.out.put("u", stream([f"u{k + 1}" for k in range(len(names))], found[0], share,
                                 f"RCOU {names[0]} to {names[-1]}, {low:g} to {high:g} us, {says}"))
        self.speeds(numbers)

    def speeds(self, numbers: list) -> None:
        """What the speed controllers report (ESC, one message for each), at the times of the first."""
        mine = [[(t - self.zero, float(m.RPM)) for t, m in self.messages.get("ESC", []) if int(m.Instance) == number - 1] for number in numbers]
        if not mine or any(len(one) < 2 for one in mine):
            return
        first = np.array([t for t, _ in mine[0]])
        columns = []
        for one in mine:
            time_s, rpm = np.array(one).T
            # the others answer within the same round: the nearest sample is theirs
            place = np.clip(np.searchsorted(time_s, first), 1, len(time_s) - 1)
            nearest = place - (first - time_s[place - 1] < time_s[place] - first)
            apart = np.abs(time_s[nearest] - first) > 0.5 * np.median(np.diff(first))
            columns.append(np.where(apart, np.nan, rpm[nearest]))
        put_speeds(self.out, first, np.column_stack(columns), "ESC")

    def battery(self) -> None:
        for label in ("BAT", "CURR"):
            if self.put("vbat", BATTERY, label, ("Volt",), lambda v: v):
                break
        if (power := self.get("POWR", "Vcc")) is not None:
            self.out.supply = stream(("supply",), *power, "POWR.Vcc")


def read_tlog(path: Path) -> Recording:
    os.environ["MAVLINK20"] = "1"
    from pymavlink import mavutil  # a second to import
    data = read_bytes(path)
    try:
        with warnings.catch_warnings(), _set_aside():
            warnings.simplefilter("ignore")
            log = mavutil.mavlink_connection(str(path))
            messages = _collect(log, lambda m: (m.get_type(), m.get_srcSystem(), m.get_srcComponent()), _boot_time)
    except Exception as error:  # pymavlink raises whatever a damaged byte leads to
        raise ImportFailure(f"{path}: the tlog cannot be read (cut off within its first message, or damaged); fetch it again") from error
    beats = [key for key, many in messages.items() if key[0] == "HEARTBEAT" and many[0][1].autopilot != 8]
    if not beats:
        raise ImportFailure(f"{path}: no heartbeat of an autopilot is in the tlog: not MAVLink telemetry, or cut off")
    return _Telemetry(str(path), data, messages, beats[0]).recording()


def _boot_time(message) -> float:
    """Seconds of the vehicle's clock, which does not jitter as the receiver's does."""
    if hasattr(message, "time_boot_ms"):
        return message.time_boot_ms * 1e-3
    return message.time_usec * 1e-6 if hasattr(message, "time_usec") and message.time_usec < 1e14 else np.nan


class _Telemetry(_Messages):
    def __init__(self, name: str, data: bytes, messages: dict, beat: tuple):
        mine = {key[0]: self.on_vehicle_clock(many, messages) for key, many in messages.items() if key[1:] == beat[1:]}
        super().__init__(name, data, mine, "mavlink-tlog", TELEMETRY)

    @staticmethod
    def on_vehicle_clock(many: list, messages: dict) -> list:
        """Messages without a time of the vehicle (heartbeats) get that of the receiver, less the median difference."""
        if any(np.isfinite(t) for t, _ in many):
            return many
        late = np.median([m._timestamp - t for group in messages.values() for t, m in group if np.isfinite(t)][:2000] or [0.0])
        return [(m._timestamp - late, m) for _, m in many]

    def recording(self) -> Recording:
        beats = self.messages["HEARTBEAT"]
        system = int(beats[0][1].type)
        says = [m.text for _, m in self.messages.get("STATUSTEXT", [])]
        self.out.autopilot = next((text.split(" (")[0] for text in says if text.startswith(("APM:", "ArduCopter", "PX4"))),
                                  "PX4" if beats[0][1].autopilot == 12 else "ArduPilot")
        if system in NO_MULTIROTOR:
            self.out.no_flight = f"{NO_MULTIROTOR[system]} (MAV_TYPE {system}), not a multirotor"
        name = {2: "quadrotor x", 13: "hexarotor x", 14: "octorotor x"}.get(system)
        self.out.airframe = name or "multirotor"
        self.out.rotors = airframes.rotors(airframes.PX4[name]) if name else []
        time_s = np.array([t for t, _ in beats]) - self.zero
        self.out.armed = spans(time_s, [bool(m.base_mode & 128) for _, m in beats], self.out.end_s)
        self.streams()
        return self.out

    def streams(self) -> None:
        turned = lambda v: frames.attitude_flu(frames.attitude_enu(v))  # noqa: E731
        self.put("attitude", ATTITUDE, "ATTITUDE_QUATERNION", ("q1", "q2", "q3", "q4"), turned)
        self.put("attitude", ATTITUDE, "ATTITUDE", ("roll", "pitch", "yaw"), lambda v: turned(frames.from_euler(*v.T)))
        self.put("position", POSITION, "LOCAL_POSITION_NED", ("x", "y", "z"), frames.enu)
        self.put("velocity", VELOCITY, "LOCAL_POSITION_NED", ("vx", "vy", "vz"), frames.enu)
        for label in ("HIGHRES_IMU", "RAW_IMU", "SCALED_IMU"):
            milli = 1.0 if label == "HIGHRES_IMU" else 1e-3
            self.put("body_rate", RATE, label, ("xgyro", "ygyro", "zgyro"), lambda v, k=milli: k * frames.flu(v))
            gravity = 1.0 if label == "HIGHRES_IMU" else 1e-3 * STANDARD_GRAVITY
            self.put("specific_force", FORCE, label, ("xacc", "yacc", "zacc"), lambda v, k=gravity: k * frames.flu(v))
        count = len(self.out.rotors) or 4
        self.put("u", [f"u{k + 1}" for k in range(count)], "SERVO_OUTPUT_RAW", [f"servo{k + 1}_raw" for k in range(count)],
                 lambda v: pulse_share(v, 1000.0, 2000.0))
        self.put("vbat", BATTERY, "SYS_STATUS", ("voltage_battery",), lambda v: 1e-3 * v)
