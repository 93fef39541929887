"""The commands run, sweep, merge, table, metrics and gate from outside: exit codes, streams, interrupt and resume."""

import contextlib
import csv
import ctypes
import functools
import json
import os
import re
import shlex
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "cli"))

from small_experiments import CIRCLE, GUST, TUNING, experiment_toml  # noqa: E402

PROGRAM = os.environ["GUSTLAB_PROGRAM"]

EXPERIMENT = experiment_toml("circle", "hover", replicates=3, duration_s=1.0, more="[environment]\nground_z_m = 0.0\n" + CIRCLE + GUST)


class Commands(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="gustlab_test_"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.experiment = self.folder / "experiment.toml"
        self.experiment.write_text(EXPERIMENT)

    def start(self, *arguments, first=None, **more):
        return subprocess.Popen([PROGRAM, *map(str, arguments)], cwd=self.folder, text=True, env=os.environ | more,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=first)

    def call(self, *arguments, code=0):
        process = self.start(*arguments)
        out, err = process.communicate(timeout=600)
        self.assertEqual(process.returncode, code, f"{arguments}\n{out}\n{err}")
        return out, err

    def sweep(self, out, *more, code=0):
        return self.call("sweep", self.experiment, "--out", self.folder / out, *more, code=code)

    def runs(self, out):
        return (self.folder / out / "runs.csv").read_bytes()


class Sweeps(Commands):
    def test_rows_are_the_plan_and_nothing_is_said_on_stdout(self):
        out, err = self.sweep("a")
        self.assertEqual(out, "")
        self.assertNotIn("\r", err)  # no progress: not a terminal
        rows = list(csv.DictReader(self.runs("a").decode().splitlines()))
        plan = list(csv.DictReader(self.sweep("unused", "--dry-run")[0].splitlines()))
        self.assertEqual([row["key"] for row in rows], [row["key"] for row in plan])
        self.assertFalse((self.folder / "unused").exists())
        self.assertEqual(list(rows[0]), "experiment vehicle trajectory controller replicate outcome duration_s rmse_xy_m mae_xy_m "
                                        "p95_xy_m max_xy_m rmse_z_m key rotor_sd_radps rotor_rate_radps2".split())

    def test_shards_threads_and_the_whole_are_the_same_bytes(self):
        self.sweep("one", "--jobs", "1")
        self.sweep("four", "--jobs", "4")
        self.assertEqual(self.runs("one"), self.runs("four"))
        for part in (1, 2, 3):
            self.sweep(f"part{part}", "--shard", f"{part}/3")
        self.call("merge", "part3", "part1", "part2", "--out", "whole")
        self.assertEqual(self.runs("one"), self.runs("whole"))

    def count(self, path):
        if not path.exists():
            return 0
        with contextlib.closing(sqlite3.connect(path)) as database:  # an open reader keeps the store locked
            tables = database.execute("SELECT count(*) FROM sqlite_master WHERE name = 'flown'").fetchone()[0]
            return database.execute("SELECT count(*) FROM flown").fetchone()[0] if tables else 0

    def test_ctrl_c_keeps_what_is_done_and_resumes(self):
        big = ["--set", "replicates=400", "--set", "duration_s=10.0", "--jobs", "1"]
        process = self.start("sweep", self.experiment, "--out", self.folder / "c", *big)
        # the handler is there before the store is
        while process.poll() is None and not (self.folder / "c" / "runs.sqlite-wal").exists():
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=600)
        self.assertEqual(process.returncode, 130, err)
        self.assertIn("go on with --resume", err)
        self.assertFalse((self.folder / "c" / "runs.csv").exists())
        self.assertLess(self.count(self.folder / "c" / "runs.sqlite"), 800)

    def test_resume_adds_nothing_to_a_finished_sweep(self):
        self.sweep("a")
        before = self.runs("a")
        self.sweep("a", "--resume")
        self.assertEqual(self.runs("a"), before)

    def test_resume_writes_the_logs_of_runs_that_are_done(self):
        self.sweep("a")
        self.sweep("b", "--logs")
        before = self.runs("a")
        self.sweep("a", "--resume", "--logs")
        self.assertEqual(self.runs("a"), before)
        logs = sorted(path.name for path in (self.folder / "b").iterdir() if path.name.startswith(("circle", "hover")))
        self.assertEqual(len(logs), 12)
        for name in logs:
            self.assertEqual((self.folder / "a" / name).read_bytes(), (self.folder / "b" / name).read_bytes(), name)
        # a log that is there stays
        (self.folder / "a" / logs[0]).write_text("mine")
        (self.folder / "a" / "hover_pid_2.csv").unlink()
        self.sweep("a", "--resume", "--logs")
        self.assertEqual((self.folder / "a" / logs[0]).read_text(), "mine")
        self.assertTrue((self.folder / "a" / "hover_pid_2.csv").exists())

    def peak_KiB(self, replicates, duration_s):
        """of the program itself (what wait4 says of a child counts the memory of Python, which it was before), and what of it no
        file stands behind: how much of its code is in memory is the system's choice. In small pages: huge ones (2 MiB) are too. The store is
        in memory where that is: on a disk the heap is up to 2 MB larger in some sweeps and not in others. The address sanitizer keeps what was freed
        from use, by default 256 MB of it"""
        no_huge_pages = functools.partial(ctypes.CDLL(None).prctl, 41, 1, 0, 0, 0)  # PR_SET_THP_DISABLE of linux/prctl.h
        in_memory = tempfile.TemporaryDirectory(dir="/dev/shm" if os.access("/dev/shm", os.W_OK) else None)
        self.addCleanup(in_memory.cleanup)
        process = self.start("sweep", self.experiment, "--out", Path(in_memory.name) / "out", "--jobs", "1",
                             "--set", f"replicates={replicates}", "--set", f"duration_s={duration_s}", first=no_huge_pages,
                             ASAN_OPTIONS=os.environ.get("ASAN_OPTIONS", "") + ":quarantine_size_mb=1")
        whole, own = 0, 0
        while process.poll() is None:
            status = dict(re.findall(r"(\w+):\s+(\d+) kB", Path(f"/proc/{process.pid}/status").read_text()))
            whole, own = max(whole, int(status.get("VmHWM", 0))), max(own, int(status.get("RssAnon", 0)))
            time.sleep(0.002)
        _, err = process.communicate()
        self.assertEqual(process.returncode, 0, err)
        return whole, own

    def test_memory_does_not_grow_with_the_number_of_runs(self):
        (_, few), (_, many) = self.peak_KiB(10, 0.5), self.peak_KiB(500, 0.5)
        self.assertLess(many - few, 4096, (few, many))
        # a shorter sweep may end before a busy machine sees its peak
        (whole, few), (_, many) = self.peak_KiB(6000, 0.02), self.peak_KiB(25000, 0.02)
        self.assertLess(many - few, 0.05 * whole, (few, many, whole))


