#!/usr/bin/env python3
"""Draws an error over an axis of a sweep, a line for each controller, a panel for each point of the other axes and each trajectory."""

import project_python  # noqa: F401, I001 (first: it may start this script again in .venv)
import argparse
import sys
from pathlib import Path

import numpy as np
from scipy import stats

import gustlab_figures as figures
from gustlab_figures import COLORS, plt


def interval(values):
    """mean over the runs and half of its 95 % interval (Student's), NaN where there is none"""
    values = np.array(values)
    values = values[np.isfinite(values)]
    if not len(values):
        return np.nan, np.nan
    if len(values) == 1:
        return values[0], 0.0
    return np.mean(values), stats.t.ppf(0.975, len(values) - 1) * np.std(values, ddof=1) / np.sqrt(len(values))


def draw_panel(axis, rows, options):
    """a line for each controller; hollow where a run was not completed"""
    for color, controller in zip(COLORS, dict.fromkeys(row["controller"] for row in rows)):
        points = {}
        for row in rows:
            if row["controller"] == controller:
                points.setdefault(figures.number(row[options.x]), []).append(row)
        x = sorted(points)
        mean, half = np.array([interval([row[options.metric] for row in points[at]]) for at in x]).T
        axis.errorbar(x, mean, half, color=color, label=controller, capsize=1.5, linewidth=1.0)
        whole = [all(row["outcome"] == "completed" for row in points[at]) for at in x]
        axis.scatter(x, mean, s=10, edgecolors=color, facecolors=[color if done else "white" for done in whole], zorder=3)
    axis.set_ylim(bottom=0)


def draw(options):
    rows = figures.read_axes(options.sweep, [options.x], options.metric)
    panels = {}
    for row in rows:
        at = [f"{name} {row[name]}" for name in figures.axes_of(rows) if name != options.x]
        panels.setdefault(", ".join([row["trajectory"], *at]), []).append(row)
    columns = min(3, len(panels))
    lines = -(-len(panels) // columns)
    figure, axes = plt.subplots(lines, columns, figsize=(2.6 * columns + 0.6, 2.0 * lines + 0.5), squeeze=False, sharex=True, sharey=True)
    for axis, (title, panel) in zip(axes.flat, panels.items()):
        draw_panel(axis, panel, options)
        axis.set_title(title)
    for axis in axes.flat[len(panels):]:
        axis.set_visible(False)
    for axis in axes.flat[len(panels) - columns:len(panels)]:
        axis.set_xlabel(options.x)
    axes.flat[0].legend()
    figures.note(figure, f"mean and its 95 % interval, N = {figures.runs_per_point(rows)}; hollow: not every run was completed; "
                         "none: all were over before the settling was")
    kind, of, unit = options.metric.split("_")
    figure.supylabel(f"mean {kind.upper()} {of.upper()} / {unit}")
    figures.save(figure, Path(options.out) / f"{options.metric}_over_{options.x}")


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sweep", help="folder of a finished sweep with [[axis]] tables")
    parser.add_argument("--x", required=True, metavar="AXIS", help="column of runs.csv with numbers")
    parser.add_argument("--metric", default="rmse_xy_m", help=f"one of {', '.join(figures.METRICS)} (rmse_xy_m)")
    parser.add_argument("--out", required=True, metavar="DIR", help="writes DIR/METRIC_over_AXIS.*")
    return figures.main(draw, parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
