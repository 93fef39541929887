"""What the figures share: reading flights, one look, and files that are the same bytes each time."""

import contextlib
import csv
import gzip
import io
import json
import math
import sqlite3
import textwrap
import zlib
from pathlib import Path

import matplotlib
from gustlab_import.outputs import write_outputs
from gustlab_import.problems import ImportFailure as DataError
from gustlab_import.problems import ended

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

# Okabe and Ito's palette, told apart by readers with any colour vision
COLORS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"]
MOST_PX = 65535  # on a side, as matplotlib draws it
REFERENCE = {"color": "0.55", "linestyle": (0, (4, 2)), "linewidth": 1.0, "label": "reference"}

plt.rcParams.update({
    "font.size": 8, "axes.titlesize": 8, "axes.labelsize": 8, "legend.fontsize": 7, "figure.constrained_layout.use": True,
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "0.92", "axes.axisbelow": True,
    "lines.linewidth": 1.0, "legend.frameon": False, "axes.prop_cycle": plt.cycler(color=COLORS),
    "savefig.dpi": 200, "svg.hashsalt": "gustlab", "pdf.fonttype": 42,
})


def read_number(text, place, column):
    """a cell as a number, NaN where it is empty; place: file:line:column of it"""
    text = text.strip()
    try:
        value = float(text or "nan")
    except ValueError:
        value = math.inf
    if text and not math.isfinite(value):
        raise DataError(f'{place}: "{text[:40]}" in column {column} is not a finite number (a missing one is an empty cell)')
    return value


def said_of_run(path):
    """what the store of a sweep says of the run whose log `gustlab sweep --logs` wrote, as outcome.json would; nothing where there is none"""
    store = path.parent / "runs.sqlite"
    if not store.is_file():
        return {}
    try:
        with contextlib.closing(sqlite3.connect(f"{store.resolve().as_uri()}?mode=ro", uri=True)) as database:
            run = database.execute("SELECT trajectory, controller, replicate, outcome FROM runs "
                                   "WHERE trajectory || '_' || controller || '_' || replicate = ?", (path.name.removesuffix(".csv"),)).fetchone()
            provenance = dict(database.execute("SELECT name, value FROM provenance WHERE name IN ('name', 'vehicle', 'settle_s')"))
            return {} if run is None else {"experiment": provenance["name"], "vehicle": provenance["vehicle"], "settle_s": float(provenance["settle_s"]),
                                           **dict(zip(("trajectory", "controller", "replicate", "outcome"), run))}
    except (sqlite3.Error, KeyError, ValueError) as error:
        raise DataError(f"{store}: cannot be read ({error})") from None


class Flight:
    """one flight: columns by name (FORMATS: SI, world z up), and what `gustlab run` or the sweep said of it"""

    def __init__(self, path):
        path = Path(path)
        self.path = path
        if path.is_dir():
            found = [path / name for name in ("flight.csv", "flight.csv.gz") if (path / name).is_file()]
            if not found:
                raise DataError(f"{path}: no flight.csv (is it the --out of `gustlab run`?)")
            path = found[0]
        self.file = path
        outcome = path.parent / "outcome.json"
        try:
            self.outcome = json.loads(outcome.read_text(encoding="utf-8")) if outcome.is_file() else said_of_run(path)
            with gzip.open(path, "rt", encoding="utf-8-sig") if path.suffix == ".gz" else open(path, encoding="utf-8-sig") as file:
                self.columns = {name.strip(): k for k, name in enumerate(file.readline().split(","))}
                self.rows = [(number, line.rstrip("\n").split(",")) for number, line in enumerate(file, 2) if line.strip()]
        except (OSError, EOFError, zlib.error, ValueError) as error:
            raise DataError(f"{path}: cannot be read ({' '.join(str(error).split())})") from None
        for number, cells in self.rows:
            if len(cells) != len(self.columns):
                raise DataError(f"{path}:{number}:1: cannot be read (this row has {len(cells)} cells, the header {len(self.columns)})")
        if not self.rows:
            raise DataError(f"{path}: no table (a header and rows of {len(self.columns)} numbers are needed)")
        self.time_s = self.need("time_s")

    def column(self, name):
        """its numbers; only what is shown is read, as a log may have columns of its own"""
        k = self.columns[name]
        return [read_number(cells[k], f"{self.file}:{number}:{sum(map(len, cells[:k])) + k + 1}", name) for number, cells in self.rows]

    def need(self, *names):
        """the columns as one array, shape (samples,) or (len(names), samples)"""
        missing = [name for name in names if name not in self.columns]
        if missing:
            raise DataError(f"{self.path}: no column {', '.join(missing)} (the figure shows it)")
        columns = np.array([self.column(name) for name in names])
        return columns[0] if len(names) == 1 else columns

    def rotor_speeds(self):
        """measured rotor speeds, else the actuator inputs, shape (rotors, samples); and what they are"""
        for prefix, label in (("rotor", "rotor speed / rad/s"), ("u", "actuator input")):
            names = [f"{prefix}{i}" for i in range(1, 9) if f"{prefix}{i}" in self.columns]
            if names:
                return np.atleast_2d(self.need(*names)), label
        raise DataError(f"{self.path}: no column rotor1 or u1 (the figure shows it)")

    def name(self, *keys):
        """words for legends and titles; the folder's name where nothing was said"""
        said = [str(self.outcome[key]) for key in keys if key in self.outcome]
        return " ".join(said) or self.path.name