class Mistakes(Commands):
    def expect(self, code, says, *arguments):
        before = sorted(self.folder.rglob("*"))
        out, err = self.call(*arguments, code=code)
        self.assertEqual(out, "")
        self.assertIn(says, err)
        self.assertEqual(sorted(self.folder.rglob("*")), before, "something was written")

    def test_each_is_one_message_an_exit_code_and_no_file(self):
        out = ["--out", "new"]
        sweep = ["sweep", self.experiment, *out]
        for code, says, arguments in [
            (2, "table9: no such file", ["sweep", "table9", *out]),
            (2, "nowhere.toml: cannot read", ["sweep", "nowhere.toml", *out]),
            (2, "--out is missing", ["sweep", self.experiment]),
            (2, "not a shard", [*sweep, "--shard", "0/3"]),
            (2, "not a shard", [*sweep, "--shard", "4/3"]),
            (2, "not a shard", [*sweep, "--shard", "1/3x"]),
            (2, "not a shard", [*sweep, "--shard", "half"]),
            (2, "not a shard", [*sweep, "--shard", " 1/2"]),
            (2, "not a shard", [*sweep, "--shard", "1/ 2"]),
            (2, "not a shard", [*sweep, "--shard", "+1/2"]),
            (2, "not a shard", [*sweep, "--shard=-1/-1"]),
            (2, "not a shard", [*sweep, "--shard", "1/99999999999999999999"]),
            (2, "--jobs", [*sweep, "--jobs", "0"]),
            (2, "--jobs", [*sweep, "--jobs", "many"]),
            (2, "--format", ["table", "new", "--format", "pdf"]),
            (2, "step_s", [*sweep, "--set", "step_s=0.003"]),
            (2, "replicates", [*sweep, "--set", "replicates=0"]),
            (2, "replicate", [*sweep, "--set", "replicatse=3"]),
            (2, "--set", [*sweep, "--set", "replicates"]),
            (2, "spiral: not in this experiment", ["run", self.experiment, "--trajectory", "spiral", "--controller", "pid", *out]),
            (2, "circel: not in this experiment (it has circle, hover); did you mean \"circle\"?",
             ["run", self.experiment, "--trajectory", "circel", "--controller", "pid", *out]),
            (2, "--replicate", ["run", self.experiment, "--trajectory", "circle", "--controller", "pid", "--replicate", "-1", *out]),
            (3, "no results here", ["table", "new"]),
            (3, "no results here", ["merge", "new", "newer", "--out", "newest"]),
            (3, "no results here", ["gate", "new", "--baseline", "base.csv"]),
            (3, "nowhere.csv: cannot read", ["metrics", "nowhere.csv"]),
        ]:
            with self.subTest(says=says, arguments=arguments):
                self.expect(code, says, *arguments)

    def test_store_is_never_overwritten_nor_mixed(self):
        self.sweep("a")
        self.expect(2, "there are results already", "sweep", self.experiment, "--out", "a")
        self.expect(2, "another experiment (seed = 1 there, seed = 2 here)", "sweep", self.experiment, "--out", "a", "--seed", "2", "--resume")

    def test_place_that_is_a_file_is_exit_2(self):
        (self.folder / "file").write_text("")
        self.expect(2, "file/new", "sweep", self.experiment, "--out", "file/new")
        self.expect(2, "file/new", "run", self.experiment, "--trajectory", "hover", "--controller", "pid", "--out", "file/new")


