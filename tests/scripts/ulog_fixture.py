"""Writes PX4 ULog files byte by byte (docs.px4.io, ULog File Format): pyulog reads them, and has no writer for new ones."""

import struct

import numpy as np

TYPES = {"uint64_t": "Q", "float": "f", "uint8_t": "B", "int8_t": "b", "bool": "?", "uint32_t": "I", "int32_t": "i"}


class ULogFile:
    def __init__(self, start_us: int = 1_000_000):
        self.start_us, self.formats, self.head, self.data, self.next_id = start_us, {}, b"", [], 0

    @staticmethod
    def message(kind: bytes, body: bytes) -> bytes:
        return struct.pack("<Hc", len(body), kind) + body

    def info(self, key: str, value: str) -> None:
        name = f"char[{len(value)}] {key}".encode()
        self.head += self.message(b"I", struct.pack("<B", len(name)) + name + value.encode())

    def parameter(self, key: str, value) -> None:
        kind, packed = ("int32_t", struct.pack("<i", value)) if isinstance(value, int) else ("float", struct.pack("<f", value))
        name = f"{kind} {key}".encode()
        self.head += self.message(b"P", struct.pack("<B", len(name)) + name + packed)

    def topic(self, name: str, time_s, fields: dict, instance: int = 0) -> None:
        """fields: "type name" or "type[n] name" -> (n_samples,) or (n_samples, n); `timestamp` is added."""
        layout, columns, text = "<Q", [], "uint64_t timestamp;"
        for key, values in fields.items():
            kind, field = key.split(" ")
            base, count = (kind.split("[")[0], int(kind.split("[")[1][:-1])) if "[" in kind else (kind, 1)
            layout += f"{count}{TYPES[base]}" if count > 1 else TYPES[base]
            text += f"{kind} {field};"
            columns.append((np.asarray(values).reshape(len(time_s), count), base))
        if name not in self.formats:
            self.formats[name] = text
            self.head += self.message(b"F", f"{name}:{text}".encode())
        number, self.next_id = self.next_id, self.next_id + 1
        self.data.append((-1, self.message(b"A", struct.pack("<BH", instance, number) + name.encode())))
        for k, t in enumerate(time_s):
            row = [float(v) if base == "float" else int(v) for values, base in columns for v in values[k]]
            stamp = self.start_us + round(1e6 * t)
            self.data.append((stamp, self.message(b"D", struct.pack("<H", number) + struct.pack(layout, stamp, *row))))

    def esc_status(self, time_s, rpm, functions=None) -> None:
        """Speed controllers' reports, a nested type: rpm (n, 8); functions: what each drives, 101 for motor 1, or None as before 1.13."""
        inner = "uint64_t timestamp;int32_t esc_rpm;" + ("uint8_t actuator_function;" if functions is not None else "")
        for name, text in (("esc_report", inner), ("esc_status", "uint64_t timestamp;uint8_t esc_count;esc_report[8] esc;")):
            self.head += self.message(b"F", f"{name}:{text}".encode())
        number, self.next_id = self.next_id, self.next_id + 1
        self.data.append((-1, self.message(b"A", struct.pack("<BH", 0, number) + b"esc_status")))
        for t, row in zip(time_s, rpm):
            stamp = self.start_us + round(1e6 * t)
            body = struct.pack("<HQB", number, stamp, 4)
            for k in range(8):
                body += struct.pack("<Qi", stamp, int(row[k])) + (struct.pack("<B", functions[k]) if functions is not None else b"")
            self.data.append((stamp, self.message(b"D", body)))

    def bytes(self) -> bytes:
        out = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", self.start_us) + self.message(b"B", bytes(40)) + self.head
        return out + b"".join(part for _, part in sorted(self.data, key=lambda item: item[0]))


def stamps(log: ULogFile, time_s) -> np.ndarray:
    return np.array([log.start_us + round(1e6 * t) for t in time_s])


# PX4's numbering of the X: place (forward, right), and yaw torque
MIX = np.array([[-0.7071, 0.7071, 1.0, 1.0], [0.7071, -0.7071, 1.0, 1.0], [0.7071, 0.7071, -1.0, 1.0], [-0.7071, -0.7071, -1.0, 1.0]])


