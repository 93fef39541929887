"""ROS 1 and 2 bags (rosbags) -> Recording by message type, or a table for a column map."""

import hashlib
from pathlib import Path

import numpy as np

from .problems import ImportFailure, some
from .progress import stage
from .rotations import rotate
from .streams import ATTITUDE, BATTERY, FORCE, POSITION, RATE, VELOCITY, Recording, rate_of, stream
from .tables import Table, read_bytes

POSES = {"geometry_msgs/msg/PoseStamped": "pose", "geometry_msgs/msg/PoseWithCovarianceStamped": "pose.pose",
         "nav_msgs/msg/Odometry": "pose.pose", "geometry_msgs/msg/TransformStamped": "transform"}
# message -> (field, what it holds)
MOTORS = {"mav_msgs/msg/Actuators": ("angular_velocities", "rotor_speed"),
          "px4_msgs/msg/ActuatorMotors": ("control", "throttle"), "mavros_msgs/msg/RCOut": ("channels", "pulse")}
REPAIR = {".bag": "rosbag reindex", ".mcap": "mcap recover", ".db3": "sqlite3's .recover"}
SETTINGS = {"rate": "record the motor commands (mav_msgs/Actuators, px4_msgs/ActuatorMotors or mavros_msgs/RCOut) at the "
                    "controller's rate",
            "battery": "record sensor_msgs/BatteryState", "pose": "record nav_msgs/Odometry or geometry_msgs/PoseStamped"}


def read_ros(path: Path) -> Recording:
    bag = _Bag(path)
    out = Recording(str(path), bag.sha256, "ros-bag", bag.kind, "unknown", end_s=bag.end_s, settings=SETTINGS)
    out.topics = [(f"{name} ({bag.types[name].replace('/msg/', '/')})", len(times), rate_of(times)) for name, (times, _) in bag.topics.items()]
    wanted = {}
    for name in sorted(bag.topics, key=lambda n: -len(bag.topics[n][0])):
        wanted.setdefault(bag.types[name], name)   # of several topics of a type the fastest
    if name := wanted.get("sensor_msgs/msg/Imu"):
        out.put("body_rate", bag.stream(name, RATE, "angular_velocity", "xyz"))
        out.put("specific_force", bag.stream(name, FORCE, "linear_acceleration", "xyz"))
        out.put("attitude", bag.stream(name, ATTITUDE, "orientation", "wxyz"))
    for kind, inner in POSES.items():
        if name := wanted.get(kind):
            place, turn = ("translation", "rotation") if inner == "transform" else ("position", "orientation")
            if "setpoint" in name or "reference" in name or "command" in name:
                continue
            out.put("position", bag.stream(name, POSITION, f"{inner}.{place}", "xyz"))
            out.put("attitude", bag.stream(name, ATTITUDE, f"{inner}.{turn}", "wxyz"))
            if kind == "nav_msgs/msg/Odometry":
                velocity = bag.stream(name, VELOCITY, "twist.twist.linear", "xyz")
                velocity.values = rotate(out.streams["attitude"].values, velocity.values)  # a twist is in the child's frame
                out.put("velocity", velocity)
            break
    if name := wanted.get("sensor_msgs/msg/BatteryState"):
        out.put("vbat", bag.stream(name, BATTERY, "", ["voltage"]))
    _motors(out, bag, wanted)
    return out


def _motors(out: Recording, bag: "_Bag", wanted: dict) -> None:
    for kind, (field, unit) in MOTORS.items():
        if name := wanted.get(kind):
            times, messages = bag.topics[name]
            values = np.array([list(getattr(m, field))[:8] for m in messages], dtype=float)
            values = values[:, np.isfinite(values).any(axis=0) & (np.ptp(np.nan_to_num(values), axis=0) > 0)]
            if values.shape[1] < 3:
                continue
            if unit == "pulse":
                values = np.clip((values - 1000.0) / 1000.0, 0.0, 1.0)
            out.facts["actuator"] = "rotor_speed" if unit == "rotor_speed" else "throttle"
            out.put("u", stream([f"u{k + 1}" for k in range(values.shape[1])], times, values, name))
            return
    thrust = [n for n in bag.topics if any(word in n.lower() for word in ("thrust", "throttle"))]
    if thrust:
        out.facts["no_motors"] = (f"{', '.join(thrust)} is a collective command without a known unit: give a column map with "
                                  '[actuator] kind = "collective_thrust" and its scale in N')


