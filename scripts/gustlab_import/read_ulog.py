"""PX4 ULog (pyulog) -> Recording: north-east-down and forward-right-down become the flight log's frames here."""

import contextlib
import hashlib
import io
from pathlib import Path

import numpy as np

from . import airframes, frames
from .motors import allocated_motors, pulse_share, put_speeds, thrust_share
from .problems import Finding, ImportFailure
from .progress import stage
from .streams import ATTITUDE, BATTERY, FORCE, POSITION, RATE, VELOCITY, Recording, Rotor, rate_of, spans, stream
from .tables import read_bytes
from .ulog_damage import without_damage

# MAV_TYPE (MAVLink common.xml) of what is no multirotor; 2, 13, 14, 15 and 29 are multirotors
NO_MULTIROTOR = {1: "a fixed-wing aircraft", 3: "a coaxial helicopter", 4: "a helicopter", 7: "an airship", 8: "a balloon",
                 10: "a ground vehicle", 11: "a boat", 12: "a submarine",
                 **{number: "a VTOL (tiltrotor, tailsitter or other)" for number in range(19, 26)}}
MAX_ROTORS = 8
FIRST_MOTOR = 101     # OutputFunction Motor1, of esc_status
MOST_PLACES = 3       # of damage that are said one by one
LOGGER_GAP_s = 60.0   # without any message
RESET_m, RESET_rad = 0.1, 0.035   # jumps of the estimate that a prediction over a second would show
SETTINGS = {"rate": "SDLOG_PROFILE: set bits 3 (system identification) and 4 (high rate)",
            "battery": "battery_status needs a power module; SDLOG_PROFILE bit 0 (default) logs it",
            "rotor": "ESCs with telemetry (bidirectional DShot, DroneCAN) and SDLOG_PROFILE bit 4 (high rate)",
            "pose": "SDLOG_PROFILE bit 0 (default set) logs vehicle_local_position and vehicle_attitude"}


def read_ulog(path: Path) -> Recording:
    return _Reader(str(path), read_bytes(path)).recording()


def load(name: str, data: bytes, topics=None):
    """(ULog, what pyulog says of it), of bytes `without_damage`: in others pyulog may read for ever."""
    from pyulog import ULog  # a second to import
    if data[:7] != b"ULog\x01\x12\x35":
        raise ImportFailure(f"{name}: byte 0: not a PX4 ULog (the file does not begin with its mark); fetch it again")
    said, file = io.StringIO(), io.BytesIO(data)
    stage("reading", lambda: file.tell() / len(data))
    try:
        # what pyulog prints would stand in the middle of the document
        with contextlib.redirect_stdout(said):
            return ULog(file, topics), " ".join(dict.fromkeys(said.getvalue().split("\n"))).strip()
    except Exception as error:  # pyulog raises whatever a damaged byte leads to
        raise ImportFailure(f"{name}: the ULog cannot be read ({type(error).__name__}: {error}); fetch it again") from error


def _place(part) -> str:
    return f"{part.end - part.first} bytes from byte {part.first} on"


