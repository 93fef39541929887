"""What a diagnosis cannot tell from a flight, and which setting of the logger would change it."""

import numpy as np

from .flight import Flight

MOTOR_Hz, TORQUE_Hz = 100.0, 40.0   # motors for lags of some 10 ms; motors and rates for torques at 1 to 8 Hz
FROZEN_V = 0.05


def cannot_tell(flights: list, settings: dict) -> list:
    """[{"effect", "why", "setting"}] of what none of the flights can tell."""
    if not flights:
        return []
    found = [_of(flight) for flight in flights]
    everywhere = [effect for effect in found[0] if all(effect in one for one in found)]
    return [{"effect": effect, "why": found[0][effect][0],
             **({"setting": settings[found[0][effect][1]]} if found[0][effect][1] in settings else {})} for effect in everywhere]


def can_tell(flight: Flight) -> list:
    """What the flight's columns are enough for, in words."""
    out = []
    if rate(flight, "px", "py", "pz") or rate(flight, "ax", "ay", "az"):
        out.append("forces (weight, thrust, drag, wind)" if rate(flight, "px", "py", "pz") else "vertical force (weight, thrust)")
    inputs = rate(flight, *flight.actuator_names)
    if len(flight.actuator_names) >= 3 and min(inputs, rate(flight, "wx", "wy", "wz")) > 0:
        out.append("torques (centre of mass, single rotors, inertia)" if inputs >= MOTOR_Hz else
                   f"torques only where the motors' commands are smooth: at {inputs:.0f} Hz what a faster loop did between two of them is not in the log")
    return out


def rate(flight: Flight, *columns: str) -> float:
    """Samples per second of a group; 0 where it is not there."""
    if any(column not in flight.columns for column in columns):
        return 0.0
    time_s, _ = flight.series(*columns)
    return 1.0 / float(np.median(np.diff(time_s))) if len(time_s) > 2 else 0.0


def _of(flight: Flight) -> dict:
    """effect -> (why, which setting)"""
    out, collective = {}, len(flight.actuator_names) < 3
    inputs, rates = rate(flight, *flight.actuator_names), rate(flight, "wx", "wy", "wz")
    if collective:
        for effect in ("inertia", "center_of_mass", "rotor_loss", "yaw_torque_ratio", "motor_lag"):
            out[effect] = ("only the total thrust is in the log, not the single motors", "rate")
    elif inputs < MOTOR_Hz:
        # one lag or delay of more than a sample shows, but not which of the two it is
        shows = f"motors are logged at {inputs:.0f} Hz, which shows no lag below {1e3 / inputs:.0f} ms, nor a lag from a delay" if inputs else \
            "the motors have two samples at most"
        for effect in ("motor_lag", "actuation_delay"):
            out[effect] = (shows, "rate")
    if not collective and min(inputs, rates) < TORQUE_Hz:
        slow = f"motors are logged at {inputs:.0f} Hz" if inputs <= rates else \
            f"body rates are logged at {rates:.0f} Hz" if rates else "there is no body rate"
        for effect in ("inertia", "rotor_inertia"):
            out[effect] = (slow, "rate")
    if rate(flight, "px", "py", "pz") == 0.0:
        for effect in ("rotor_drag", "quadratic_drag", "steady_wind", "ground_effect"):
            out[effect] = ("there is no position or velocity", "pose")
    if "vbat" not in flight.columns:
        out["battery_sag"] = ("there is no usable battery voltage", "battery")
    elif np.nanmax(flight.columns["vbat"]) - np.nanmin(flight.columns["vbat"]) < FROZEN_V:
        out["battery_sag"] = ("the battery voltage never changes: what falls with it can only be told by time", "battery")
    return out