def table_of(path: Path, names: set) -> Table:
    """The columns `/topic.field` that a map names, on all their times together, empty elsewhere; `time` is the time [s]."""
    bag = _Bag(path)
    series = {}
    for name in sorted(names):
        topic = max((t for t in bag.topics if name.startswith(t + ".")), key=len, default=None)
        if topic is None:
            continue
        series[name] = bag.column(topic, name[len(topic) + 1:])
    if not series:
        raise ImportFailure(f"{path}: none of the map's columns is in the bag (topics: {some(bag.topics)})")
    time_s = np.unique(np.concatenate([times for times, _ in series.values()]))
    columns = {"time": time_s}
    for name, (times, values) in series.items():
        columns[name] = np.full(len(time_s), np.nan)
        columns[name][np.searchsorted(time_s, times)] = values
    return Table(str(path), bag.sha256, columns, np.arange(1, len(time_s) + 1))


class _Bag:
    """All messages of the topics that can be deserialised, on their header's clock (where it runs) from the bag's start on."""

    def __init__(self, path: Path):
        from rosbags.highlevel import AnyReader  # a second to import
        self.name, self.sha256 = str(path), hashlib.sha256(read_bytes(path)).hexdigest()
        self.topics, self.types, self.unknown = {}, {}, []
        try:
            with _opened(AnyReader, path) as reader:
                self.kind = "ROS 2" if reader.is2 else "ROS 1"
                self._read(reader)
                self.end_s = (reader.end_time - reader.start_time) * 1e-9
        except ImportFailure:
            raise
        except Exception as error:  # rosbags raises whatever a damaged byte leads to
            if "Profile is not ros2" in str(error):
                raise ImportFailure(f"{path}: an MCAP file without ROS 2 messages; give a bag, or the log that it was made of") from error
            why = f"{type(error).__name__}: " if isinstance(error, (AttributeError, KeyError)) else ""
            raise ImportFailure(f"{path}: the bag cannot be read ({why}{error}): cut off, or never closed? fetch it again, or mend it "
                                f"with {REPAIR.get(path.suffix.lower(), REPAIR['.bag'])}") from error
        if not self.topics:
            raise ImportFailure(f"{path}: no message of a known type is in the bag"
                                + (f" (unknown: {some(set(self.unknown))})" if self.unknown else ""))

    def _read(self, reader) -> None:
        start = reader.start_time
        raw, read = {}, 0
        stage("reading", lambda: read / max(1, reader.message_count))
        for connection, received, data in reader.messages():
            read += 1
            try:
                message = reader.deserialize(data, connection.msgtype)
            except Exception:  # a type whose definition the bag does not hold
                self.unknown.append(connection.msgtype)
                continue
            self.types[connection.topic] = connection.msgtype
            stamp = getattr(getattr(message, "header", None), "stamp", None)
            sent = stamp.sec * 10**9 + stamp.nanosec if stamp is not None else 0
            raw.setdefault(connection.topic, []).append((received - start, sent - start if sent else None, message))
        for topic, rows in raw.items():
            own = all(sent is not None and abs(sent - received) < 10**10 for received, sent, _ in rows)
            times = np.array([(sent if own else received) * 1e-9 for received, sent, _ in rows])
            self.topics[topic] = (times, [message for _, _, message in rows])

    def column(self, topic: str, field: str) -> tuple:
        """(time_s, values) of one number of every message; `a.b` and `a[0]` reach into it."""
        times, messages = self.topics[topic]
        try:
            values = np.array([float(_reach(message, field)) for message in messages])
        except (AttributeError, IndexError, TypeError, ValueError) as error:
            raise ImportFailure(f"{self.name}: topic {topic} has no number `{field}` ({error})") from error
        found = stream(("x",), times, values, topic)
        return found.time_s, found.values[:, 0]

    def stream(self, topic: str, columns, base: str, fields):
        times, messages = self.topics[topic]
        values = [[float(_reach(message, f"{base}.{field}" if base else field)) for field in fields] for message in messages]
        return stream(columns, times, values, topic)


def _opened(reader, path: Path):
    """A db3 or mcap is opened by itself; a ROS 1 bag as it is; types that it does not define as of ROS 2 Humble."""
    from rosbags.typesys import Stores, get_typestore
    return reader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE))


def _reach(message, field: str):
    value = message
    for part in field.replace("[", ".").replace("]", "").split("."):
        value = value[int(part)] if part.isdigit() else getattr(value, part)
    return value
