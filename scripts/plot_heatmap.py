#!/usr/bin/env python3
"""Draws heat maps of RMSE and P95 over trajectories and controllers, one panel for each sweep, as PDF, SVG and PNG."""

import project_python  # noqa: F401, I001 (first: it may start this script again in .venv)
import argparse
import sys
from pathlib import Path

import numpy as np

import gustlab_figures as figures
from gustlab_figures import plt


def cells(rows, column):
    """per (controller, trajectory) in order of appearance: values of all runs in m, and how many were completed"""
    table = {}
    for row in rows:
        values, completed = table.setdefault((row["controller"], row["trajectory"]), ([], []))
        values.append(float(row[column] or "nan"))
        completed.append(row["outcome"] == "completed")
    return table


def label(values, completed):
    """mean ± sample standard deviation of the runs; completed/total where not all were"""
    if not np.isfinite(values).any():
        text = "–"  # over before the settling was
    else:
        text = f"{np.mean(values):.3f}"
        if len(values) > 1:
            text += f"\n± {np.std(values, ddof=1):.3f}"
    return text if all(completed) else text + f"\n{sum(completed)}/{len(completed)}"


def draw_panel(axis, rows, column):
    table = cells(rows, column)
    controllers = list(dict.fromkeys(controller for controller, _ in table))
    trajectories = list(dict.fromkeys(trajectory for _, trajectory in table))
    means = np.full((len(controllers), len(trajectories)), np.nan)
    for (controller, trajectory), (values, _) in table.items():
        means[controllers.index(controller), trajectories.index(trajectory)] = np.mean(values)
    image = axis.imshow(means, cmap="Blues", vmin=0, vmax=np.nanmax(means) if np.isfinite(means).any() else 1, aspect="auto")
    for (controller, trajectory), cell in table.items():
        y, x = controllers.index(controller), trajectories.index(trajectory)
        dark = np.isfinite(means[y, x]) and image.norm(means[y, x]) > 0.6
        axis.text(x, y, label(*cell), ha="center", va="center", fontsize=6, color="white" if dark else "black")
    axis.set_xticks(range(len(trajectories)), trajectories)
    axis.set_yticks(range(len(controllers)), controllers)
    runs = sorted({len(values) for values, _ in table.values()})
    axis.set_title(f"{rows[0]['experiment']} ({rows[0]['vehicle']}), N = {' or '.join(map(str, runs))}")
    axis.grid(False)
    axis.tick_params(length=0)
    return image


def draw(options):
    sweeps = [figures.read_runs(folder) for folder in options.sweeps]
    for column, name in (("rmse_xy_m", "rmse"), ("p95_xy_m", "p95")):
        height = 1.2 + 0.5 * max(len({row["controller"] for row in rows}) for rows in sweeps)
        figure, axes = plt.subplots(1, len(sweeps), figsize=(3.4 * len(sweeps), height), squeeze=False)
        for axis, rows in zip(axes[0], sweeps):
            figure.colorbar(draw_panel(axis, rows, column), ax=axis, label=f"mean {name.upper()} XY / m")
        figure.supxlabel("mean ± sample standard deviation of N runs; completed/N where some were not, whose errors count up to their end;"
                         " –: over before the settling was", fontsize=6)
        figures.save(figure, Path(options.out) / f"heatmap_{name}")


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sweeps", nargs="+", help="folders that `gustlab sweep` or `gustlab merge` wrote")
    parser.add_argument("--out", required=True, metavar="DIR", help="writes DIR/heatmap_rmse.* and DIR/heatmap_p95.*")
    return figures.main(draw, parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
