#!/usr/bin/env python3
"""Draws the paths of several flights over their references, one panel for each trajectory, as PDF, SVG and PNG."""

import project_python  # noqa: F401, I001 (first: it may start this script again in .venv)
import argparse
import sys

import gustlab_figures as figures
from gustlab_figures import COLORS, REFERENCE, plt


def labels(flights):
    """the controller of each flight of a panel, with what else tells it from the others of the same one"""
    names = [flight.name("controller") for flight in flights]
    experiments = [str(flight.outcome.get("experiment", "–")) for flight in flights]
    if len({experiment.split(".")[0] for experiment in experiments}) == 1:
        experiments = [experiment.split(".", 1)[-1] for experiment in experiments]  # variants of one
    replicates = [f"replicate {flight.outcome.get('replicate', '–')}" for flight in flights]
    for more in (experiments, replicates):
        if len(set(names)) < len(names) and len(set(more)) > 1:
            names = [", ".join(both) for both in zip(names, more)]
    return names


def draw(options):
    panels = {}
    for folder in options.flights:
        flight = figures.Flight(folder)
        panels.setdefault(flight.name("vehicle", "trajectory"), []).append(flight)

    figure, axes = plt.subplots(1, len(panels), figsize=(max(3.4, 2.6 * len(panels)), 3.0), squeeze=False)
    colors = {}
    for axis, (title, flights) in zip(axes[0], panels.items()):
        axis.plot(*flights[0].need("rpx", "rpy"), **REFERENCE)
        for label, flight in zip(labels(flights), flights):
            color = colors.setdefault(label, COLORS[len(colors) % len(COLORS)])
            path_m, counts = flight.need("px", "py"), flight.time_s >= flight.outcome.get("settle_s", 0.0)
            axis.plot(*path_m[:, counts], label=label, color=color)
            axis.plot(*path_m[:, ~counts], color=color, alpha=0.3)
            if flight.outcome.get("outcome") == "crashed":
                axis.plot(*path_m[:, -1], "x", color=color)
        axis.set(xlabel="x / m", ylabel="y / m", title=title)
        axis.set_aspect("equal", adjustable="datalim")
    # one legend below: inside a panel it would hide paths
    named = {label: line for axis in axes[0] for line, label in zip(*axis.get_legend_handles_labels())}
    entry_in = 0.5 + 0.055 * max(map(len, named))  # a line and letters of 7 points
    columns = max(1, min(len(named), int(figure.get_size_inches()[0] / entry_in)))
    figure.legend(named.values(), named.keys(), loc="outside lower center", ncols=columns)
    flights = sum(panels.values(), [])
    notes = [f"gust of replicate {replicate}" for replicate in sorted({f.outcome["replicate"] for f in flights if "replicate" in f.outcome})]
    notes += [f"pale: the first {settle_s:g} s, which do not count" for settle_s in sorted({f.outcome.get("settle_s", 0.0) for f in flights}) if settle_s > 0.0]
    notes += ["×: crashed"] * any(f.outcome.get("outcome") == "crashed" for f in flights)
    figures.note(figure, "; ".join(["one flight each", *notes]), "suptitle")
    figures.save(figure, options.out)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("flights", nargs="+", help="folders that `gustlab run` wrote, or flight logs with a reference: those of `gustlab sweep --logs`, too")
    parser.add_argument("--out", required=True, metavar="STEM", help="writes STEM.pdf, STEM.svg and STEM.png")
    return figures.main(draw, parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
