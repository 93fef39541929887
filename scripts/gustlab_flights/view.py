"""gustlab view: a flight in MuJoCo's own viewer."""

import time
from argparse import Namespace
from pathlib import Path

import numpy as np
from gustlab_import.command_line import Options

from . import scene as scenes
from .flight_file import FlightFile
from .problems import IO, USAGE, Refusal

RATE_HZ = 60.0


def arguments(argv: list) -> Namespace:
    parser = Options(prog="gustlab view", description="plays a flight in MuJoCo's viewer, again and again: path blue, "
                                     "reference grey, gust orange, rotors' thrust green; space stops it",
                                     epilog="needs a display; without one, `gustlab render` writes a film. exit codes: 0 the window was "
                                     "closed, 2 usage, 3 the log cannot be drawn, 4 no display or a file that cannot be read")
    parser.add_argument("flight", type=Path, metavar="FLIGHT", help="a flight log NAME.csv[.gz], or the --out of `gustlab run`")
    parser.add_argument("--vehicle", metavar="NAME|PATH", help="vehicle (default: the sidecar's)")
    parser.add_argument("--speed", type=float, default=1.0, metavar="X", help="times faster than real time (default: 1)")
    parser.add_argument("--once", action="store_true", help="plays it once and closes the window")
    options = parser.parse_args(argv)
    if not 0.01 <= options.speed <= 1000.0:
        raise Refusal(f"--speed {options.speed:g}: from 0.01 to 1000", USAGE)
    return options


def need_display() -> None:
    import warnings

    import glfw
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if not glfw.init():
            raise Refusal("view: no display can be opened here; `gustlab render FLIGHT --out film.mp4` needs none", IO)


def run(argv: list) -> int:
    options = arguments(argv)
    flight = FlightFile(options.flight)
    times = scenes.picture_times(flight, flight.time_s[0], flight.time_s[-1], 1.0 / RATE_HZ)
    need_display()
    import mujoco.viewer
    scene = scenes.Scene(scenes.vehicle_file(flight, options.vehicle), scenes.floor_of(flight), (640, 480))
    length = flight.time_s[-1] - flight.time_s[0]
    shown = scenes.motion(flight, scene.vehicle, scene.weight_N, times)
    paused = []

    def key(code: int) -> None:
        if code == ord(" "):
            paused.clear() if paused else paused.append(True)

    with mujoco.viewer.launch_passive(scene.model, scene.data, key_callback=key, show_left_ui=False, show_right_ui=False) as viewer:
        viewer.cam.lookat[:], viewer.cam.distance = shown.position.mean(axis=0), 1.5 * np.ptp(shown.position, axis=0).max() + 5.0 * scene.span_m
        played_s, last = 0.0, time.monotonic()
        while viewer.is_running():
            now = time.monotonic()
            played_s += 0.0 if paused else options.speed * (now - last)
            last = now
            if options.once and played_s >= length:
                break
            with viewer.lock():
                k = min(int((played_s % length) * RATE_HZ), len(shown.time_s) - 1)
                scene.place(shown, k)
                viewer.user_scn.ngeom = 0
                scene.decorate(viewer.user_scn, shown, k)
            viewer.sync()
            time.sleep(1.0 / RATE_HZ)
    return 0
