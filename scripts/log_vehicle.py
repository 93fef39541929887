#!/usr/bin/env python3
"""Prints what a PX4 or ArduPilot log says of its vehicle, as JSON: for `gustlab vehicle new --from-log LOG`.

Number of rotors, hubs [m or in units of the arm, x forward, y left, z up], hover throttle, throttle curve and torque ratio, each with
its source.
"""

import project_python  # noqa: F401, I001 (first: it may start this script again in .venv)
import argparse
import json
import math
import sys
from pathlib import Path

import numpy as np
from gustlab_import.kinds import kind_of
from gustlab_import.problems import ImportFailure, printable, understood
from gustlab_import.read_mavlink import read_dataflash
from gustlab_import.read_ulog import load, read_ulog
from gustlab_import.segments import split
from gustlab_import.tables import read_bytes
from gustlab_import.ulog_damage import without_damage

KM_DEFAULT = 0.05       # PX4's default moment ratio CA_ROTORn_KM, which says nothing of a vehicle
MULTICOPTERS = {2: 4, 13: 6, 14: 8, 15: 3}  # MAV_TYPE (MAVLink common.xml): rotors
LEAST_HOVER_S = 5.0


def hubs(parameters):
    """(hubs, source, metres) from the control allocation of PX4 1.13 and newer; None where the log has none"""
    count = int(parameters.get("CA_ROTOR_COUNT", 0))
    if not 3 <= count <= 8:
        return None
    rotors = []
    for i in range(count):
        x, y, z, moment = (float(parameters.get(f"CA_ROTOR{i}_{key}", 0.0)) for key in ("PX", "PY", "PZ", "KM"))
        rotors.append({"position_B_m": [x, -y, -z], "counter_clockwise": moment > 0.0})
    arms = [math.hypot(*rotor["position_B_m"][:2]) for rotor in rotors]
    # 1 is PX4's default: it needs the proportions alone
    metres = 0.02 < min(arms) and max(arms) < 1.2 and not all(abs(abs(c) - 1.0) < 1e-6 for r in rotors for c in r["position_B_m"][:2])
    return rotors, "the log's parameters CA_ROTOR0_PX to KM", metres


def rotor_count(parameters, found):
    """{"value", "source"}; None where the log does not say"""
    if found:
        return {"value": len(found[0]), "source": "CA_ROTOR_COUNT"}
    if "MAV_TYPE" not in parameters:
        return None
    return {"value": MULTICOPTERS[int(parameters["MAV_TYPE"])], "source": f"MAV_TYPE {int(parameters['MAV_TYPE'])}"}


def hover(log):
    """median of PX4's estimate of the hover throttle while it was valid, with its spread; None where there is no estimate"""
    for data in log.data_list:
        if data.name != "hover_thrust_estimate":
            continue
        valid = np.asarray(data.data.get("valid", np.ones(len(data.data["timestamp"])))) > 0
        values, times = data.data["hover_thrust"][valid], data.data["timestamp"][valid] * 1e-6
        if len(times) < 10 or times[-1] - times[0] < LEAST_HOVER_S:
            return None
        return {"value": round(float(np.median(values)), 4),
                "source": f"the log's hover_thrust_estimate, median of {times[-1] - times[0]:.0f} s, standard deviation {np.std(values):.2g}"}
    return None


def hover_of_flights(recording):
    """median command over the times in the air, where these are long enough; None otherwise"""
    inputs, flights = recording.streams.get("u"), split(recording)[0]
    seconds = sum(b - a for a, b in flights)
    if inputs is None or seconds < LEAST_HOVER_S:
        return None
    means = np.concatenate([np.nanmean(inputs.between(*span).values, axis=1) for span in flights])
    return {"value": round(float(np.nanmedian(means)), 4), "source": f"median of the motors' commands over {seconds:.0f} s in the air"}


def of_ardupilot(path):
    recording = read_dataflash(path)
    if recording.no_flight:
        raise ImportFailure(f"{path}: not of a multicopter ({recording.no_flight})")
    source = recording.streams["u"].source if "u" in recording.streams else ""
    places = [{"position_B_m": [rotor.x, rotor.y, 0.0], "counter_clockwise": rotor.direction > 0} for rotor in recording.rotors]
    count = {"value": len(places), "source": "FRAME_CLASS"} if places else None
    return {"rotors": count, "hubs": places or None, "hubs_source": f"the log's FRAME_CLASS and FRAME_TYPE ({recording.airframe})", "metres": False,
            "hover": hover_of_flights(recording), "torque_ratio_m": None,
            "throttle_curve": {"value": 0.0, "source": f"import reads {source}"} if "as shares of thrust" in source else None}


def curve(parameters):
    """f of thrust ~ f u^2 + (1 - f) u for u = actuator_motors; None where the log does not say"""
    factor = float(parameters.get("THR_MDL_FAC", 0.0))
    if factor <= 0.0:
        return None
    return {"value": 0.0, "source": f"the log's THR_MDL_FAC is {factor:.3g}: PX4 takes that curve out after actuator_motors, which are shares of thrust"}


def torque_ratio(parameters):
    ratios = [abs(float(parameters.get(f"CA_ROTOR{i}_KM", KM_DEFAULT))) for i in range(int(parameters.get("CA_ROTOR_COUNT", 0)))]
    if not ratios or any(abs(ratio - KM_DEFAULT) < 1e-4 for ratio in ratios):
        return None
    return {"value": round(sum(ratios) / len(ratios), 6), "source": "the log's parameters CA_ROTORn_KM"}


def of_px4(path):
    log, _ = load(str(path), without_damage(read_bytes(path))[0], ["hover_thrust_estimate"])
    parameters = log.initial_parameters
    kind = int(parameters.get("MAV_TYPE", 2))
    if kind not in MULTICOPTERS or int(parameters.get("CA_AIRFRAME", 0)) != 0:
        raise ImportFailure(f"{path}: not of a multicopter (MAV_TYPE is {kind}, CA_AIRFRAME {int(parameters.get('CA_AIRFRAME', 0))})")
    found = hubs(parameters)
    return {"rotors": rotor_count(parameters, found), "hubs": found and found[0], "hubs_source": found and found[1], "metres": bool(found and found[2]),
            "hover": hover(log) or hover_of_flights(read_ulog(path)), "throttle_curve": curve(parameters), "torque_ratio_m": torque_ratio(parameters)}


def said_of(path):
    """What a log says of its vehicle; None for kinds of logs that do not."""
    of_kind = {"dataflash": of_ardupilot, "ulog": of_px4}.get(kind_of(path))
    if of_kind is None:
        return None
    with understood(path):
        return of_kind(path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("log", metavar="LOG", type=Path)
    path = parser.parse_args().log
    try:
        said = said_of(path)
        if said is None:
            sys.exit(f"{printable(str(path))}: a log of PX4 (.ulg) or ArduPilot (.bin) is needed; others do not say what vehicle flew")
        print(json.dumps(said))
    except (ImportFailure, OSError) as failure:
        sys.exit(printable(str(failure)))


if __name__ == "__main__":
    main()