class _Reader:
    def __init__(self, name: str, data: bytes):
        whole, lost, cut = without_damage(data)
        self.log, damage = load(name, whole)
        self.data = {(d.name, d.multi_id): d.data for d in self.log.data_list if len(d.data.get("timestamp", ()))}
        if not self.data:
            raise ImportFailure(f"{name}: the ULog holds no samples (cut off after its header?); fetch it again")
        self.parameters = self.log.initial_parameters
        self.zero = int(self.log.start_timestamp)
        self.end_s = self.seconds(np.array([self.log.last_timestamp]))[0]
        self.out = Recording(name, hashlib.sha256(data).hexdigest(), "px4-ulog", self.version(), end_s=float(self.end_s),
                             settings=SETTINGS)
        if damage and not lost:
            self.say_lost(0.0, self.end_s, f"the file is damaged in places ({damage[:160]})")
        self.damaged(lost, cut, len(data))

    def say_lost(self, from_s: float, to_s: float, says: str, severity: str = "warning") -> None:
        self.out.findings.append(Finding("gap", "time_s", float(from_s), float(to_s), severity, says))

    def damaged(self, lost: list, cut, size: int) -> None:
        """Says what of the file could not be read: of many places the count, and where most of the bytes are."""
        spans_s = [(self.second(part.before_us, 0.0), self.second(part.after_us, self.end_s)) for part in lost]
        if len(lost) > MOST_PLACES:
            worst = max(range(len(lost)), key=lambda k: lost[k].end - lost[k].first)
            self.say_lost(spans_s[0][0], spans_s[-1][1], f"the file is damaged in places, {len(lost)} of them: {sum(p.end - p.first for p in lost)} of its "
                          f"{size} bytes are no messages ({_place(lost[worst])} in one place), and what they held is missing")
        else:
            for part, (from_s, to_s) in zip(lost, spans_s):
                self.say_lost(from_s, to_s, f"the file is damaged in places: {_place(part)} are no messages, and of {from_s:.2f} to "
                              f"{to_s:.2f} s everything or something is missing")
        if cut is not None:
            self.say_lost(self.end_s, self.end_s, f"the file ends early, within a message ({cut[0]} of {cut[1]} bytes): {self.end_s:.2f} s were read; it was "
                          "cut off, or the power went, and whatever came later is missing")

    def second(self, stamp_us, otherwise: float) -> float:
        return otherwise if stamp_us is None else float(self.seconds(np.array([stamp_us]))[0])

    def version(self) -> str:
        release = (self.log.get_version_info_str() or "").lstrip("v")
        return " ".join(part for part in (self.log.msg_info_dict.get("sys_name", "PX4"), release) if part)

    def seconds(self, stamp: np.ndarray) -> np.ndarray:
        return (stamp.astype(np.int64) - self.zero) * 1e-6

    def get(self, name: str, instance: int = 0):
        return self.data.get((name, instance))

    def instances(self, name: str) -> list:
        return sorted(number for topic, number in self.data if topic == name)

    def measured_at(self, data: dict) -> np.ndarray:
        """Seconds of the measurement, where the topic says it, not of its publication."""
        stamp = data.get("timestamp_sample")
        return self.seconds(stamp if stamp is not None and np.all(stamp > 0) else data["timestamp"])

    def recording(self) -> Recording:
        self.topics()
        self.vehicle()
        self.states()
        if not self.out.no_flight:
            self.pose()
            self.inertial()
            self.motors()
            self.speeds()
            self.battery()
            self.reference()
        return self.out

    def topics(self) -> None:
        for (name, number), data in sorted(self.data.items()):
            time_s = self.seconds(data["timestamp"])
            self.out.topics.append((f"{name}[{number}]", len(time_s), rate_of(time_s)))
        everything = np.unique(np.concatenate([data["timestamp"] for data in self.data.values()]))
        everything = everything[everything >= self.zero]
        holes = np.flatnonzero(np.diff(everything) > 1e6 * LOGGER_GAP_s)
        for k in holes:
            from_s, to_s = self.seconds(everything[k:k + 2])
            after = [name for (name, _), data in sorted(self.data.items()) if np.any(data["timestamp"] >= everything[k + 1])]
            only = "" if len(after) > 3 else f"; after it there is only {', '.join(after)}, perhaps with the time of an earlier start"
            self.say_lost(from_s, to_s, f"nothing at all was logged for {(to_s - from_s) / 60:.1f} min{only}")

    def vehicle(self) -> None:
        status = self.get("vehicle_status") or {}
        system = int(status["system_type"][-1]) if "system_type" in status else int(self.parameters.get("MAV_TYPE", 2))
        if system in NO_MULTIROTOR:
            self.out.no_flight = f"{NO_MULTIROTOR[system]} (MAV_TYPE {system}), not a multirotor"
            self.out.airframe = NO_MULTIROTOR[system].split(" ", 1)[1]
        elif "is_vtol" in status and status["is_vtol"].any():
            self.out.no_flight, self.out.airframe = "a VTOL (vehicle_status.is_vtol), not a multirotor", "VTOL"
        elif "vehicle_type" in status and int(status["vehicle_type"][-1]) not in (0, 1):
            self.out.no_flight = f"vehicle_status.vehicle_type {int(status['vehicle_type'][-1])}, not a rotary wing"
        else:
            self.out.rotors = self.geometry(system)
            self.out.airframe = airframes.name_of(self.out.rotors) if self.out.rotors else "multirotor"
        keep = ("SYS_AUTOSTART", "SDLOG_PROFILE", "THR_MDL_FAC", "MPC_THR_HOVER", "IMU_GYRO_CUTOFF", "SYS_HITL")
        self.out.facts.update({key: float(f"{self.parameters[key]:.7g}") for key in keep if key in self.parameters})

    def geometry(self, system: int) -> list:
        """Rotors from CA_ROTOR*, or from the numbering of the airframe that SYS_AUTOSTART names."""
        p, count = self.parameters, int(self.parameters.get("CA_ROTOR_COUNT", 0))
        if 3 <= count <= MAX_ROTORS and any(p.get(f"CA_ROTOR{k}_PX") for k in range(count)):
            of = lambda key, k: float(p.get(f"CA_ROTOR{k}_{key}", 0.0))  # noqa: E731
            return [Rotor(round(of("PX", k), 6), round(-of("PY", k), 6), 1 if of("KM", k) > 0 else -1) for k in range(count)]
        group = int(p.get("SYS_AUTOSTART", 0)) // 1000
        name = {4: "quadrotor x", 5: "quadrotor +", 6: "hexarotor x", 7: "hexarotor +", 8: "octorotor x",
                9: "octorotor +"}.get(group) or {2: "quadrotor x", 13: "hexarotor x", 14: "octorotor x"}.get(system)
        return airframes.rotors(airframes.PX4[name]) if name else []

    def states(self) -> None:
        status, landed = self.get("vehicle_status"), self.get("vehicle_land_detected")
        armed = self.get("actuator_armed")
        if armed is not None and "armed" in armed:
            self.out.armed = spans(self.seconds(armed["timestamp"]), armed["armed"] != 0, self.end_s)
        elif status is not None and "arming_state" in status:
            self.out.armed = spans(self.seconds(status["timestamp"]), status["arming_state"] == 2, self.end_s)
        if landed is not None and "landed" in landed:
            self.out.flying = spans(self.seconds(landed["timestamp"]), landed["landed"] == 0, self.end_s)

    def pose(self) -> None:
        attitude, position = self.get("vehicle_attitude"), self.get("vehicle_local_position")
        if attitude is not None:
            q = np.column_stack([attitude[f"q[{k}]"] for k in range(4)])
            self.out.put("attitude", stream(ATTITUDE, self.measured_at(attitude), frames.attitude_flu(frames.attitude_enu(q)),
                                            "vehicle_attitude[0]"))
        if position is None:
            return
        for name, columns, keys, valid in (("position", POSITION, "x y z", "{}_valid"), ("velocity", VELOCITY, "vx vy vz", "v_{}_valid")):
            values = np.column_stack([position[key] for key in keys.split()]).astype(float)
            horizontal, vertical = (position.get(valid.format(axis)) for axis in ("xy", "z"))
            if horizontal is not None:
                values[horizontal == 0, :2] = np.nan
            if vertical is not None:
                values[vertical == 0, 2] = np.nan
            self.out.put(name, stream(columns, self.measured_at(position), frames.enu(values), "vehicle_local_position[0]"))
        self.resets(position)
        if np.isfinite(position.get("ref_lat", [np.nan])[-1]):
            self.out.location = {"latitude_deg": float(position["ref_lat"][-1]), "longitude_deg": float(position["ref_lon"][-1])}

    def resets(self, position: dict) -> None:
        """Jumps of the estimate that PX4 counts and measures itself."""
        time_s = self.measured_at(position)
        for counter, deltas, limit, unit in (("xy_reset_counter", ("delta_xy[0]", "delta_xy[1]"), RESET_m, "m"),
                                             ("z_reset_counter", ("delta_z",), RESET_m, "m"),
                                             ("vxy_reset_counter", ("delta_vxy[0]", "delta_vxy[1]"), RESET_m, "m/s"),
                                             ("vz_reset_counter", ("delta_vz",), RESET_m, "m/s"),
                                             ("heading_reset_counter", ("delta_heading",), RESET_rad, "rad")):
            if counter not in position or any(key not in position for key in deltas):
                continue
            for k in np.flatnonzero(np.diff(position[counter].astype(int)) != 0) + 1:
                size = float(np.hypot.reduce([position[key][k] for key in deltas]))
                if abs(size) > limit:
                    what = counter.removesuffix("_reset_counter")
                    self.out.breaks.append((float(time_s[k]), f"the estimator was reset ({what} by {abs(size):.2f} {unit})"))

    def inertial(self) -> None:
        """Both from sensor_combined, whose samples are means over the interval before them; the rate that the loops used is
        filtered, late and slower, and stands in only where there is no other."""
        combined, rate = self.get("sensor_combined"), self.get("vehicle_angular_velocity")
        if combined is not None:
            force = np.column_stack([combined[f"accelerometer_m_s2[{k}]"] for k in range(3)])
            self.out.put("specific_force", stream(FORCE, self.seconds(combined["timestamp"]), frames.flu(force),
                                                  "sensor_combined[0] accelerometer"))
            gyro = np.column_stack([combined[f"gyro_rad[{k}]"] for k in range(3)])
            self.out.put("body_rate", stream(RATE, self.seconds(combined["timestamp"]), frames.flu(gyro),
                                             "sensor_combined[0] gyroscope"))
        if rate is not None and ("body_rate" not in self.out.streams):
            self.out.put("body_rate", stream(RATE, self.measured_at(rate),
                                             frames.flu(np.column_stack([rate[f"xyz[{k}]"] for k in range(3)])),
                                             "vehicle_angular_velocity[0]"))
        sensors = len(self.instances("vehicle_imu")) or len(self.instances("sensor_gyro"))
        if sensors > 1:
            self.out.facts["imu"] = f"the one that the estimator selected, of {sensors} (sensor_combined)"

    def motors(self) -> None:
        count = len(self.out.rotors) or None
        for number in self.instances("actuator_motors"):
            data = self.get("actuator_motors", number)
            used = [k for k in range(MAX_ROTORS) if np.isfinite(data[f"control[{k}]"]).any()][:count]
            u = np.column_stack([data[f"control[{k}]"] for k in used]) if len(used) >= 3 else np.zeros((1, 1))
            if np.ptp(np.nan_to_num(u), axis=0).max() > 0.0:
                return self.commands(data, u, f"actuator_motors[{number}]")
        for number in self.instances("actuator_outputs"):
            data = self.get("actuator_outputs", number)
            pulses = np.column_stack([data[f"output[{k}]"] for k in range(count or 4)])
            if np.all(np.ptp(pulses, axis=0) > 1.0):
                low, high = self.parameters.get("PWM_MIN", 1000), self.parameters.get("PWM_MAX", 2000)
                others = [str(n) for n in self.instances("actuator_outputs") if n != number]
                beside = f" (instance {', '.join(others)} does not hold the motors)" if others else ""
                factor = float(self.parameters.get("THR_MDL_FAC", 0.0))
                factor = factor if 0.0 < factor <= 1.0 else 0.0
                curve = f", back through THR_MDL_FAC {factor:.3g}" if factor else ""
                return self.commands(data, thrust_share(pulse_share(pulses, low, high), factor),
                                     f"actuator_outputs[{number}] {low:g} to {high:g}{curve}{beside}")
        return None

    def commands(self, data: dict, u: np.ndarray, source: str) -> None:
        """Motor commands; where they are slow, and what they were allocated from is logged faster, from both."""
        names = [f"u{k + 1}" for k in range(u.shape[1])]
        motors = stream(names, self.seconds(data["timestamp"]), u, source)
        self.out.put("u", motors)
        torque, thrust = self.get("vehicle_torque_setpoint"), self.get("vehicle_thrust_setpoint")
        if motors is None or any(topic is None or "timestamp_sample" not in topic for topic in (torque, thrust, data)):
            return
        both, a, b = np.intersect1d(torque["timestamp_sample"], thrust["timestamp_sample"], return_indices=True)
        asked = np.column_stack([torque[f"xyz[{k}]"][a] for k in range(3)] + [thrust["xyz[2]"][b]]).astype(float)
        published_s = self.seconds(torque["timestamp"][a])
        filled, says = allocated_motors(both, asked, published_s, data["timestamp_sample"], u, self.seconds(data["timestamp"]))
        if filled is not None:
            time_s, values = filled
            self.out.put("u", stream(names, time_s, values, ""))
            faster = self.out.streams["u"].rate_hz()
            self.out.streams["u"].source = f"{source} {motors.rate_hz():.0f} Hz and torque and thrust set points {faster:.0f} Hz ({says})"
            self.out.facts["allocation"] = says
        elif says:
            self.out.facts["allocation"] = says

    def speeds(self) -> None:
        """What the speed controllers report; from 1.13 on each says which motor it drives."""
        data, motors = self.get("esc_status"), self.out.streams.get("u")
        if data is None or motors is None:
            return
        place = {}
        for k in range(MAX_ROTORS):
            if f"esc[{k}].esc_rpm" not in data:
                break
            function = data.get(f"esc[{k}].actuator_function")
            motor = int(function[-1]) - FIRST_MOTOR if function is not None and function[-1] >= FIRST_MOTOR else k
            place.setdefault(motor, k)
        if all(motor in place for motor in range(motors.values.shape[1])):
            rpm = np.column_stack([data[f"esc[{place[motor]}].esc_rpm"] for motor in range(motors.values.shape[1])])
            put_speeds(self.out, self.seconds(data["timestamp"]), rpm, "esc_status[0]")

    def battery(self) -> None:
        best = None
        for number in self.instances("battery_status"):
            data = self.get("battery_status", number)
            if best is None or np.nanmedian(data["voltage_v"]) > np.nanmedian(self.get("battery_status", best)["voltage_v"]):
                best = number
        if best is not None:
            data = self.get("battery_status", best)
            self.out.put("vbat", stream(BATTERY, self.seconds(data["timestamp"]), data["voltage_v"], f"battery_status[{best}]"))
        power = self.get("system_power")
        if power is not None and "voltage5v_v" in power:
            self.out.supply = stream(("supply",), self.seconds(power["timestamp"]), power["voltage5v_v"], "system_power")

    def reference(self) -> None:
        wanted = self.get("vehicle_local_position_setpoint")
        if wanted is None or "x" not in wanted:
            return
        position = frames.enu(np.column_stack([wanted[k] for k in "xyz"]).astype(float))
        velocity = frames.enu(np.column_stack([wanted[k] for k in ("vx", "vy", "vz")]).astype(float))
        yaw = frames.yaw_enu(wanted["yaw"].astype(float))
        self.out.put("reference", stream(("rpx", "rpy", "rpz", "rvx", "rvy", "rvz", "ryaw"), self.seconds(wanted["timestamp"]),
                                         np.column_stack([position, velocity, yaw]), "vehicle_local_position_setpoint[0]"))