class Tables(Commands):
    def test_every_format_of_one_sweep(self):
        self.sweep("a")
        self.assertIn("| crazyflie | circle | pid | 3/3 |", self.call("table", "a")[0])
        self.assertIn("\\multirow", self.call("table", "a", "--format", "latex")[0])
        rows = list(csv.DictReader(self.call("table", "a", "--format", "csv")[0].splitlines()))
        cells = json.loads(self.call("table", "a", "--format", "json")[0])["cells"]
        self.assertEqual(len(rows), 2)
        for row, cell in zip(rows, cells):
            self.assertEqual(float(row["rmse_xy_m_mean"]), cell["rmse_xy_m"]["mean"])

    def test_one_flight_says_the_same_as_its_row_and_its_log(self):
        self.sweep("a")
        self.call("run", self.experiment, "--trajectory", "circle", "--controller", "pid", "--replicate", "2", "--out", "one")
        outcome = json.loads((self.folder / "one" / "outcome.json").read_text())
        row = list(csv.DictReader(self.runs("a").decode().splitlines()))[1]
        self.assertEqual(outcome["outcome"], row["outcome"])
        self.assertEqual(outcome["tracking"]["planar"]["rmse_m"], float(row["rmse_xy_m"]))
        self.assertEqual(outcome["tracking"]["planar"]["p95_m"], float(row["p95_xy_m"]))
        metrics = json.loads(self.call("metrics", "one/flight.csv", "--format", "json")[0])["logs"][0]
        self.assertEqual(metrics["planar"], outcome["tracking"]["planar"])
        self.assertEqual(metrics["spatial"], outcome["tracking"]["spatial"])
        settled = json.loads(self.call("metrics", "one/flight.csv", "--settle", "0.5", "--format", "json")[0])["logs"][0]
        self.assertEqual(settled["samples"], 250)


