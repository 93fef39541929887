"""Crazyflie uSD log -> Recording, by the names of the firmware's log variables; other names need a column map."""

from pathlib import Path

import numpy as np

from .problems import ImportFailure
from .streams import ATTITUDE, BATTERY, FORCE, POSITION, RATE, VELOCITY, Recording, Rotor, stream
from .usd_log import TIME_COLUMN, read_usd

EVENT = "fixedFrequency"
STANDARD_GRAVITY = 9.80665
# quantity -> (columns, variables, factor to SI); of alternatives the first that is there (bitcraze firmware, log groups)
NAMES = (("position", POSITION, "stateEstimate.x stateEstimate.y stateEstimate.z", 1.0),
         ("velocity", VELOCITY, "stateEstimate.vx stateEstimate.vy stateEstimate.vz", 1.0),
         ("attitude", ATTITUDE, "stateEstimate.qw stateEstimate.qx stateEstimate.qy stateEstimate.qz", 1.0),
         ("body_rate", RATE, "gyro.x gyro.y gyro.z", np.pi / 180.0),
         ("specific_force", FORCE, "acc.x acc.y acc.z", STANDARD_GRAVITY),
         ("u", ("u1", "u2", "u3", "u4"), "motor.m1 motor.m2 motor.m3 motor.m4", 1.0),
         ("u", ("u1", "u2", "u3", "u4"), "pwm.m1_pwm pwm.m2_pwm pwm.m3_pwm pwm.m4_pwm", 1.0),
         ("rotor", ("rotor1", "rotor2", "rotor3", "rotor4"), "rpm.m1 rpm.m2 rpm.m3 rpm.m4", 2.0 * np.pi / 60.0),
         ("vbat", BATTERY, "pm.vbatMV", 1e-3), ("vbat", BATTERY, "pm.vbat", 1.0))
# front right, back right, back left, front left
ROTORS = [Rotor(1.0, -1.0, 1), Rotor(-1.0, -1.0, -1), Rotor(-1.0, 1.0, 1), Rotor(1.0, 1.0, -1)]
SETTINGS = {"rate": "a higher logging frequency in config.txt of the uSD card", "battery": "log pm.vbatMV",
            "pose": "log stateEstimate.x, y, z, vx, vy, vz, qw, qx, qy, qz"}


def read_usd_by_names(path: Path) -> Recording:
    table = read_usd(path, EVENT)
    time_s = table.columns[TIME_COLUMN] - table.columns[TIME_COLUMN][0]
    out = Recording(table.file, table.sha256, "crazyflie-usd", "Crazyflie", "quadrotor x", end_s=float(np.nanmax(time_s)),
                    settings=SETTINGS, rotors=ROTORS, findings=list(table.remarks))
    out.facts["actuator"] = "pwm"
    out.topics = [(name, len(time_s), 1.0 / float(np.median(np.diff(time_s)))) for name in table.columns if name != TIME_COLUMN]
    for quantity, columns, names, factor in NAMES:
        if quantity not in out.streams and all(name in table.columns for name in names.split()):
            values = factor * np.column_stack([table.columns[name] for name in names.split()])
            out.put(quantity, stream(columns, time_s, values, names.split()[0]))
    if not out.streams:
        raise ImportFailure(f"{table.file}: none of the firmware's usual variables is in the log (it has "
                            f"{', '.join(list(table.columns)[1:13])}); give a column map with --map")
    return out
