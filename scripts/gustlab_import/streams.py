"""What a reader hands on: streams, each on its own clock, and what is known of the vehicle that wrote them."""

from dataclasses import dataclass, field

import numpy as np

POSITION, VELOCITY, ATTITUDE = ("px", "py", "pz"), ("vx", "vy", "vz"), ("qw", "qx", "qy", "qz")
RATE, FORCE, BATTERY = ("wx", "wy", "wz"), ("ax", "ay", "az"), ("vbat",)
# names that import.json gives the quantities -> columns of the flight log (u and rotor have as many as there are rotors)
QUANTITIES = {"position": POSITION, "velocity": VELOCITY, "attitude": ATTITUDE, "body_rate": RATE, "specific_force": FORCE,
              "u": ("u",), "rotor": ("rotor",), "vbat": BATTERY}


@dataclass
class Stream:
    """Samples of one quantity.

    columns  flight log columns, in order
    time_s   (n,) [s], strictly increasing, on the log's own clock from its start on
    values   (n, len(columns)), SI units, world z up, body x forward y left z up
    source   what it was read from, for people
    """

    columns: tuple
    time_s: np.ndarray
    values: np.ndarray
    source: str

    def rate_hz(self) -> float:
        """Samples per second by the median interval, so that gaps do not count; 0 of fewer than two samples."""
        return 1.0 / float(np.median(np.diff(self.time_s))) if len(self.time_s) > 1 else 0.0

    def between(self, from_s: float, to_s: float) -> "Stream":
        inside = (self.time_s >= from_s) & (self.time_s <= to_s)
        return Stream(self.columns, self.time_s[inside], self.values[inside], self.source)


def rate_of(time_s: np.ndarray) -> float:
    """Samples per second of a topic: by the median interval, and not more than come in a usual second that has any, because some come in bursts."""
    at = np.unique(time_s)
    step = float(np.median(np.diff(at))) if len(at) > 1 else 0.0
    return min(1.0 / step, float(np.median(np.unique(np.floor(at), return_counts=True)[1]))) if step > 0.0 else 0.0


def stream(columns, time_s, values, source: str):
    """A stream of the rows that have a sample and a later time than the row before; None when there are none."""
    values = np.asarray(values, dtype=float).reshape(len(time_s), len(columns))
    time_s = np.round(np.asarray(time_s, dtype=float), 6)
    keep = np.isfinite(time_s) & np.isfinite(values).any(axis=1)
    time_s, values = time_s[keep], values[keep]
    later = np.concatenate([[True], time_s[1:] > np.maximum.accumulate(time_s)[:-1]]) if len(time_s) else keep[keep]
    return Stream(tuple(columns), time_s[later], values[later], source) if later.any() else None


@dataclass
class Rotor:
    """Place of a rotor in the body frame (x forward, y left) [m, or any common unit] and +1 where it turns ccw from above."""

    x: float
    y: float
    direction: int


@dataclass
class Recording:
    """One log file, read.

    kind, autopilot, airframe  as import.json has them
    streams    name of the quantity (or "reference") -> Stream
    end_s      last time of the log [s]; its first is 0
    armed      [(from_s, to_s)], or None when the log does not say
    flying     [(from_s, to_s)] by the vehicle's own judgement, or None
    no_flight  reason why nothing in this log can be a multirotor's flight, or ""
    supply     Stream of the voltage that feeds the board [V], or None
    breaks     [(time_s, why)] where the estimator was reset
    topics     [(name, samples, Hz)]
    rotors     [Rotor] in the order of u1...uN, or [] when unknown
    settings   cause -> which setting of the logger would change it
    facts      what the sidecar's [origin] keeps (parameters, the chosen instances)
    """

    file: str
    sha256: str
    kind: str
    autopilot: str = ""
    airframe: str = "unknown"
    streams: dict = field(default_factory=dict)
    end_s: float = 0.0
    armed: list = None
    flying: list = None
    no_flight: str = ""
    supply: Stream = None
    breaks: list = field(default_factory=list)
    findings: list = field(default_factory=list)
    topics: list = field(default_factory=list)
    rotors: list = field(default_factory=list)
    settings: dict = field(default_factory=dict)
    facts: dict = field(default_factory=dict)
    location: dict = field(default_factory=dict)

    def __post_init__(self):
        # as the times of the streams are
        self.end_s = round(self.end_s, 6)

    def put(self, name: str, new) -> None:
        """Keeps a stream that has samples."""
        if new is not None:
            self.streams[name] = new


def spans(time_s: np.ndarray, on: np.ndarray, end_s: float) -> list:
    """[(from_s, to_s)] in which a logged state holds; each value holds until the next one, the last until end_s."""
    out, began = [], None
    for k, state in enumerate(on):
        if state and began is None:
            began = float(time_s[k])
        elif not state and began is not None:
            out.append((began, float(time_s[k])))
            began = None
    return out + ([(began, end_s)] if began is not None and end_s > began else [])
