"""A flight log as MCAP with JSON messages: a topic for each group of columns, and poses that Foxglove's 3-D panel draws."""

import io
import json

import numpy as np
from mcap.writer import Writer

from .flight_file import FlightFile
from .problems import DATA, Refusal

LAST_S = 1.8e10  # 2^64 ns
_NUMBER = {"type": "number"}
_TIME = {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}}


def _vector(names: str) -> dict:
    return {"type": "object", "properties": {name: _NUMBER for name in names.split()}}


# foxglove.PoseInFrame, as Foxglove describes it
POSE = {"type": "object", "title": "foxglove.PoseInFrame",
        "properties": {"timestamp": _TIME, "frame_id": {"type": "string"},
                       "pose": {"type": "object", "properties": {"position": _vector("x y z"), "orientation": _vector("x y z w")}}}}


def _nanoseconds(time_s: float) -> int:
    return round(1e9 * time_s)


def _pose(time_s: float, position, q) -> dict:
    ns = _nanoseconds(time_s)
    return {"timestamp": {"sec": ns // 10**9, "nsec": ns % 10**9}, "frame_id": "world",
            "pose": {"position": dict(zip("xyz", map(float, position))),
                     "orientation": {"x": float(q[1]), "y": float(q[2]), "z": float(q[3]), "w": float(q[0])}}}


def poses(position, attitude) -> list:
    """(time, message) at every position, with the last attitude before it; level where there is none."""
    if position is None or len(position.columns) < 3:
        return []
    position, attitude = position.complete(), attitude and attitude.complete()
    level = np.array([1.0, 0.0, 0.0, 0.0])
    last = np.searchsorted(attitude.time_s, position.time_s, side="right") - 1 if attitude is not None else None
    q = [level if last is None or last[k] < 0 else attitude.values[last[k]] for k in range(len(position.time_s))]
    return [(time_s, _pose(time_s, place, turn)) for time_s, place, turn in zip(position.time_s, position.values, q)]


def messages(flight: FlightFile) -> tuple:
    """Schemas by topic, and (time, topic, message) in the order of time."""
    schemas, found = {}, []
    groups = {group.name: group for group in flight.groups()}
    for name, group in groups.items():
        properties = {column: {**_NUMBER, "description": f"{group.meaning} [{group.unit}]"} for column in group.columns}
        schemas["/" + name] = (f"gustlab.{name}", {"type": "object", "properties": properties})
        found += [(time_s, "/" + name, {column: float(value) for column, value in zip(group.columns, row) if np.isfinite(value)})
                  for time_s, row in zip(group.time_s, group.values)]
    for topic, position, attitude in (("/pose", "position", "attitude"), ("/reference_pose", "reference_position", None)):
        list_of = poses(groups.get(position), groups.get(attitude))
        if list_of:
            schemas[topic] = ("foxglove.PoseInFrame", POSE)
            found += [(time_s, topic, message) for time_s, message in list_of]
    return schemas, sorted(found, key=lambda item: item[0])


def _check_times(flight: FlightFile) -> None:
    if flight.time_s[0] < 0.0:
        raise Refusal(f"{flight.place(0, 'time_s')}: time_s begins before zero, which MCAP cannot hold; shift it", DATA)
    late = np.flatnonzero(flight.time_s > LAST_S)
    if len(late):
        raise Refusal(f"{flight.place(late[0], 'time_s')}: time_s is {flight.time_s[late[0]]:g} s, and MCAP holds times up to "
                      f"{LAST_S:g} s; shift it, or mend the log", DATA)


def mcap_bytes(flight: FlightFile) -> bytes:
    _check_times(flight)
    schemas, found = messages(flight)
    file = io.BytesIO()
    writer = Writer(file)
    writer.start(profile="", library="gustlab export")
    channels = {}
    for topic, (name, schema) in schemas.items():
        known = writer.register_schema(name=name, encoding="jsonschema", data=json.dumps(schema).encode())
        channels[topic] = writer.register_channel(topic=topic, message_encoding="json", schema_id=known)
    for sequence, (time_s, topic, message) in enumerate(found):
        ns = _nanoseconds(time_s)
        writer.add_message(channel_id=channels[topic], log_time=ns, publish_time=ns, sequence=sequence,
                           data=json.dumps(message, allow_nan=False).encode())
    if flight.sidecar_text:
        # create_time 0: no date in any output
        writer.add_attachment(create_time=0, log_time=_nanoseconds(flight.time_s[0]), name=flight.sidecar_path.name,
                              media_type="application/toml", data=flight.sidecar_text.encode())
    writer.finish()
    return file.getvalue()