AXES = """
[[axis]]
key = "effect.gust.strength"
values = [0.5, 2.0]
[[axis]]
name = "period"
key = "trajectory.circle.period_s"
values = [5.0, 10.0]
"""


class Axes(Commands):
    def setUp(self):
        super().setUp()
        self.experiment.write_text(EXPERIMENT + AXES)

    def test_a_grid_is_one_runs_csv_and_one_table(self):
        self.sweep("a", "--jobs", "1")
        rows = list(csv.DictReader(self.runs("a").decode().splitlines()))
        self.assertEqual(len(rows), 4 * 6)
        self.assertEqual([(row["strength"], row["period"]) for row in rows[::6]], [("0.5", "5"), ("0.5", "10"), ("2", "5"), ("2", "10")])
        table = self.call("table", "a", "--columns", "rmse,p95")[0]
        self.assertIn("| strength | period | vehicle | trajectory | controller | completed | RMSE | P95 |", table)
        self.assertEqual(table.count("| crazyflie | circle | pid | 3/3 |"), 4)
        page = self.call("table", "a", "--format", "html")[0]
        for axis in (">strength [–]</text>", ">period [s]</text>"):
            self.assertIn(axis, page)
        self.assertEqual(self.call("table", "a", "--names", "pid=PID,strength=gust")[1], "")
        self.assertIn('this table has no pdi; did you mean "pid"?', self.call("table", "a", "--names", "pdi=PID")[1])
        self.refuse_to_call_two_alike()
        self.call("gate", "a", "--baseline", "base.csv", "--update")
        self.assertIn("passed", self.call("gate", "a", "--baseline", "base.csv")[0])

    def refuse_to_call_two_alike(self):
        for names, says in (("strength=period", "--names: two axes would be called period (period and strength); choose another name"),
                            ("period=x,strength=x", "two axes would be called x"), ("circle=hover", "two trajectories would be called hover (circle and hover)")):
            out, err = self.call("table", "a", "--names", names, code=2)
            self.assertEqual(out, "")
            self.assertIn(says, err)
        self.assertIn("| period | strength |", self.call("table", "a", "--names", "strength=period,period=strength")[0])

    @unittest.skipUnless(shutil.which("pdflatex"), "no pdflatex here: apt-get install texlive-latex-recommended texlive-latex-extra")
    def test_latex_of_a_grid_compiles(self):
        self.sweep("a")
        table = self.call("table", "a", "--format", "latex", "--columns", "rmse,p95,max", "--bold-best", "--names",
                          "pid=PID_{50 %} & ^~\\\\#$", "--label", "grid")[0]
        (self.folder / "paper.tex").write_text("\\documentclass[twocolumn]{article}\\usepackage{multirow}\\begin{document}\n"
                                               f"{table}Table~\\ref{{tab:grid}}\n\\end{{document}}\n")
        for _ in range(2):
            tex = subprocess.run(["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "paper.tex"], cwd=self.folder,
                                 capture_output=True, text=True, errors="replace", timeout=300)
            self.assertEqual(tex.returncode, 0, tex.stdout[-3000:])
        self.assertNotIn("undefined", tex.stdout)
        self.assertNotIn("Overfull", tex.stdout)

    def test_shards_and_threads_of_a_grid_are_the_same_bytes(self):
        self.sweep("one", "--jobs", "1")
        for part in (1, 2):
            self.sweep(f"part{part}", "--shard", f"{part}/2", "--jobs", "3")
        self.call("merge", "part2", "part1", "--out", "whole")
        self.assertEqual(self.runs("one"), self.runs("whole"))

    def test_one_point_flies_alone(self):
        self.sweep("a", "--variant", "strength_2_period_10")
        self.assertEqual(sorted(path.name for path in (self.folder / "a").iterdir()), ["runs.csv", "strength_2_period_10"])
        self.assertIn("| 2 | 10 |", self.call("table", "a")[0])
        _, err = self.sweep("a", "--variant", "strength_3", code=2)
        self.assertIn("there is no variant", err)

    def points(self, out):
        return {(row["strength"], row["period"]) for row in csv.DictReader(self.runs(out).decode().splitlines())}

    def test_points_that_are_flown_one_by_one_make_one_runs_csv(self):
        self.sweep("whole")
        for strength in ("0.5", "2"):
            for period in ("10", "5"):
                self.sweep("a", "--variant", f"strength_{strength}_period_{period}")
        self.assertEqual(self.runs("a"), self.runs("whole"))

    def test_a_point_that_is_not_finished_is_not_in_the_whole(self):
        self.sweep("a", "--variant", "strength_2_period_10")
        (self.folder / "a" / "strength_2_period_10" / "runs.csv").unlink()
        _, err = self.sweep("a", "--variant", "strength_2_period_5")
        self.assertIn("runs.csv is without strength_2_period_10 (not finished); go on with --resume", err)
        self.assertEqual(self.points("a"), {("2", "5")})
        self.sweep("a", "--variant", "strength_2_period_10", "--resume")
        self.assertEqual(self.points("a"), {("2", "5"), ("2", "10")})

    def refused(self, says, *arguments):
        before = {path: path.read_bytes() for path in sorted((self.folder / "a").rglob("*")) if path.is_file()}
        out, err = self.sweep("a", *arguments, code=2)
        self.assertEqual(out, "")
        self.assertIn(says, err)
        self.assertEqual({path: path.read_bytes() for path in sorted((self.folder / "a").rglob("*")) if path.is_file()}, before)

    def test_results_of_other_experiments_are_not_mixed(self):
        self.sweep("a")
        self.experiment.write_text(EXPERIMENT)  # without its axes
        self.refused("of a variant that this experiment does not have; use another --out")
        self.experiment.write_text(EXPERIMENT + AXES.replace("[5.0, 10.0]", "[5.0, 20.0]"))  # a point less
        self.refused("of a variant that this experiment does not have; use another --out", "--resume")
        shutil.rmtree(self.folder / "a" / "strength_2_period_10")
        self.experiment.write_text(EXPERIMENT.replace("duration_s = ", "duration_s = 1") + AXES)  # one point with other settings
        self.refused("this store is of another experiment", "--variant", "strength_2_period_10")
        shutil.rmtree(self.folder / "a")
        self.experiment.write_text(EXPERIMENT)
        self.sweep("a")
        self.experiment.write_text(EXPERIMENT + AXES)
        self.refused("of an experiment without variants; use another --out", "--resume")

    def test_a_merge_has_all_variants_or_writes_nothing(self):
        for shard in ("1", "2"):
            self.sweep("s" + shard, "--shard", f"{shard}/2")
        left = "strength_2_period_10"
        shutil.move(self.folder / "s1" / left, self.folder / "kept")  # as a shard that was ended early
        for order in (("s1", "s2"), ("s2", "s1")):
            _, err = self.call("merge", *order, "--out", "m", code=3)
            self.assertIn(f"s1/{left}: no results here", err)
            self.assertFalse((self.folder / "m").exists())
        shutil.move(self.folder / "kept", self.folder / "s1" / left)
        self.call("merge", "s1", "s2", "--out", "m")
        self.sweep("whole")
        self.assertEqual(self.runs("m"), self.runs("whole"))
        self.assertIn("there are results already", self.call("merge", "s1", "s2", "--out", "m", code=2)[1])

    # the whole of a sweep that was ended before a variant was that of the variants that it had begun
    def test_a_variant_that_no_shard_has_begun_is_missing(self):
        left = "strength_2_period_10"
        for shard in ("1", "2"):
            self.sweep("s" + shard, "--shard", f"{shard}/2")
            shutil.rmtree(self.folder / ("s" + shard) / left)
        _, err = self.call("merge", "s1", "s2", "--out", "m", code=3)
        self.assertRegex(err, r"^s1: 1 of \d+ variants are missing \(no shard has begun them\); go on with")
        self.assertFalse((self.folder / "m").exists())
        for shard in ("1", "2"):  # of a sweep that was asked for some of them these are all
            self.sweep("few" + shard, "--variant", left, "--shard", f"{shard}/2")
        self.call("merge", "few1", "few2", "--out", "m")

    # as a merge leaves it that is killed between two variants
    def test_a_merge_goes_on_with_the_variants_that_are_left(self):
        for shard in ("1", "2"):
            self.sweep("s" + shard, "--shard", f"{shard}/2")
        self.call("merge", "s1", "s2", "--out", "whole")
        shutil.copytree(self.folder / "whole", self.folder / "m")
        shutil.rmtree(self.folder / "m" / "strength_2_period_10")
        (self.folder / "m" / "runs.csv").unlink()
        scratch = self.folder / "m" / "strength_2_period_10" / f".gustlab.{2 ** 22}.0"  # of no process
        scratch.mkdir(parents=True)
        self.call("merge", "s1", "s2", "--out", "m")
        self.assertFalse(scratch.exists())
        self.assertEqual(self.runs("m"), self.runs("whole"))
        self.call("table", "m")

    def test_points_that_were_flown_alone_are_compared_alone(self):
        few = ["--variant", "strength_2_period_10", "--variant", "strength_2_period_5"]
        self.sweep("a", *few)
        text = self.call("compare", self.experiment, "a", *few)[0]
        self.assertIn("\n| strength_2_period_10 |", text)
        self.assertNotIn("strength_0.5", text)
        self.assertIn("no results here", self.call("compare", self.experiment, "a", code=3)[1])

    def test_results_of_another_experiment_are_not_compared(self):
        point = ["--variant", "strength_2_period_10"]
        self.sweep("a", *point, "--set", "replicates=2")
        for more, says in ((["--set", "replicates=2", "--seed", "2"], "seed = 1 there, seed = 2 here"),
                           (["--set", "replicates=2", "--set", "trajectory.circle.radius_m=1.2"],
                            "radius_m = 1.1 there, [trajectory.circle] radius_m = 1.2 here"),
                           (["--set", "replicates=2", "--set", "effect.gust.sigma_xy=0.04"],
                            "[[effect]] \"gust\" sigma_xy = 0.03 there, [[effect]] \"gust\" sigma_xy = 0.04 here"),
                           (["--set", "replicates=2", "--set", "name=other"],
                            "its name is small.strength_2_period_10 there, other.strength_2_period_10 here"),
                           ([], "replicates = 2 there, replicates = 3 here")):
            out, err = self.call("compare", self.experiment, "a", *point, *more, code=3)
            self.assertEqual(out, "")
            self.assertIn("runs.sqlite: these results are of another experiment", err)
            self.assertIn(says, err)
        self.call("compare", self.experiment, "a", *point, "--set", "replicates=2")

    def test_what_an_axis_sets_cannot_be_overridden(self):
        _, err = self.sweep("a", "--set", "effect.gust.strength=1", code=2)
        self.assertIn("its value would be lost", err)
        self.assertFalse((self.folder / "a").exists())


WINDS = """
[[variant]]
name = "north"
set = ["effect.gust.drift_x=0.02"]
[[variant]]
name = "west"
set = ["effect.gust.drift_y=0.02"]
"""


class CommandsThatFilesName(Commands):
    def again(self, text, file):
        """what the command that `text` names writes into `file`"""
        command = re.search(r"(gustlab (?:train|tune) [^`\n]*)", text)[1]
        subprocess.run(["bash", "-c", f"{command.replace('gustlab', shlex.quote(PROGRAM), 1)} --out again"], cwd=self.folder, check=True,
                       capture_output=True, timeout=600)
        return (self.folder / "again" / file if file else self.folder / "again").read_text()

    def test_weights_are_made_again_by_it(self):
        self.experiment.write_text(experiment_toml("circle", replicates=1, duration_s=4.0, more="seed = 3\n" + CIRCLE + GUST + WINDS))
        settings = ["--set", "controller.pid.position_gain=1.5", "--set", "duration_s = 5.0 # it's\n"]
        for k, more in enumerate(([], settings, [*settings, "--seed", "7"])):
            self.call("train", self.experiment, "--epochs", "2", *more, "--out", f"w{k}")
            text = (self.folder / f"w{k}").read_text()
            self.assertEqual(text, self.again(text, ""))
        self.assertIn("--set controller.pid.position_gain=1.5 --set ", text)
        self.assertIn(" --seed 7 --epochs 2", text)

    def test_gains_are_made_again_by_it(self):
        (self.folder / "own.toml").write_text(TUNING)
        self.call("tune", self.experiment, "--tuning", self.folder / "own.toml", "--set", "trajectories=circle", "--set", "duration_s = 0.5", "--seed", "5",
                  "--out", "a")
        text = (self.folder / "a" / "gains.toml").read_text()
        self.assertIn("`gustlab tune experiment.toml --set trajectories=circle --set 'duration_s = 0.5' --seed 5 --tuning own.toml`", text)
        self.assertEqual(text, self.again(text, "gains.toml"))

    def test_an_outcome_says_seed_and_settings(self):
        run = ["run", self.experiment, "--trajectory", "hover", "--controller", "pid"]
        self.call(*run, "--out", "a")
        self.call(*run, "--out", "b", "--seed", "9", "--set", "duration_s=0.5")
        outcomes = [json.loads((self.folder / name / "outcome.json").read_text()) for name in "ab"]
        self.assertEqual([(outcome["seed"], outcome["set"]) for outcome in outcomes], [(1, []), (9, ["duration_s=0.5"])])


class Gates(Commands):
    def test_gate_passes_on_itself_and_fails_on_worse(self):
        self.sweep("a")
        self.call("gate", "a", "--baseline", "base.csv", "--update")
        self.assertEqual((self.folder / "base.csv").read_bytes(), self.runs("a"))
        for rule in ("margin", "test", "both", "margin,test"):
            self.assertIn("passed", self.call("gate", "a", "--baseline", "base.csv", "--fails-by", rule)[0])
        self.sweep("worse", "--set", "controller.pid.position_gain=0.2")
        out, _ = self.call("gate", "worse", "--baseline", "base.csv", "--junit", "gate.xml", "--summary", "gate.md", code=1)
        self.assertIn("failed", out)
        self.assertEqual((self.folder / "gate.md").read_text(), out)
        self.assertIn("<failure", (self.folder / "gate.xml").read_text())

    def test_baseline_of_another_experiment_is_exit_3(self):
        self.sweep("a")
        self.call("gate", "a", "--baseline", "base.csv", "--update")
        self.sweep("b", "--set", "name=other")
        _, err = self.call("gate", "b", "--baseline", "base.csv", code=3)
        self.assertIn("wrong baseline: it is of small, the sweep of other", err)

    def test_baseline_that_is_broken_is_exit_3(self):
        self.sweep("a")
        (self.folder / "base.csv").write_text("a,b\n1,2\n")
        _, err = self.call("gate", "a", "--baseline", "base.csv", code=3)
        self.assertIn("base.csv:1:1", err)
        header, row = self.runs("a").decode().splitlines()[:2]
        for text, says in ((f"{header}\n", "base.csv:1:1: the baseline has no rows"),
                           (f"{header}\n{row}\n{row}\n", "base.csv:3:1: run small,crazyflie")):
            (self.folder / "base.csv").write_text(text)
            self.assertIn(says, self.call("gate", "a", "--baseline", "base.csv", code=3)[1])


if __name__ == "__main__":
    unittest.main()
