"""A flight log as PX4's ulog2csv would write it: one table per topic, µs, world north-east-down, body forward-right-down.

The flight log's y axis is taken for north, which is so when its world is east-north-up.
"""

import io

import numpy as np
from gustlab_import.frames import attitude_enu, attitude_flu, enu, flu, yaw_enu

from .flight_file import FlightFile

# frames.py's turns are half turns: they lead back, too
_ned, _frd = enu, flu


def _attitude(q: np.ndarray) -> np.ndarray:
    return attitude_enu(attitude_flu(q))


def _rpm(speed_radps: np.ndarray) -> np.ndarray:
    return speed_radps * 60.0 / (2.0 * np.pi)


def _same(values: np.ndarray) -> np.ndarray:
    return values


# group of the flight log -> topic, columns, what turns the values
TOPICS = {
    "position": ("vehicle_local_position", "x y z", _ned),
    "velocity": ("vehicle_local_position", "vx vy vz", _ned),
    "attitude": ("vehicle_attitude", "q[0] q[1] q[2] q[3]", _attitude),
    "body_rate": ("vehicle_angular_velocity", "xyz[0] xyz[1] xyz[2]", _frd),
    "specific_force": ("vehicle_acceleration", "xyz[0] xyz[1] xyz[2]", _frd),
    "reference_position": ("trajectory_setpoint", "position[0] position[1] position[2]", _ned),
    "reference_velocity": ("trajectory_setpoint", "velocity[0] velocity[1] velocity[2]", _ned),
    "reference_acceleration": ("trajectory_setpoint", "acceleration[0] acceleration[1] acceleration[2]", _ned),
    "reference_yaw": ("trajectory_setpoint", "yaw", yaw_enu),
    "battery": ("battery_status", "voltage_v", _same),
    "rotor_speed": ("esc_status", "esc[{}].esc_rpm", _rpm),
}


def _place(flight: FlightFile, group) -> tuple:
    """topic, column names and conversion of a group; what PX4 has no topic for keeps its names and frames"""
    if group.name == "actuator_input":
        # PX4's own range is that of a throttle
        throttle = flight.input_kind == "throttle"
        topic, names = ("actuator_motors", "control[{}]") if throttle else ("actuator_outputs", "output[{}]")
        return topic, [names.format(i) for i in range(len(group.columns))], _same
    if group.name not in TOPICS:
        return "gustlab", list(group.columns), _same
    topic, names, turned = TOPICS[group.name]
    if "{}" in names:
        return topic, [names.format(i) for i in range(len(group.columns))], turned
    whole = names.split()
    # a vector of which only a part was recorded cannot be turned
    return (topic, whole, turned) if len(whole) == len(group.columns) else ("gustlab", list(group.columns), _same)


def topics(flight: FlightFile) -> dict:
    """topic -> {column: (rows of the topic,)}, `timestamp` first."""
    parts = {}
    for group in flight.groups():
        topic, names, turned = _place(flight, group)
        parts.setdefault(topic, []).append((group.time_s, names, turned(group.values)))
    tables = {}
    for topic, pieces in parts.items():
        time_s = np.unique(np.concatenate([piece[0] for piece in pieces]))
        table = {"timestamp": np.round(1e6 * time_s)}
        for own_s, names, values in pieces:
            for name, column in zip(names, values.T):
                table[name] = np.full(len(time_s), np.nan)
                table[name][np.searchsorted(time_s, own_s)] = column
        tables[topic] = table
    return tables


def topic_text(table: dict) -> str:
    text = io.StringIO()
    text.write(",".join(table) + "\n")
    names = list(table)[1:]
    for k, timestamp in enumerate(table["timestamp"]):
        cells = ("" if np.isnan(table[name][k]) else f"{table[name][k]:.9g}" for name in names)
        text.write(f"{timestamp:.0f}," + ",".join(cells) + "\n")
    return text.getvalue()
