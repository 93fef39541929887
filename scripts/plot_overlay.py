#!/usr/bin/env python3
"""Draws the paths of several flights over their references, one panel for each trajectory, as PDF, SVG and PNG."""

import argparse
import sys

import gustlab_figures as figures
from gustlab_figures import REFERENCE, plt


def draw(options):
    panels = {}
    for folder in options.flights:
        flight = figures.Flight(folder)
        panels.setdefault(flight.name("vehicle", "trajectory"), []).append(flight)

    figure, axes = plt.subplots(1, len(panels), figsize=(2.6 * len(panels), 3.0), squeeze=False)
    for axis, (title, flights) in zip(axes[0], panels.items()):
        axis.plot(*flights[0].need("rpx", "rpy"), **REFERENCE)
        for flight in flights:
            axis.plot(*flight.need("px", "py"), label=flight.name("controller"))
        axis.set(xlabel="x / m", ylabel="y / m", title=title)
        axis.set_aspect("equal", adjustable="datalim")
    # one legend below: inside a panel it would hide paths
    named = {label: line for axis in axes[0] for line, label in zip(*axis.get_legend_handles_labels())}
    figure.legend(named.values(), named.keys(), loc="outside lower center", ncols=len(named))
    figures.save(figure, options.out)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("flights", nargs="+", help="folders that `gustlab run` wrote, or flight logs with a reference")
    parser.add_argument("--out", required=True, metavar="STEM", help="writes STEM.pdf, STEM.svg and STEM.png")
    return figures.main(draw, parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
