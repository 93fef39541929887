"""A disk that is full from any one write on: exit 4 with the reason, nothing half, and with room again the same bytes."""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts"))

from concealed_trials import FIRST_SET, trials_toml  # noqa: E402
from import_fixture import MAP, csv, flight  # noqa: E402
from small_experiments import GUST, TUNING, VARIANTS, calibration_toml, experiment_toml  # noqa: E402

PROGRAM = os.environ["GUSTLAB_PROGRAM"]
FULL = "No space left on device|database or disk is full|unable to open database file|disk I/O error"

EXPERIMENT = experiment_toml("circle", replicates=6, duration_s=0.2, more=GUST)
TRAINING = EXPERIMENT + VARIANTS
CALIBRATION = calibration_toml(replicates=1, evaluations=2)


class FullDisk(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.shared = Path(tempfile.mkdtemp(prefix="gustlab_test_"))
        cls.addClassCleanup(shutil.rmtree, cls.shared)
        subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", str(cls.shared / "full_disk.so"), str(Path(__file__).with_name("full_disk.c"))], check=True)

    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="gustlab_test_"))
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "e.toml").write_text(EXPERIMENT)

    def call(self, *arguments, full_from=None):
        """(exit code, stderr, writes)"""
        count = self.shared / "count"
        count.write_text("")
        # a driver's own cache is not the program's: without room it does without
        # compiled scripts are written by the first run alone
        more = {"MESA_SHADER_CACHE_DISABLE": "true", "PYTHONDONTWRITEBYTECODE": "1", "LD_PRELOAD": str(self.shared / "full_disk.so"),
                "FULL_DISK_COUNT": str(count), "FULL_DISK_FROM": str(full_from or 10**9),
                # of a build with the address sanitizer: it wants to be the first library
                "ASAN_OPTIONS": os.environ.get("ASAN_OPTIONS", "") + ":verify_asan_link_order=0"}
        done = subprocess.run([PROGRAM, *arguments], cwd=self.folder, text=True, capture_output=True, env=os.environ | more)
        return done.returncode, done.stderr, count.stat().st_size

    def sound(self, *arguments):
        code, err, writes = self.call(*arguments)
        self.assertEqual(code, 0, f"{arguments}\n{err}")
        return writes

    def files(self, folder="."):
        top = self.folder / folder
        return {str(path.relative_to(top)): path.read_bytes() for path in sorted(top.rglob("*")) if path.is_file()}

    def at_each_write(self, arguments, then, least=3):
        """Runs a command once for each of its writes (GUSTLAB_EVERY_WRITE), or for some of very many, with no room from that write on. What it writes are files
        or folders out…"""
        before = self.files()
        writes = self.sound(*arguments)
        wanted = self.files("out")
        self.assertGreaterEqual(writes, least)
        step = 1 if "GUSTLAB_EVERY_WRITE" in os.environ else 1 + writes // 6
        for number in sorted({1, writes, *range(1, writes + 1, step)}):
            for path in self.folder.glob("out*"):
                shutil.rmtree(path) if path.is_dir() else path.unlink()
            self.assertEqual(self.files(), before)
            with self.subTest(command=arguments[0], write=number, of=writes):
                code, err, _ = self.call(*arguments, full_from=number)
                self.assertNotIn("Traceback", err)
                then(number, code, err, before, wanted)

    def leaves_nothing(self, number, code, err, before, wanted):
        self.assertEqual(code, 4, err)
        self.assertRegex(err, FULL)
        self.assertEqual(self.files(), before)
        self.assertEqual(list(self.folder.glob("out*")), [])

    def test_sweep_goes_on_with_room(self):
        arguments = ("sweep", "e.toml", "--out", "out", "--jobs", "1")

        def goes_on(number, code, err, before, wanted):
            self.assertEqual(code, 4, err)
            self.assertRegex(err, FULL)
            self.assertFalse((self.folder / "out" / "runs.csv").exists())
            self.sound(*arguments, "--resume")
            self.assertEqual((self.folder / "out" / "runs.csv").read_bytes(), wanted["runs.csv"])
            self.assertEqual({name for name in self.files("out")}, set(wanted))

        self.at_each_write(arguments, goes_on)

    def test_sweep_with_logs_goes_on_with_room(self):
        arguments = ("sweep", "e.toml", "--set", "replicates=2", "--logs", "--out", "out", "--jobs", "1")

        def goes_on(number, code, err, before, wanted):
            self.assertEqual(code, 4, err)
            self.assertRegex(err, FULL)
            # each log is whole, with its sidecar, or not there
            for name, content in self.files("out").items():
                if not name.startswith("runs.sqlite"):
                    self.assertEqual(content, wanted[name], name)
                if name.endswith(".csv") and name != "runs.csv":
                    self.assertIn(name.replace(".csv", ".meta.toml"), self.files("out"))
            self.sound(*arguments, "--resume")
            found = self.files("out")
            self.assertEqual(set(found), set(wanted))
            self.assertEqual({n: c for n, c in found.items() if n != "runs.sqlite"}, {n: c for n, c in wanted.items() if n != "runs.sqlite"})

        self.at_each_write(arguments, goes_on)

    def test_merge_leaves_nothing(self):
        for part in ("1", "2"):
            self.sound("sweep", "e.toml", "--out", f"part{part}", "--shard", f"{part}/2")
        self.at_each_write(("merge", "part1", "part2", "--out", "out"), self.leaves_nothing)

    def test_merge_of_variants_goes_on_with_room(self):
        (self.folder / "v.toml").write_text(EXPERIMENT + VARIANTS)
        for part in ("1", "2"):
            self.sound("sweep", "v.toml", "--set", "replicates=2", "--out", f"part{part}", "--shard", f"{part}/2")
        arguments = ("merge", "part1", "part2", "--out", "out/whole")

        def goes_on(number, code, err, before, wanted):
            self.assertEqual(code, 4, err)
            self.assertRegex(err, FULL)
            for name, content in self.files("out").items():  # of variants that are whole
                self.assertEqual(content, wanted[name], name)
            if not self.files("out"):
                self.assertEqual(list(self.folder.glob("out*")), [])
            self.sound(*arguments)
            self.assertEqual(self.files("out"), wanted)

        self.at_each_write(arguments, goes_on)

    def fly(self, duration_s):
        self.sound("run", "e.toml", "--set", f"duration_s={duration_s}", "--trajectory", "circle", "--controller", "pid", "--out", "flown")

    def test_run_leaves_nothing(self):
        self.at_each_write(("run", "e.toml", "--trajectory", "circle", "--controller", "pid", "--out", "out"), self.leaves_nothing)

    def test_gate_leaves_nothing(self):
        self.sound("sweep", "e.toml", "--out", "swept", "--jobs", "1")
        self.at_each_write(("gate", "swept", "--baseline", "out.csv", "--update"), self.leaves_nothing, least=2)
        self.sound("gate", "swept", "--baseline", "base.csv", "--update")
        self.at_each_write(("gate", "swept", "--baseline", "base.csv", "--summary", "out.md", "--junit", "out.xml"), self.leaves_nothing)

    def test_calibration_goes_on_with_room(self):
        (self.folder / "c.toml").write_text(CALIBRATION)
        arguments = ("calibrate", "e.toml", "--calibration", "c.toml", "--out", "out", "--jobs", "1")

        def goes_on(number, code, err, before, wanted):
            self.assertEqual(code, 4, err)
            self.assertRegex(err, FULL)
            self.assertLessEqual(set(self.files("out")) if (self.folder / "out").exists() else set(), {"flown.jsonl"})
            self.sound(*arguments)
            self.assertEqual(self.files("out"), wanted)

        self.at_each_write(arguments, goes_on)

    def test_tuning_leaves_nothing(self):
        (self.folder / "t.toml").write_text(TUNING)
        self.at_each_write(("tune", "e.toml", "--tuning", "t.toml", "--out", "out", "--jobs", "1"), self.leaves_nothing)

    def test_models_leave_nothing(self):
        self.fly(10)
        self.at_each_write(("identify", "flown/flight.csv", "--lambda", "0", "--out", "out.toml"), self.leaves_nothing, least=2)
        (self.folder / "train.toml").write_text(TRAINING)
        self.at_each_write(("train", "train.toml", "--set", "duration_s=5", "--set", "replicates=1", "--epochs", "1", "--jobs", "1", "--out", "out.txt"),
                           self.leaves_nothing, least=2)

    def test_vehicle_leaves_nothing(self):
        self.at_each_write(("vehicle", "new", "--mass", "1.2kg", "--arm", "0.25m", "--prop", "10in", "--thrust-to-weight", "2.1", "--out", "out"),
                           self.leaves_nothing)
        rows = "".join(f"{t},{8 * t * t},{800 * t}\n" for t in (0.2, 0.4, 0.5, 0.6, 0.8, 1.0))
        (self.folder / "stand.csv").write_text("throttle,thrust_N,speed_radps\n" + rows)
        self.sound("vehicle", "new", "--mass", "1.2kg", "--arm", "0.25m", "--prop", "10in", "--thrust-to-weight", "2.1", "--out", "mine")
        self.at_each_write(("vehicle", "fit", "--thrust-stand", "stand.csv", "--vehicle", "mine/vehicle.toml", "--out", "out"), self.leaves_nothing)

    def test_exports_leave_nothing(self):
        self.fly(0.2)
        for more in (("--out", "out.parquet"), ("--out", "out.mcap"), ("--to", "csv", "--out", "out")):
            self.at_each_write(("export", "flown", *more), self.leaves_nothing, least=2)

    def test_films_leave_nothing(self):
        self.fly(1)
        # ffmpeg writes the other films: tests/scripts/test_flight_exports.py
        self.at_each_write(("render", "flown/flight.csv", "--size", "64x64", "--fps", "5", "--out", "out.gif"), self.leaves_nothing, least=1)

    def test_reproduce_goes_on_with_room(self):
        (self.folder / "e.toml").write_text(EXPERIMENT.replace("replicates = 6", "replicates = 2"))
        arguments = ("reproduce", "table2", "--experiment", "e.toml", "--out", "out", "--jobs", "1")

        def goes_on(number, code, err, before, wanted):
            self.assertEqual(code, 4, err)
            self.assertRegex(err, FULL)
            for name in ("reproduction.json", "reproduction.md", "figures/ours_against_paper.svg"):
                self.assertNotIn(name, self.files("out"))
            self.sound(*arguments)
            found = self.files("out")
            self.assertEqual({n: c for n, c in found.items() if not n.endswith(".sqlite")}, {n: c for n, c in wanted.items() if not n.endswith(".sqlite")})

        self.at_each_write(arguments, goes_on)

    def test_conceal_leaves_nothing(self):
        (self.folder / "t.toml").write_text(trials_toml("one", "two", duration_s=0.2))
        for jobs in ("1", "2"):
            self.at_each_write(("conceal", "t.toml", "--out", "out", "--answers", "out.jsonl", "--jobs", jobs), self.leaves_nothing)

    def test_diagnose_leaves_nothing(self):
        self.fly(2)
        self.at_each_write(("diagnose", "flown/flight.csv", "--out", "out", "--jobs", "1"), self.leaves_nothing)

    def test_a_batch_of_diagnoses_goes_on_with_room(self):
        (self.folder / "t.toml").write_text(trials_toml("one", duration_s=2.0))
        self.sound("conceal", "t.toml", "--out", "trials", "--answers", "answers.jsonl")
        (self.folder / "sets.toml").write_text(FIRST_SET)
        arguments = ("diagnose", "--batch", "sets.toml", "--jobs", "1", "--out", "out")

        def goes_on(number, code, err, before, wanted):
            self.assertEqual(code, 4, err)
            self.assertRegex(err, FULL)
            for name, content in self.files("out").items():
                self.assertEqual(content, wanted[name])
            self.sound(*arguments)
            self.assertEqual(self.files("out"), wanted)

        self.at_each_write(arguments, goes_on)

    def test_import_leaves_nothing(self):
        (self.folder / "map.toml").write_text(MAP)
        (self.folder / "log.csv").write_text(csv(flight(8.0)))
        self.at_each_write(("import", "log.csv", "--map", "map.toml", "--out", "out"), self.leaves_nothing)


if __name__ == "__main__":
    unittest.main()