def px4_flight(flight: dict, mav_type: int = 2, armed=(2.0, 18.0), flying=(3.0, 17.0), instance: int = 0, rate_hz: int = 250,
               reset_s: float = None,
               motors_logged: bool = True) -> ULogFile:
    """A flight as PX4's default profile logs it.

    flight: (n, ...) in z-up world and FLU body at rate_hz: time_s, p, v, q (scalar first), w, a, torque (n, 3; FRD, normalised),
    thrust (n,) 0..1. Position 10 Hz, attitude 20 Hz, set points 50 Hz, motors 10 Hz, battery 5 Hz, IMU 200 Hz or more.
    """
    log, t = ULogFile(), flight["time_s"]
    log.info("sys_name", "PX4")
    for key, value in (("MAV_TYPE", mav_type), ("SYS_AUTOSTART", 4001), ("SDLOG_PROFILE", 1), ("CA_ROTOR_COUNT", 4)):
        log.parameter(key, value)
    for k, (x, y, yaw) in enumerate(((1.0, 1.0, 0.05), (-1.0, -1.0, 0.05), (1.0, -1.0, -0.05), (-1.0, 1.0, -0.05))):
        for key, value in (("PX", x), ("PY", y), ("KM", yaw)):
            log.parameter(f"CA_ROTOR{k}_{key}", value)

    def ned(v):
        return np.column_stack([v[:, 1], v[:, 0], -v[:, 2]])

    def frd(v):
        return v * [1.0, -1.0, -1.0]

    slow, pose, half, fifth, fast = (slice(0, None, max(1, rate_hz // hz)) for hz in (10, 20, 50, 5, 200))
    q = flight["q"]
    # ENU/FLU to NED/FRD: the same two half turns back
    h = np.sqrt(0.5)
    first = h * np.column_stack([-(q[:, 1] + q[:, 2]), q[:, 0] + q[:, 3], q[:, 0] - q[:, 3], q[:, 2] - q[:, 1]])
    turned = np.column_stack([-first[:, 1], first[:, 0], first[:, 3], -first[:, 2]])
    log.topic("sensor_combined", t[fast], {"float[3] gyro_rad": frd(flight["w"])[fast],
                                           "float[3] accelerometer_m_s2": frd(flight["a"])[fast]})
    log.topic("vehicle_attitude", t[pose], {"float[4] q": turned[pose]})
    p, v = ned(flight["p"])[slow], ned(flight["v"])[slow]
    p[(t[slow] < flying[0]) | (t[slow] > flying[1]), 2] = 0.0   # it stands there
    counted = np.zeros(len(p)) if reset_s is None else (t[slow] >= reset_s).astype(float)
    log.topic("vehicle_local_position", t[slow], {"uint8_t z_reset_counter": counted, "float delta_z": 0.7 * counted, **{f"float {name}": p[:, k] for k, name in enumerate("xyz")},
                                                  **{f"float v{name}": v[:, k] for k, name in enumerate("xyz")}})
    asked = np.column_stack([flight["torque"], flight["thrust"]])
    motors = asked @ MIX.T
    if instance and motors_logged:
        log.topic("actuator_motors", t[slow], {"uint64_t timestamp_sample": stamps(log, t[slow]),
                                               "float[12] control": np.full((len(t[slow]), 12), np.nan)})
    control = np.full((len(t[slow]), 12), np.nan)
    control[:, :4] = motors[slow]
    if motors_logged:
        log.topic("actuator_motors", t[slow] + 2e-4, {"uint64_t timestamp_sample": stamps(log, t[slow]), "float[12] control": control},
                  instance)
    thrust = np.column_stack([np.zeros((len(t[half]), 2)), -flight["thrust"][half]])
    for name, values in (("vehicle_torque_setpoint", flight["torque"][half]), ("vehicle_thrust_setpoint", thrust)) * motors_logged:
        log.topic(name, t[half] + 1e-4, {"uint64_t timestamp_sample": stamps(log, t[half]), "float[3] xyz": values})
    log.topic("battery_status", t[fifth], {"float voltage_v": 16.0 - 0.02 * t[fifth] + 0.01 * np.sin(t[fifth])})
    every = np.arange(0.0, t[-1], 0.5)
    log.topic("actuator_armed", every, {"bool armed": (every >= armed[0]) & (every < armed[1])})
    log.topic("vehicle_land_detected", every, {"bool landed": ~((every >= flying[0]) & (every < flying[1]))})
    log.topic("vehicle_status", every, {"uint8_t arming_state": np.where((every >= armed[0]) & (every < armed[1]), 2, 1),
                                        "uint8_t vehicle_type": np.ones(len(every), int)})
    return log
