#!/usr/bin/env python3
"""Draws heat maps of RMSE and P95 over trajectories and controllers, one panel for each sweep and each point of its axes; or over two axes
of one sweep, one panel for each controller, trajectory and point of the other axes. As PDF, SVG and PNG."""

import project_python  # noqa: F401, I001 (first: it may start this script again in .venv)
import argparse
import sys
from pathlib import Path

import numpy as np

import gustlab_figures as figures
from gustlab_figures import plt


def cells(rows, column, down, across):
    """per (down, across), columns of runs.csv, in order of appearance: values of all runs in m, and which were completed"""
    table = {}
    for row in rows:
        values, completed = table.setdefault((row[down], row[across]), ([], []))
        values.append(row[column])
        completed.append(row["outcome"] == "completed")
    return table


def mean(values):
    """of the runs that have an error; NaN where none has"""
    counted = [value for value in values if np.isfinite(value)]
    return np.mean(counted) if counted else np.nan


def label(values, completed):
    """mean ± sample standard deviation of the runs; completed/total where not all were, and how many have an error where not all have"""
    counted = [value for value in values if np.isfinite(value)]
    text = f"{mean(values):.3f}" if counted else "–"  # over before the settling was
    if len(counted) > 1:
        text += f"\n± {np.std(counted, ddof=1):.3f}"
    if not all(completed):
        text += f"\n{sum(completed)}/{len(completed)}"
    return text if len(counted) == len(values) else text + f", n = {len(counted)}"


def draw_panel(axis, rows, column, down="controller", across="trajectory", most=None):
    """most: where the colours end, m; the largest mean of the panel when None"""
    table = cells(rows, column, down, across)
    downs = list(dict.fromkeys(first for first, _ in table))
    acrosses = list(dict.fromkeys(second for _, second in table))
    means = np.full((len(downs), len(acrosses)), np.nan)
    for (first, second), (values, _) in table.items():
        means[downs.index(first), acrosses.index(second)] = mean(values)
    largest = np.nanmax(means) if np.isfinite(means).any() else 1
    image = axis.imshow(means, cmap="Blues", vmin=0, vmax=largest if most is None else most, aspect="auto")
    for (first, second), cell in table.items():
        y, x = downs.index(first), acrosses.index(second)
        dark = np.isfinite(means[y, x]) and image.norm(means[y, x]) > 0.6
        axis.text(x, y, label(*cell), ha="center", va="center", fontsize=6, color="white" if dark else "black")
    axis.set_xticks(range(len(acrosses)), acrosses)
    axis.set_yticks(range(len(downs)), downs)
    runs = sorted({len(values) for values, _ in table.values()})
    axis.set_title(f"{rows[0]['experiment']} ({rows[0]['vehicle']}), N = {' or '.join(map(str, runs))}")
    axis.grid(False)
    axis.tick_params(length=0)
    return image


NOTE = ("mean ± sample standard deviation of N{} runs; completed/N where some were not, whose errors count up to their end;"
        " n: so many have an error, the others were over before the settling was")


def draw_axes(options, column, name):
    """one panel for each controller and trajectory over two axes, one scale of colours for all"""
    rows = figures.read_axes(options.sweeps[0], [options.x, options.y], column)
    panels = {}
    for row in rows:
        at = [f"{axis} {row[axis]}" for axis in figures.axes_of(rows) if axis not in (options.x, options.y)]
        panels.setdefault(", ".join([row["controller"], row["trajectory"], *at]), []).append(row)
    tables = [cells(panel, column, options.y, options.x) for panel in panels.values()]
    most = max((mean(values) for table in tables for values, _ in table.values() if np.isfinite(values).any()), default=1)
    height = 1.2 + 0.4 * len({row[options.y] for row in rows})
    figure, axes = plt.subplots(1, len(panels), figsize=(2.8 * len(panels), height), squeeze=False)
    for axis, (title, panel) in zip(axes[0], panels.items()):
        image = draw_panel(axis, panel, column, options.y, options.x, most)
        axis.set_title(title)
        axis.set(xlabel=options.x, ylabel=options.y)
    figure.colorbar(image, ax=axes[0].tolist(), label=f"mean {name.upper()} XY / m")
    figures.note(figure, NOTE.format(f" = {figures.runs_per_point(rows)}"))
    figures.save(figure, Path(options.out) / f"heatmap_{name}")


def draw_sweeps(options, column, name):
    points = {}
    for folder in options.sweeps:
        for row in figures.read_runs(folder):
            points.setdefault((folder, row["experiment"]), []).append(row)
    sweeps = list(points.values())
    height = 1.2 + 0.5 * max(len({row["controller"] for row in rows}) for rows in sweeps)
    figure, axes = plt.subplots(1, len(sweeps), figsize=(3.4 * len(sweeps), height), squeeze=False)
    for axis, rows in zip(axes[0], sweeps):
        figure.colorbar(draw_panel(axis, rows, column), ax=axis, label=f"mean {name.upper()} XY / m")
    figures.note(figure, NOTE.format(""))
    figures.save(figure, Path(options.out) / f"heatmap_{name}")


def draw(options):
    if (options.x is None) != (options.y is None) or (options.x and len(options.sweeps) > 1):
        raise figures.DataError("--x and --y belong together, and to one sweep (a heat map has two axes)")
    for column, name in (("rmse_xy_m", "rmse"), ("p95_xy_m", "p95")):
        (draw_axes if options.x else draw_sweeps)(options, column, name)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sweeps", nargs="+", help="folders that `gustlab sweep` or `gustlab merge` wrote")
    parser.add_argument("--x", metavar="AXIS", help="of one sweep with [[axis]] tables: across")
    parser.add_argument("--y", metavar="AXIS", help="down")
    parser.add_argument("--out", required=True, metavar="DIR", help="writes DIR/heatmap_rmse.* and DIR/heatmap_p95.*")
    return figures.main(draw, parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
