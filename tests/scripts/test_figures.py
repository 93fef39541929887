"""The figures: all three formats, the same bytes each time, and clear refusals that write nothing."""

import argparse
import contextlib
import importlib
import io
import gzip
import json
import math
import re
import sqlite3
import sys
import tempfile
import unittest
import unittest.mock
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import gustlab_figures
import plot_axis
import plot_flight
import plot_heatmap
import plot_overlay

RUNS = "experiment,vehicle,trajectory,controller,replicate,outcome,duration_s,rmse_xy_m,mae_xy_m,p95_xy_m,max_xy_m,rmse_z_m,key"


def words(svg):
    """what is written in a figure, its lines joined"""
    return " ".join(re.findall("<!-- (.*?) -->", svg))


class Figures(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)

    def run_script(self, name, *arguments):
        """exit code and standard error of a script"""
        errors = io.StringIO()
        with contextlib.redirect_stderr(errors):
            try:
                code = importlib.import_module(name).main([str(argument) for argument in arguments])
            except SystemExit as refused:
                code = refused.code
        return code, errors.getvalue()

    def flight(self, name, controller="pid", trajectory="circle", force=True, outcome="completed", settle_s=0.0):
        """a folder as `gustlab run` writes it, with a circle of 1 m flown 5 cm too wide"""
        folder = self.root / name
        folder.mkdir()
        columns = ["time_s", "px", "py", "pz", "rpx", "rpy", "rpz", "rotor1", "rotor2"] + ["fx", "fy", "fz"] * force
        lines = [",".join(columns)]
        for k in range(100):
            c, s = math.cos(0.06 * k), math.sin(0.06 * k)
            values = [0.1 * k, 1.05 * c, 1.05 * s, 1, c, s, 1, 900 + k, 900 - k] + [0.1 * s, 0, 0.2] * force
            lines.append(",".join(map(str, values)))
        (folder / "flight.csv").write_text("\n".join(lines) + "\n")
        outcome = {"vehicle": "iris", "trajectory": trajectory, "controller": controller, "replicate": 1, "outcome": outcome,
                   "settle_s": settle_s}
        (folder / "outcome.json").write_text(json.dumps(outcome))
        return folder

    def sweep(self, name):
        folder = self.root / name
        folder.mkdir()
        lines = [RUNS]
        for controller, error in (("pid", 0.4), ("asindy", 0.1)):
            for replicate, outcome in ((1, "completed"), (2, "crashed")):
                value = error + 0.01 * replicate
                lines.append(f"t,iris,circle,{controller},{replicate},{outcome},1,{value},{value},{value},{value},0,k")
        (folder / "runs.csv").write_text("\n".join(lines) + "\n")
        return folder

    def check_figure(self, stems, name, *arguments):
        """draws twice; the files are there, are what they say, and are equal"""
        written = []
        for out in ("first", "second"):
            code, text = self.run_script(name, *arguments, "--out", self.root / out / stems[0][0])
            self.assertEqual(code, 0, text)
            files = [self.root / out / f"{stem}{suffix}" for _, stem in stems for suffix in (".pdf", ".svg", ".png")]
            self.assertEqual(sorted(p for p in (self.root / out).rglob("*") if p.is_file()), sorted(files))
            written.append([file.read_bytes() for file in files])
        for k in range(0, len(written[0]), 3):
            self.assertTrue(written[0][k].startswith(b"%PDF"))
            self.assertIn(b"<svg", written[0][k + 1])
            self.assertTrue(written[0][k + 2].startswith(b"\x89PNG"))
        self.assertEqual(*written)
        return written[0]

    def test_flight(self):
        self.check_figure([("one", "one")], "plot_flight", self.flight("run"))
        # no legend lies over a curve
        drawn = []
        with unittest.mock.patch.object(gustlab_figures, "save", lambda figure, stem: drawn.append(figure)):
            plot_flight.draw(argparse.Namespace(flight=str(self.flight("again")), out="unused"))
        drawn[0].canvas.draw()
        legends = [(axes, axes.get_legend()) for axes in drawn[0].axes if axes.get_legend()]
        self.assertEqual(len(legends), 4)
        for axes, legend in legends:
            self.assertGreaterEqual(legend.get_window_extent().y0, axes.get_window_extent().y1 - 1.0)

    def test_flight_without_a_known_disturbance(self):
        self.check_figure([("one", "one")], "plot_flight", self.flight("run", force=False) / "flight.csv")

    def test_overlay(self):
        flights = [self.flight("a"), self.flight("b", controller="indi"), self.flight("c", trajectory="spiral")]
        self.assertIn(b"one flight each; gust of replicate 1 -->", self.check_figure([("paths", "paths")], "plot_overlay", *flights)[1])

    def test_overlay_says_what_does_not_count_and_who_crashed(self):
        flights = [self.flight("a", settle_s=8.0), self.flight("b", controller="indi", outcome="crashed", settle_s=8.0)]
        svg = self.check_figure([("paths", "paths")], "plot_overlay", *flights)[1].decode()
        self.assertIn("one flight each; gust of replicate 1; pale: the first 8 s, which do not count; ×: crashed", words(svg))

    def swept(self, name, *runs, settle_s="0.5"):
        """logs and store as `gustlab sweep --logs` leaves them"""
        folder = self.root / name
        folder.mkdir()
        with contextlib.closing(sqlite3.connect(folder / "runs.sqlite")) as store:
            store.execute("CREATE TABLE provenance(name, value)")
            store.executemany("INSERT INTO provenance VALUES (?, ?)", [("name", f"t.{name}"), ("vehicle", "iris"), ("settle_s", settle_s)])
            store.execute("CREATE TABLE runs(trajectory, controller, replicate, outcome)")
            store.executemany("INSERT INTO runs VALUES (?, ?, ?, ?)", runs)
            store.commit()
        logs = []
        for trajectory, controller, replicate, _ in runs:
            made = self.flight(f"{name}_{trajectory}_{controller}_{replicate}")
            logs.append(folder / f"{trajectory}_{controller}_{replicate}.csv")
            (made / "flight.csv").rename(logs[-1])
        return logs

    def test_overlay_of_the_logs_of_a_sweep(self):
        logs = self.swept("calm", ("circle", "pid", 1, "completed"), ("circle", "indi", 1, "crashed"), ("spiral", "indi", 1, "completed"))
        svg = words(self.check_figure([("paths", "paths")], "plot_overlay", *logs)[1].decode())
        self.assertIn("one flight each; gust of replicate 1; pale: the first 0.5 s, which do not count; ×: crashed", svg)
        self.assertEqual((svg.count("iris circle"), svg.count("iris spiral"), svg.count("pid"), svg.count("indi")), (1, 1, 1, 1))
        # what tells flights of one controller apart is said, and each has a colour of its own
        more = self.swept("gust", ("circle", "pid", 1, "completed"), ("circle", "pid", 2, "completed"))
        svg = words(self.check_figure([("paths", "paths")], "plot_overlay", logs[0], *more)[1].decode())
        for name in ("pid, calm, replicate 1", "pid, gust, replicate 1", "pid, gust, replicate 2"):
            self.assertIn(name, svg)

    def test_overlay_has_one_colour_for_a_controller(self):
        flights = [self.flight("a"), self.flight("b", controller="indi"), self.flight("c", controller="indi", trajectory="spiral")]
        drawn = []
        with unittest.mock.patch.object(gustlab_figures, "save", lambda figure, stem: drawn.append(figure)):
            plot_overlay.draw(argparse.Namespace(flights=flights, out="unused"))
        colors = {line.get_color() for axes in drawn[0].axes for line in axes.lines if line.get_label() == "indi"}
        self.assertEqual(len(colors), 1)

    def test_a_bad_cell_is_refused_with_its_place(self):
        folder = self.flight("a")
        log = folder / "flight.csv"
        good = log.read_text().splitlines()
        for k, cell, said in ((1, "x1", '"x1" in column px'), (2, "nan", '"nan" in column py'), (0, "inf", '"inf" in column time_s')):
            cells = good[5].split(",")
            column = len(",".join(cells[:k])) + (k > 0) + 1
            cells[k] = cell
            log.write_text("\n".join([*good[:5], ",".join(cells), *good[6:]]) + "\n")
            for name in ("plot_flight", "plot_overlay"):
                code, text = self.run_script(name, folder, "--out", self.root / "out" / "figure")
                self.assertEqual(code, 3, text)
                self.assertIn(f"{log}:6:{column}: {said} is not a finite number", text)
                self.assertFalse((self.root / "out").exists())
        # a column that is not shown may hold anything, and a missing sample is no fault
        log.write_text("\n".join([good[0] + ",mode", good[1].replace(good[1].split(",")[7], "", 1) + ",hover", *(line + "," for line in good[2:])]) + "\n")
        self.assertEqual(self.run_script("plot_overlay", folder, "--out", self.root / "figure")[0], 0)

    def test_a_bad_cell_of_a_sweep_is_refused_with_its_place(self):
        folder = self.sweep("sweep")
        runs = (folder / "runs.csv").read_text().splitlines()
        runs[2] = "t,iris,circle,pid,2,crashed,1,0.4,0.4,much,0.4,0,k"
        (folder / "runs.csv").write_text("\n".join(runs) + "\n")
        code, text = self.run_script("plot_heatmap", folder, "--out", self.root / "out")
        self.assertEqual(code, 3, text)
        self.assertIn(f'{folder / "runs.csv"}:3:{len("t,iris,circle,pid,2,crashed,1,0.4,0.4,") + 1}: "much" in column p95_xy_m is not a finite number', text)

    def test_heat_map_of_a_grid_has_a_panel_for_each_point(self):
        folder = self.axes_sweep("grid")
        svg = words(self.check_figure([("", "heatmap_rmse"), ("", "heatmap_p95")], "plot_heatmap", folder)[1].decode())
        for point in ("t.strength_0.5_mass_-0.2", "t.strength_2_mass_0"):
            self.assertEqual(svg.count(f"{point} (iris), N = 2"), 1)
        # beside the two that are drawn
        head, *rows = (folder / "runs.csv").read_text().splitlines()
        (folder / "runs.csv").write_text("\n".join([head + ",period", *(f"{row},{period}" for period in (5, 10) for row in rows)]) + "\n")
        svg = words(self.check_figure([("", "heatmap_rmse"), ("", "heatmap_p95")], "plot_heatmap", folder, "--x", "strength", "--y", "mass")[1].decode())
        self.assertIn("pid, circle, period 10", svg)
        self.assertIn("of N = 2 runs", svg)

    def test_heat_map_says_how_many_runs_have_an_error(self):
        self.assertEqual(plot_heatmap.label([0.1, math.nan, 0.3], [True, False, False]), "0.200\n± 0.141\n1/3, n = 2")
        self.assertEqual(plot_heatmap.label([math.nan, math.nan], [False, False]), "–\n0/2, n = 0")
        self.assertEqual(plot_heatmap.label([0.1, math.nan], [True, False]), "0.100\n1/2, n = 1")

    def test_notes_stay_within_their_figure(self):
        drawn = []
        one = self.sweep("one")
        with unittest.mock.patch.object(gustlab_figures, "save", lambda figure, stem: drawn.append(figure)):
            plot_heatmap.draw(argparse.Namespace(sweeps=[one], x=None, y=None, out="unused"))
            plot_axis.draw(argparse.Namespace(sweep=self.axes_sweep("axes"), x="strength", metric="rmse_xy_m", out="unused"))
            plot_overlay.draw(argparse.Namespace(flights=[self.flight("a", settle_s=8.0, outcome="crashed"),
                                                          *(self.flight(name, controller=name) for name in ("geometric", "asindy", "indi_outer"))], out="unused"))
        for figure in drawn:
            figure.canvas.draw()
            for text in (figure._supxlabel, figure._suptitle, *figure.legends):
                if text is not None:
                    box = text.get_window_extent()
                    self.assertGreaterEqual(box.x0, 0.0)
                    self.assertLessEqual(box.x1, figure.bbox.x1)
                    self.assertGreaterEqual(box.y0, 0.0)

    def test_heat_maps(self):
        folder = self.sweep("sweep")
        svg = self.check_figure([("", "heatmap_rmse"), ("", "heatmap_p95")], "plot_heatmap", folder)[1].decode()
        self.assertIn("t (iris), N = 2", svg)

    def test_heat_map_cell_says_mean_spread_and_how_many_completed(self):
        cell = plot_heatmap.cells(gustlab_figures.read_runs(self.sweep("sweep")), "rmse_xy_m", "controller", "trajectory")[("pid", "circle")]
        self.assertEqual(plot_heatmap.label(*cell), "0.415\n± 0.007\n1/2")

    def axes_sweep(self, name):
        """two axes with two points each, one run at each of them"""
        folder = self.sweep(name)
        head, *rows = (folder / "runs.csv").read_text().splitlines()
        lines = [f"t.strength_{strength}_mass_{mass}{row[1:]},{strength},{mass}" for strength in (0.5, 2) for mass in (-0.2, 0) for row in rows]
        (folder / "runs.csv").write_text("\n".join([head + ",strength,mass", *lines]) + "\n")
        return folder

    def test_heat_map_over_two_axes(self):
        folder = self.axes_sweep("sweep")
        svg = self.check_figure([("", "heatmap_rmse"), ("", "heatmap_p95")], "plot_heatmap", folder, "--x", "strength", "--y", "mass")[1].decode()
        self.assertIn("pid, circle -->", svg)
        self.assertIn("of N = 2 runs", svg)
        code, text = self.run_script("plot_heatmap", folder, "--x", "strength", "--y", "masses", "--out", self.root / "out")
        self.assertEqual(code, 3)
        self.assertIn("no axis masses (it has strength, mass)", text)

    def test_error_over_an_axis(self):
        folder = self.axes_sweep("sweep")
        code, text = self.run_script("plot_axis", folder, "--x", "strength", "--metric", "outcome", "--out", self.root / "out")
        self.assertEqual((code, text.splitlines()[-1]), (3, f"{folder}: outcome is no error of a run; one of: {', '.join(gustlab_figures.METRICS)}"))
        svg = self.check_figure([("", "rmse_xy_m_over_strength")], "plot_axis", folder, "--x", "strength")[1].decode()
        self.assertIn("circle, mass -0.2 -->", svg)
        self.assertIn("pid -->", svg)
        self.assertIn("its 95 % interval, N = 2;", svg)
        self.assertIn("mean RMSE XY / m -->", svg)

    def test_interval_of_few_runs_is_student_s(self):
        # two runs, 0.2 apart: t(0.975, 1) = 12.706, standard error 0.1; a run without a figure does not count
        mean, half = plot_axis.interval([1.0, 1.2, math.nan])
        self.assertAlmostEqual(mean, 1.1)
        self.assertAlmostEqual(half, 1.2706, places=4)
        self.assertTrue(all(map(math.isnan, plot_axis.interval([math.nan]))))

    def test_what_cannot_be_drawn_is_refused_and_nothing_is_written(self):
        empty = self.root / "empty"
        empty.mkdir()
        ragged = self.root / "ragged.csv"
        ragged.write_text("time_s,px\n1,2\n3\n")
        without = self.root / "without.csv"
        without.write_text("time_s,px\n1,2\n3,4\n")
        cut = self.root / "cut.csv.gz"
        cut.write_bytes(gzip.compress(without.read_bytes() * 1000)[:-20])
        broken = self.root / "broken.csv.gz"
        broken.write_bytes(cut.read_bytes()[:12] + b"\xff" * 40)
        for name, argument, said in (
            ("plot_flight", cut, "cannot be read"),
            ("plot_overlay", cut, "cannot be read"),
            ("plot_overlay", broken, "cannot be read"),
            ("plot_flight", empty, "no flight.csv"),
            ("plot_flight", ragged, "cannot be read"),
            ("plot_flight", without, "no column py, pz"),
            ("plot_overlay", self.root / "nowhere.csv", "cannot be read"),
            ("plot_heatmap", empty, "cannot be read"),
        ):
            code, text = self.run_script(name, argument, "--out", self.root / "out" / "figure")
            self.assertEqual(code, 3, text)
            self.assertIn(said, text)
            self.assertEqual(len(text.splitlines()), 1, text)
            self.assertFalse((self.root / "out").exists())
        self.assertEqual(self.run_script("plot_flight")[0], 2)

    def test_a_figure_beyond_what_can_be_drawn_is_refused(self):
        figure = gustlab_figures.plt.figure(figsize=(1.0, 400.0))
        with self.assertRaisesRegex(gustlab_figures.DataError, "figure: cannot be drawn .80000 pixels on a side"):
            gustlab_figures.save(figure, self.root / "figure")


if __name__ == "__main__":
    unittest.main()
