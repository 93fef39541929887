#!/usr/bin/env python3
"""Draws one flight: path, tracking error, disturbance and rotor speeds, as PDF, SVG and PNG."""

import project_python  # noqa: F401, I001 (first: it may start this script again in .venv)
import argparse
import sys

import numpy as np

import gustlab_figures as figures
from gustlab_figures import REFERENCE, plt


# above a panel: inside it a legend would hide what was flown
ABOVE = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.2}


def draw(options):
    flight = figures.Flight(options.flight)
    path_m, reference_m = flight.need("px", "py", "pz"), flight.need("rpx", "rpy", "rpz")
    speeds, speeds_label = flight.rotor_speeds()
    time_s = flight.time_s

    figure, axes = plt.subplot_mosaic([["path", "error"], ["path", "force"], ["height", "rotors"]], figsize=(7.2, 5.2))
    figure.suptitle(flight.name("vehicle", "trajectory", "controller", "outcome"))
    axes["path"].plot(*reference_m[:2], **REFERENCE)
    axes["path"].plot(*path_m[:2], label="flown")
    axes["path"].set(xlabel="x / m", ylabel="y / m")
    axes["path"].set_title("from above", loc="left")
    axes["path"].set_aspect("equal", adjustable="datalim")
    axes["path"].legend(ncols=2, **ABOVE)

    axes["height"].plot(time_s, reference_m[2], **REFERENCE)
    axes["height"].plot(time_s, path_m[2])
    axes["height"].set(xlabel="time / s", ylabel="z / m")

    error_m = path_m - reference_m
    axes["error"].plot(time_s, np.hypot(*error_m[:2]), label="horizontal")
    axes["error"].plot(time_s, np.abs(error_m[2]), label="vertical")
    axes["error"].set(ylabel="error / m", ylim=(0, None))
    axes["error"].legend(ncols=2, **ABOVE)

    # recordings do not know the disturbance
    if {"fx", "fy", "fz"} <= set(flight.columns):
        for name, force_N in zip("xyz", flight.need("fx", "fy", "fz")):
            axes["force"].plot(time_s, force_N, label=name)
        axes["force"].legend(ncols=3, **ABOVE)
    else:
        axes["force"].text(0.5, 0.5, "not recorded", ha="center", va="center", transform=axes["force"].transAxes)
    axes["force"].set(ylabel="disturbance / N")

    for number, speed in enumerate(speeds, 1):
        axes["rotors"].plot(time_s, speed, label=str(number), linewidth=0.7)
    axes["rotors"].set(xlabel="time / s", ylabel=speeds_label)
    axes["rotors"].legend(ncols=len(speeds), **ABOVE)
    figures.save(figure, options.out)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("flight", help="the --out of `gustlab run`, or a flight log NAME.csv[.gz] with a reference")
    parser.add_argument("--out", required=True, metavar="STEM", help="writes STEM.pdf, STEM.svg and STEM.png")
    return figures.main(draw, parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
