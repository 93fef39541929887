#!/usr/bin/env python3
"""Draws the paths of several flights over their references, one panel for each trajectory, as PDF, SVG and PNG."""

import project_python  # noqa: F401, I001 (first: it may start this script again in .venv)
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
            path_m, counts = flight.need("px", "py"), flight.time_s >= flight.outcome.get("settle_s", 0.0)
            (line,) = axis.plot(*path_m[:, counts], label=flight.name("controller"))
            axis.plot(*path_m[:, ~counts], color=line.get_color(), alpha=0.3)
            if flight.outcome.get("outcome") == "crashed":
                axis.plot(*path_m[:, -1], "x", color=line.get_color())
        axis.set(xlabel="x / m", ylabel="y / m", title=title)
        axis.set_aspect("equal", adjustable="datalim")
    # one legend below: inside a panel it would hide paths
    named = {label: line for axis in axes[0] for line, label in zip(*axis.get_legend_handles_labels())}
    figure.legend(named.values(), named.keys(), loc="outside lower center", ncols=len(named))
    flights = sum(panels.values(), [])
    notes = [f"gust of replicate {replicate}" for replicate in sorted({f.outcome["replicate"] for f in flights if "replicate" in f.outcome})]
    notes += [f"pale: the first {settle_s:g} s, which do not count" for settle_s in sorted({f.outcome.get("settle_s", 0.0) for f in flights}) if settle_s > 0.0]
    notes += ["×: crashed"] * any(f.outcome.get("outcome") == "crashed" for f in flights)
    figure.suptitle("; ".join(["one flight each", *notes]), fontsize=6)
    figures.save(figure, options.out)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("flights", nargs="+", help="folders that `gustlab run` wrote, or flight logs with a reference")
    parser.add_argument("--out", required=True, metavar="STEM", help="writes STEM.pdf, STEM.svg and STEM.png")
    return figures.main(draw, parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
