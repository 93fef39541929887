"""Betaflight (Cleanflight, INAV) blackbox -> Recordings, one for each log in the file (decoder of betaflight-chirp-core)."""

import hashlib
from pathlib import Path

import numpy as np

from . import airframes
from .motors import put_speeds
from .problems import Finding, ImportFailure
from .progress import stage
from .streams import BATTERY, FORCE, RATE, Recording, stream
from .tables import read_bytes

STANDARD_GRAVITY = 9.80665
DSHOT = (48.0, 2047.0)      # DShot: 48 is the slowest, 2047 full throttle
PULSE = (1000.0, 2000.0)
SETTINGS = {"pose": "Betaflight logs no pose: an autopilot (INAV, ArduPilot, PX4) or motion capture is needed",
            "rate": "blackbox_sample_rate 1/1 or 1/2", "battery": "vbat in the blackbox fields (blackbox_disable_bat = OFF)"}


def read_blackbox(path: Path) -> Recording:
    from betaflight_chirp_core.decoder import FlightLogParser, split_sessions
    data = read_bytes(path)
    parts = split_sessions(data)
    if not parts:
        raise ImportFailure(f"{path}: byte 0: no blackbox log begins in this file")
    best = None
    for begin, end in parts:
        log = FlightLogParser(data, begin, end)
        stage("reading", lambda log=log: log.stream.pos / len(data))
        try:
            log.parse_header()
            log.parse_data()
        except Exception as error:  # the decoder raises whatever a damaged byte leads to
            raise ImportFailure(f"{path}: byte {begin}: the blackbox log cannot be decoded ({type(error).__name__}: {error}); "
                                "fetch it again") from error
        if best is None or len(log.main_frames) > len(best.main_frames):
            best = log
    if len(best.main_frames) < 20:
        raise ImportFailure(f"{path}: {len(best.main_frames)} frames in the longest of {len(parts)} logs: too few to be a flight")
    return _recording(str(path), data, best, len(parts))


def _recording(name: str, data: bytes, log, sessions: int) -> Recording:
    names = log.main_field_names or log.frame_defs["I"]["name"]
    block = np.array([[np.nan if cell is None else cell for cell in row[:len(names)]] for row in log.main_frames], dtype=float)
    column = {field: block[:, k] for k, field in enumerate(names)}
    config, zero = log.sys_config, float(column["time"][0])
    time_s = (column["time"] - zero) * 1e-6
    revision = str(config.get("firmwareRevision") or config.get("Firmware revision") or "").split(" (")[0]
    out = Recording(name, hashlib.sha256(data).hexdigest(), "betaflight-blackbox", revision or "Betaflight", "quadrotor x",
                    end_s=float(np.nanmax(time_s)), settings=SETTINGS)
    out.armed = [(0.0, out.end_s)]   # a blackbox records from arming to disarming
    out.topics = [(field, len(time_s), 1.0 / float(np.median(np.diff(time_s)))) for field in names]
    out.rotors = airframes.rotors(airframes.BETAFLIGHT["quadrotor x"])
    if sessions > 1:
        out.facts["logs_in_the_file"] = f"{sessions}; this is the longest"

    def triple(field: str) -> np.ndarray:
        return np.column_stack([column[f"{field}[{k}]"] for k in range(3)])

    # the board's axes are forward, left, up, and rates follow the right hand (Betaflight: pitch forward and yaw left are positive)
    if "gyroADC[0]" in column:
        out.put("body_rate", stream(RATE, time_s, np.radians(triple("gyroADC")), "gyroADC (filtered by the firmware)"))
    if "accSmooth[0]" in column:
        force = triple("accSmooth") * STANDARD_GRAVITY / float(config.get("acc_1G") or 2048)
        out.put("specific_force", stream(FORCE, time_s, force, "accSmooth"))
    motors = [field for field in names if field.startswith("motor[")]
    if len(motors) >= 3:
        low, high = PULSE if float(config.get("motorOutput", [0, 2000])[0]) > 900 else DSHOT
        u = np.clip((np.column_stack([column[m] for m in motors]) - low) / (high - low), 0.0, 1.0)
        out.put("u", stream([f"u{k + 1}" for k in range(len(motors))], time_s, u, f"motor, {low:g} to {high:g}"))
        if len(motors) != 4:
            out.rotors, out.airframe = [], f"{airframes.NAMES.get(len(motors), str(len(motors)) + ' rotors')}"
    reported = [f"eRPM[{k}]" for k in range(len(motors))]
    if motors and all(field in column for field in reported):
        # hundreds of electrical turns a minute; a pair of poles turns once an electrical turn
        poles = float(config.get("motor_poles") or 14)
        put_speeds(out, time_s, np.column_stack([column[field] for field in reported]) * 100.0 / (0.5 * poles), f"eRPM, {poles:g} poles")
    if "vbatLatest" in column:
        # firmware before 3.4.1 logs tenths of a volt, newer hundredths: its own limits of a cell tell
        unit = 0.01 if float(config.get("vbatmaxcellvoltage") or 43) > 100 else 0.1
        out.put("vbat", stream(BATTERY, time_s, unit * column["vbatLatest"], "vbatLatest"))
    corrupt = int(log.stats.get("total_corrupt_frames", 0))
    if corrupt:
        out.findings.append(Finding("gap", "time_s", 0.0, out.end_s, "warning", f"{corrupt} frames are corrupt and left out"))
    return out
