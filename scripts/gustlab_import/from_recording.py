"""A recording becomes flight logs: split, put into the vehicle's order, checked, described."""

import numpy as np

from . import airframes
from .checks import check_flight
from .flight import Flight, on_one_clock
from .limits import cannot_tell
from .outcome import Outcome
from .problems import USAGE, Finding, ImportFailure
from .progress import stage
from .segments import END_s, flying_of, split
from .streams import Recording
from .vehicle_file import Vehicle
from .write_log import sidecar_text

PWM_TOP = 65535.0
LEAST_V = 1.0


def import_recording(recording: Recording, name: str, vehicle, options) -> Outcome:
    stage("checking")
    battery(recording)
    if ends_in_the_air(recording):
        recording.findings.append(Finding("gap", "time_s", recording.end_s, recording.end_s, "note", f"the log ends in the air, after "
                                          f"{recording.end_s:.2f} s: it was cut off, or logging stopped in flight"))
    spans, refused = split(recording)
    spans, refused = wanted(spans, options.from_s, options.to_s), refused
    out = Outcome(recording.file, recording.sha256, recording.kind, recording.autopilot, recording.airframe, refused=refused,
                  findings=[f for f in recording.findings if not any(f.from_s <= b and f.to_s >= a for a, b in spans)],
                  topics=recording.topics)
    actuator = fit_to(recording, vehicle) if "u" in recording.streams and spans else "throttle"
    for number, span in enumerate(spans, 1):
        flight = on_one_clock(recording, *span)
        check_flight(flight, actuator)
        origin = {"file": out.name, "sha256": recording.sha256, "log": recording.kind, "autopilot": recording.autopilot,
                  "airframe": recording.airframe, **{f"{key}": value for key, value in recording.facts.items()},
                  **{f"source_{q}": stream.source for q, stream in recording.streams.items()}, "usable": usable(flight)}
        if options.keep_position:
            origin.update(recording.location)
        top = {"vehicle": vehicle.reference if vehicle else "vehicle.toml", "actuator": actuator, "source": "recording",
               "hold": recording.facts.get("hold", "unknown"), "notes": ""}
        out.flights.append((f"{name}_{number}", flight, sidecar_text(flight, top, {}, origin)))
    out.limits = cannot_tell([flight for _, flight, _ in out.flights], recording.settings)
    return out


def ends_in_the_air(recording: Recording) -> bool:
    """Of a flight computer's logs, unless they say that it is disarmed there. What is said of a log's end already says more."""
    last_s = recording.end_s - END_s
    armed = [(0.0, recording.end_s)] if recording.armed is None and recording.autopilot else recording.armed
    if not armed or armed[-1][1] < last_s or recording.no_flight or any(f.from_s >= last_s for f in recording.findings) or "u" not in recording.streams:
        return False
    flying = flying_of(recording)
    return bool(flying) and flying[-1][1] >= last_s


def usable(flight: Flight) -> bool:
    return all(f.severity != "error" for f in flight.findings)


def wanted(spans: list, from_s, to_s) -> list:
    """The flights within --from and --to."""
    low, high = from_s if from_s is not None else -np.inf, to_s if to_s is not None else np.inf
    kept = [(max(a, low), min(b, high)) for a, b in spans if min(b, high) > max(a, low)]
    if spans and not kept:
        when = f"before {high:g} s" if from_s is None else f"after {low:g} s" if to_s is None else f"between {low:g} and {high:g} s"
        raise ImportFailure(f"--from, --to: no flight {when} (flights: "
                            f"{', '.join(f'{a:.1f} to {b:.1f} s' for a, b in spans)})", USAGE)
    return kept


def battery(recording: Recording) -> None:
    """A voltage that no battery has is not used, and said."""
    volts = recording.streams.get("vbat")
    if volts is not None and np.nanmedian(volts.values) < LEAST_V:
        recording.findings.append(Finding("out_of_range", "vbat", volts.time_s[0], volts.time_s[-1], "warning",
                                          f"reads {np.nanmin(volts.values):.1f} to {np.nanmax(volts.values):.1f} V: not used"))
        del recording.streams["vbat"]


def fit_to(recording: Recording, vehicle) -> str:
    """Puts motors into the vehicle's order and unit; the kind of the actuator input."""
    inputs = recording.streams["u"]
    kind = recording.facts.pop("actuator", "throttle")
    if vehicle is None or kind == "collective_thrust":
        return kind
    if vehicle.rotors and len(vehicle.rotors) != inputs.values.shape[1]:
        raise ImportFailure(f"{recording.file}: {inputs.values.shape[1]} motors are logged and the vehicle {vehicle.reference} has "
                            f"{len(vehicle.rotors)} rotors; give the vehicle that flew", USAGE)
    if vehicle.rotors and recording.rotors:
        reorder(recording, vehicle)
    if kind == "throttle" and "throttle" not in vehicle.inputs and "pwm" in vehicle.inputs:
        inputs.values *= PWM_TOP
        inputs.source += f", as {PWM_TOP:g} x throttle for the vehicle's pwm map"
        return "pwm"
    return kind


def reorder(recording: Recording, vehicle: Vehicle) -> None:
    order = airframes.match(recording.rotors, vehicle.rotors)
    if order is None:
        recording.findings.append(Finding(
            "inconsistent", "u", 0.0, recording.end_s, "warning",
            f"the log's rotors ({recording.airframe}, as the autopilot numbers them) do not lie and turn as those of "
            f"{vehicle.reference}: motors are left in the log's order"))
        return
    if order != sorted(order):
        for key in ("u", "rotor"):
            if key in recording.streams:
                recording.streams[key].values = recording.streams[key].values[:, order]
        recording.streams["u"].source += f", the log's motors {', '.join(str(k + 1) for k in order)} in this order"