def read_runs(folder):
    """rows of a sweep's runs.csv as dictionaries"""
    path = Path(folder) / "runs.csv"
    try:
        with open(path, encoding="utf-8", newline="") as file:
            reader = csv.DictReader(file)
            lines = [(row, reader.line_num) for row in reader]
    except OSError as error:
        raise DataError(f"{path}: cannot be read ({error.strerror})") from None
    rows = [row for row, _ in lines]
    wanted = {"experiment", "vehicle", "trajectory", "controller", "outcome", "rmse_xy_m", "p95_xy_m"}
    if not rows or not wanted <= set(rows[0]):
        raise DataError(f"{path}: not the runs of a sweep (columns {', '.join(sorted(wanted))} and a row are needed)")
    for row, line in lines:
        if None in row or None in row.values():
            raise DataError(f"{path}:{line}:1: cannot be read (this row has other cells than the header's {len(rows[0])})")
        begin = 1
        for name, text in list(row.items()):
            if name in METRICS:
                row[name] = read_number(text, f"{path}:{line}:{begin}", name)
            begin += len(text) + 1
    return rows


FIXED = ("experiment,vehicle,trajectory,controller,replicate,outcome,duration_s,rmse_xy_m,mae_xy_m,p95_xy_m,max_xy_m,rmse_z_m,"
         "key,rotor_sd_radps,rotor_rate_radps2").split(",")
METRICS = FIXED[7:12]  # m


def axes_of(rows):
    """the names of the axes of a sweep: the columns that every runs.csv does not have"""
    return [name for name in rows[0] if name not in FIXED]


def number(text):
    """a value of an axis as a number, else its text"""
    try:
        return float(text)
    except ValueError:
        return text


def read_axes(folder, names, metric):
    """rows of a sweep that has these axes and this metric"""
    rows = read_runs(folder)
    for name in names:
        if name not in axes_of(rows):
            raise DataError(f"{folder}: no axis {name} (it has {', '.join(axes_of(rows)) or 'none'})")
    if metric not in METRICS:
        raise DataError(f"{folder}: {metric} is no error of a run; one of: {', '.join(METRICS)}")
    return rows


def runs_per_point(rows):
    """how many runs stand behind a mean: "5", or "5 or 20" where they differ"""
    cells = {}
    for row in rows:
        at = tuple(row[name] for name in ("experiment", "vehicle", "trajectory", "controller", *axes_of(rows)))
        cells[at] = cells.get(at, 0) + 1
    return " or ".join(map(str, sorted(set(cells.values()))))


def note(figure, text, write="supxlabel"):
    """small words below the figure, or above it (suptitle), in as many lines as its width needs"""
    letters_per_inch = 21  # of 6 points
    getattr(figure, write)("\n".join(textwrap.wrap(text, int(letters_per_inch * figure.get_size_inches()[0]))), fontsize=6)


def save(figure, stem):
    """writes stem.pdf, stem.svg and stem.png without dates or versions"""
    stem, files = Path(stem), {}
    side_px = plt.rcParams["savefig.dpi"] * max(figure.get_size_inches())
    if side_px > MOST_PX:
        raise DataError(f"{stem}: cannot be drawn ({side_px:.0f} pixels on a side, {MOST_PX} at most); draw fewer values of the axes")
    for kind, unsaid in (("pdf", ("CreationDate", "Producer", "Creator")), ("svg", ("Date", "Creator")), ("png", ("Software",))):
        file = io.BytesIO()
        figure.savefig(file, format=kind, metadata=dict.fromkeys(unsaid))
        files[stem.with_name(f"{stem.name}.{kind}")] = file.getvalue()
    plt.close(figure)
    write_outputs(files)


def main(draw, parser, arguments):
    """runs a figure's command line with the program's exit codes"""
    return ended(lambda: draw(parser.parse_args(arguments)) or 0)
