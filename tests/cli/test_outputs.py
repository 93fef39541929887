"""Where outputs go: devices and links stay what they are, nothing of others is lost, errors leave nothing half."""

import json
import os
import re
import shutil
import signal
import stat
import subprocess
import tempfile
import time
import tomllib
import unittest
from pathlib import Path

import pytest
from concealed_trials import trials_toml
from processes import catches, wait_for
from small_experiments import CIRCLE, GUST, TUNING, VARIANTS, calibration_toml, experiment_toml

PROGRAM = os.environ["GUSTLAB_PROGRAM"]
MODELS = Path(__file__).resolve().parents[2] / "models"
PX4_LOG = str(Path(__file__).resolve().parents[1] / "data" / "logs" / "px4_sitl_jmavsim.ulg")

EXPERIMENT = experiment_toml("hover", duration_s=1.0)
TRAINING = experiment_toml("circle", duration_s=5.0, more=VARIANTS)


class Commands(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.shared = Path(tempfile.mkdtemp(prefix="gustlab_test_"))
        cls.addClassCleanup(shutil.rmtree, cls.shared)
        (cls.shared / "e.toml").write_text(EXPERIMENT)
        (cls.shared / "t.toml").write_text(trials_toml("nothing"))
        (cls.shared / "train.toml").write_text(TRAINING)
        for command in (["sweep", "e.toml", "--out", "swept"], ["run", "e.toml", "--trajectory", "hover", "--controller", "pid", "--out", "flown"],
                        ["gate", "swept", "--baseline", "base.csv", "--update"],
                        ["conceal", "t.toml", "--out", "trials", "--answers", "answers.jsonl"]):
            subprocess.run([PROGRAM, *command], cwd=cls.shared, check=True, capture_output=True)

    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="gustlab_test_"))
        self.addCleanup(shutil.rmtree, self.folder)
        shutil.copytree(self.shared, self.folder, dirs_exist_ok=True)

    def call(self, *arguments, code=0, **options):
        done = subprocess.run([PROGRAM, *arguments], cwd=self.folder, text=True, timeout=120,
                              **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options})
        self.assertEqual(done.returncode, code, f"{arguments}\n{done.stdout}\n{done.stderr}")
        return done.stdout, done.stderr

    def files(self):
        return {str(path.relative_to(self.folder)): path.read_bytes() for path in sorted(self.folder.rglob("*")) if path.is_file()}

    GATE = ("gate", "swept", "--baseline", "base.csv")

    def assert_ends_soon(self, process, number):
        """with 130, and less than a second of work after the signal"""
        before = work_s(process.pid)
        process.send_signal(number)
        err = process.stderr.read()
        process.stdout.close()
        process.stderr.close()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        self.assertEqual(process.returncode, 130, err)
        self.assertLess(usage.ru_utime + usage.ru_stime - before, 1.0)


class Places(Commands):
    def test_a_pipe_is_written_through(self):
        pipe = self.folder / "pipe"
        os.mkfifo(pipe)
        read = []
        # a reader that does not wait for a writer for ever
        end = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
        out, _ = self.call(*self.GATE, "--summary", "pipe")
        read.append(os.read(end, 65536).decode())
        os.close(end)
        self.assertTrue(stat.S_ISFIFO(pipe.stat().st_mode))
        self.assertEqual(read, [out])

    @unittest.skipUnless(os.geteuid() == 0, "only root makes devices")
    # the link of an open pipe leads nowhere by its name
    def test_stdout_and_pipes_of_the_shell_are_written_through(self):
        shell = 'set -o pipefail; "$0" gate swept --baseline base.csv -q'
        wanted = self.call(*self.GATE)[0]
        for words in ("--summary /dev/stdout | cat", "--summary /dev/fd/1 | cat", "--summary /dev/stdout > both; cat both"):
            with self.subTest(words):
                done = subprocess.run(["bash", "-c", f"{shell} {words}", PROGRAM], cwd=self.folder, text=True, capture_output=True)
                self.assertEqual((done.returncode, done.stdout), (0, 2 * wanted), done.stderr)
        done = subprocess.run(["bash", "-c", f"{shell} --summary >(cat > piped; echo > end) > out; until [[ -e end ]]; do sleep 0.1; done", PROGRAM],
                              cwd=self.folder, text=True, capture_output=True, timeout=60)
        self.assertEqual((done.returncode, (self.folder / "piped").read_text()), (0, wanted), done.stderr)

    def test_a_device_is_written_through(self):
        for name, number, code in (("null", 3, 0), ("full", 7, 4)):
            device = self.folder / name
            os.mknod(device, stat.S_IFCHR | 0o666, os.makedev(1, number))
            for command in ((*self.GATE, "--summary", name), (*self.GATE, "--junit", name), ("train", "train.toml", "--epochs", "1", "--out", name),
                            ("conceal", "t.toml", "--out", "again", "--answers", name)):
                with self.subTest(command=command):
                    self.call(*command, code=code)
                    self.assertTrue(stat.S_ISCHR(device.stat().st_mode))
                    shutil.rmtree(self.folder / "again", ignore_errors=True)

    def test_a_link_stays_one_and_its_file_is_replaced(self):
        (self.folder / "there").mkdir()
        (self.folder / "there" / "real.md").write_text("old")
        (self.folder / "there" / "real.md").chmod(0o640)
        for name, target in (("link.md", "there/real.md"), ("hanging.md", "there/new.md")):
            (self.folder / name).symlink_to(target)
            out, _ = self.call(*self.GATE, "--summary", name)
            self.assertTrue((self.folder / name).is_symlink())
            self.assertEqual((self.folder / target).read_text(), out)
        self.assertEqual(stat.S_IMODE((self.folder / "there" / "real.md").stat().st_mode), 0o640)

    def test_a_link_to_a_folder_that_is_not_there_stays_one_and_its_folder_is_made(self):
        flight = "trials/nothing/fit_1.csv"
        for command in (["sweep", "e.toml"], ["run", "e.toml", "--trajectory", "hover", "--controller", "pid"], ["merge", "swept"],
                        ["conceal", "t.toml", "--answers", "x"], ["diagnose", flight], ["vehicle", "new", "--mass", "1kg", "--arm", "0.2m", "--hover", "0.5"]):
            for out in ("link", "link/sub"):
                with self.subTest(command=command, out=out):
                    (self.folder / "link").symlink_to("there/new")
                    self.call(*command, "--out", out)
                    self.assertTrue((self.folder / "link").is_symlink())
                    self.assertTrue(any((self.folder / "there" / "new" / out[5:]).iterdir()))
                    shutil.rmtree(self.folder / "there")
                    (self.folder / "link").unlink()

    def test_minus_is_stdout(self):
        out, _ = self.call(*self.GATE, "--junit", "-")
        self.assertTrue(out.startswith("<?xml"), out)
        self.assertFalse((self.folder / "-").exists())

    def test_links_in_a_circle_are_an_error_with_their_name(self):
        (self.folder / "a").symlink_to("b")
        (self.folder / "b").symlink_to("a")
        self.assertIn("a: cannot write", self.call(*self.GATE, "--summary", "a", code=2)[1])
        self.assertIn("a: cannot read", self.call("gate", "swept", "--baseline", "a", code=3)[1])

    def test_a_name_that_is_too_long_is_a_wrong_path(self):
        name, kept = "x" * 300, self.files()
        for command in (["run", "e.toml", "--trajectory", "hover", "--controller", "pid"], ["sweep", "e.toml"], ["merge", "swept"],
                        ["diagnose", "trials/nothing/fit_1.csv"], ["vehicle", "new", "--mass", "1kg", "--arm", "0.2m", "--hover", "0.5"]):
            with self.subTest(command=command):
                _, err = self.call(*command, "--out", name, code=2)
                self.assertRegex(err, f"{name}.*File name too long.*; name another\n$")
                self.assertEqual(self.files(), kept)
        for command in (["table", name], ["table", name, "--format", "html"], ["gate", name, "--baseline", "base.csv"], ["compare", "e.toml", name],
                        ["score", "answers.jsonl", name], ["merge", name, "--out", "new"]):
            with self.subTest(command=command):
                self.assertEqual(self.call(*command, code=3)[1], f"{name}: cannot read (File name too long)\n")
                self.assertEqual(self.files(), kept)

    def test_a_file_where_a_folder_should_be_is_a_wrong_path(self):
        (self.folder / "FILE").write_text("mine")
        flight, kept = "flown/flight.csv", self.files()
        into_folder = (["sweep", "e.toml"], ["run", "e.toml", "--trajectory", "hover", "--controller", "pid"], ["merge", "swept"],
                       ["reproduce", "table2"], ["calibrate", "table1_iris"], ["tune", "fair_link"],
                       ["conceal", "t.toml", "--answers", "x"], ["diagnose", "trials/nothing/fit_1.csv"],
                       ["vehicle", "new", "--mass", "1kg", "--arm", "0.2m", "--hover", "0.5"], ["import", "log.csv", "--map", "nanodrone"],
                       ["vehicle", "fit", "trials/nothing/fit_1.csv"], ["export", flight, "--to", "csv"])
        into_file = (["train", "train.toml", "--epochs", "1"], ["identify", flight], ["export", flight, "--to", "parquet"], ["export", flight, "--to", "mcap"],
                     ["render", flight])
        for command, out in [*((c, o) for c in into_folder for o in ("FILE", "FILE/sub", "FILE/sub/deep")),
                             *((c, o) for c in into_file for o in ("FILE/sub.mp4", "FILE/sub/deep.mp4"))]:
            with self.subTest(command=command, out=out):
                _, err = self.call(*command, "--out", out, code=2)
                self.assertIn(out, err)
                self.assertRegex(err, r"FILE is a file, not a folder")
                self.assertEqual(err.count("\n"), 1, err)
                self.assertEqual(self.files(), kept)

    def test_a_file_of_results_names_their_folder(self):
        for command in (["table"], ["gate", "--baseline", "base.csv"], ["merge", "--out", "whole"]):
            for file, says in (("swept/runs.csv", 'did you mean "swept"?'), ("swept/runs.sqlite", 'did you mean "swept"?'), ("flown/flight.csv", "name the folder"), ("base.csv", "name the folder")):
                err = self.call(*command, file, code=3)[1]
                self.assertIn(f"{file}: is a file, not a folder of results; {says}", err)

    def test_a_folder_where_a_file_should_be_is_a_wrong_path(self):
        (self.folder / "sub.mp4").mkdir()
        flight = "flown/flight.csv"
        for command in (["train", "train.toml", "--epochs", "1"], ["identify", flight], ["export", flight, "--to", "mcap"], ["render", flight]):
            with self.subTest(command=command):
                self.assertIn("sub.mp4: ", self.call(*command, "--out", "sub.mp4", code=2)[1])

    def test_files_with_names_of_old_temporary_files_are_left_alone(self):
        for name in ("out.md.part", "m.toml.part"):
            (self.folder / name).write_text("mine")
        (self.folder / "dg.new").mkdir()
        (self.folder / "dg.new" / "mine").write_text("mine")
        self.call(*self.GATE, "--summary", "out.md")
        self.call("conceal", "t.toml", "--out", "again", "--answers", "m.toml")
        self.call("diagnose", "trials/nothing/fit_1.csv", "trials/nothing/fit_2.csv", "--out", "dg")
        for name in ("out.md.part", "m.toml.part", "dg.new/mine"):
            self.assertEqual((self.folder / name).read_text(), "mine")


class Trials(Commands):
    def test_conceal_goes_on_beside_what_a_killed_one_left(self):
        ended = subprocess.Popen(["true"])
        ended.wait()
        place = self.folder / "trials" / "nothing"
        left, running, other = place / f".gustlab.{ended.pid}.3", place / f".gustlab.{os.getpid()}.0", place / ".gustlab.mine"
        for path in (left, running, other):
            path.write_text("time_s,px\n0,")
        again = ["conceal", "t.toml", "--out", "trials", "--answers", "answers.jsonl"]
        self.assertIn(".gustlab.mine: is there already", self.call(*again, code=2)[1])
        other.unlink()
        self.call(*again)
        self.assertFalse(left.exists())
        self.assertTrue(running.exists())

    def test_diagnose_says_at_once_that_its_folder_cannot_be_made(self):
        before = self.files()
        for flight in ("nowhere.csv", "trials/nothing/fit_1.csv"):
            done = subprocess.run([PROGRAM, "diagnose", flight, "--out", "/proc/x"], cwd=self.folder, capture_output=True, text=True, timeout=60)
            self.assertIn(done.returncode, (2, 4))   # not everybody is root
            self.assertIn("/proc/x: cannot make this folder", done.stderr)
        self.assertEqual(self.files(), before)

    # score counted what was diagnosed of other recordings
    def test_conceal_leaves_no_old_diagnosis_beside_new_recordings(self):
        self.call("conceal", "t.toml", "--out", "trials", "--answers", "answers.jsonl")   # the same once more
        for name in ("diagnosis", "fit_9.csv"):
            (self.folder / "trials" / "nothing" / name).mkdir()
            before = self.files()
            _, err = self.call("conceal", "t.toml", "--out", "trials", "--answers", "answers.jsonl", "--set", "seed=7", code=2)
            self.assertIn(f"trials/nothing/{name}: is there already (it would be taken for a part of this trial)", err)
            self.assertEqual(self.files(), before)
            (self.folder / "trials" / "nothing" / name).rmdir()


class Models(Commands):
    def test_a_diagnosis_without_names_writes_a_model_that_replay_takes(self):
        _, err = self.call("diagnose", "trials/nothing/fit_1.csv", "trials/nothing/fit_2.csv", "--out", "dg")
        self.assertIn("fit_2.csv: is a copy of fit_1.csv: set aside", err)
        self.assertNotIn("set aside: is a copy", err)
        model = self.folder / "dg" / "augmented.toml"
        self.assertEqual(json.loads((model.parent / "diagnosis.json").read_text(encoding="utf-8"))["effects"], [])
        self.assertIn("with effects", self.call("replay", "trials/nothing/fit_1.csv", "--with", str(model))[0])

    # a habit's errors stood as those of physics
    def test_a_habit_of_the_recorded_loop_is_called_one(self):
        mass = '[[effect]]\ntype = "mass"\ndelta = 0.002\n'
        (self.folder / "mass.toml").write_text(mass)
        (self.folder / "habit.toml").write_text(mass + '[[effect]]\ntype = "recorded_loop"\nroll = [-20.0, 0, 0, 0, 90.0, 0, 0, 0]\n')
        replay = ["replay", "trials/nothing/fit_1.csv", "--format", "json", "--with"]
        (physics, quiet), (habit, err) = (self.call(*replay, name) for name in ("mass.toml", "habit.toml"))
        self.assertEqual(quiet, "")
        self.assertIn("holds the habit of the recorded loop (recorded_loop), which is no physics", err)
        physics, habit = json.loads(physics), json.loads(habit)
        for quantity in ("position_m", "attitude_rad"):
            self.assertNotIn("after_physics", physics[quantity])
            self.assertEqual(habit[quantity]["after_physics"], physics[quantity]["after"])
            self.assertNotEqual(habit[quantity]["after"], physics[quantity]["after"])


class Inputs(Commands):
    # one diagnosis was made of two vehicles, with the numbers of the first
    def test_flights_of_two_vehicles_are_refused(self):
        for folder in ("one", "same", "other"):
            shutil.copytree(self.folder / "trials" / "nothing", self.folder / folder)
            shutil.copytree(MODELS / "crazyflie", self.folder / folder / "vehicle")
            for sidecar in (self.folder / folder).glob("*.meta.toml"):
                sidecar.write_text(re.sub('vehicle = ".*"', 'vehicle = "vehicle/vehicle.toml"', sidecar.read_text()))
        vehicle = self.folder / "other" / "vehicle" / "vehicle.toml"
        vehicle.write_text(vehicle.read_text() + "# after a crash\n")
        for command in (["diagnose", "one/fit_1.csv", "other/fit_2.csv", "--out", "dg"], ["identify", "one/fit_1.csv", "other/fit_2.csv"], ["replay", "one/fit_1.csv", "other/fit_2.csv"],
                        ["diagnose", "one/fit_1.csv", "--holdout", "other/fit_2.csv", "--out", "dg"],
                        ["diagnose", "one/fit_1.csv", "--reference", "other/fit_2.csv", "--out", "dg"]):
            out, err = self.call(*command, code=3)
            self.assertEqual(out, "")
            self.assertRegex(err, r"one/fit_1\.csv and other/fit_2\.csv are flights of two vehicles \(one/.*other/.*\), and one model is")
        self.assertFalse((self.folder / "dg").exists())
        self.call("replay", "one/fit_1.csv", "same/fit_2.csv")
        self.call("replay", "one/fit_1.csv", "other/fit_2.csv", "--vehicle", "one/vehicle")

    def test_an_input_is_never_written_over(self):
        log = "flown/flight.csv"
        (self.folder / "hard").hardlink_to(self.folder / log)
        (self.folder / "soft").symlink_to(log)
        for arguments in (["identify", log, "--out", log], ["identify", log, "--out", "hard"], ["identify", log, "--out", "soft"],
                          ["identify", log, "--out", "flown/flight.meta.toml"], ["conceal", "t.toml", "--out", "x", "--answers", "t.toml"],
                          [*self.GATE, "--junit", "base.csv"], [*self.GATE, "--summary", "swept/runs.sqlite"],
                          [*self.GATE, "--junit", "swept/runs.csv"],
                          ["gate", "swept", "--baseline", "swept/runs.sqlite", "--update"],
                          ["train", "train.toml", "--epochs", "1", "--out", "train.toml"]):
            before = self.files()
            with self.subTest(arguments=arguments):
                _, err = self.call(*arguments, code=2)
                self.assertIn("is an input of this command", err)
                self.assertEqual(self.files(), before)


    def test_what_a_new_baseline_has_no_use_for_is_refused(self):
        before = self.files()
        for option in (["--junit", "j"], ["--junit", "base.csv"], ["--summary", "s"], ["--margin", "0.1"], ["--level", "0.1"], ["--floor", "1"],
                       ["--fails-by", "test"], ["--allow-extra"]):
            with self.subTest(option=option):
                _, err = self.call(*self.GATE, "--update", *option, code=2)
                self.assertEqual(err, f"{option[0]}: --update has no use for it (it is for a comparison); leave it out\n")
                self.assertEqual(self.files(), before)

    def test_one_file_for_two_outputs_is_refused(self):
        before = self.files()
        for arguments in ([*self.GATE, "--junit", "j", "--summary", "./j"],
                          ["conceal", "t.toml", "--out", "trials", "--answers", "trials/nothing/fit_1.csv"]):
            with self.subTest(arguments=arguments):
                self.assertIn("would be written twice", self.call(*arguments, code=2)[1])
                self.assertEqual(self.files(), before)

    def test_a_folder_for_the_recordings_is_no_file_for_the_answers(self):
        before = self.files()
        self.assertIn("is the folder of the recordings", self.call("conceal", "t.toml", "--out", "new", "--answers", "./new", code=2)[1])
        self.assertEqual(self.files(), before)

    def test_an_input_as_an_output_is_refused_before_the_work(self):
        (self.folder / "c.toml").write_text(calibration_toml(replicates=4, evaluations=1000000))
        (self.folder / "c").mkdir()
        (self.folder / "c" / "values.txt").hardlink_to(self.folder / "e.toml")
        self.assertIn("is an input", self.call("calibrate", "e.toml", "--calibration", "c.toml", "--out", "c", code=2)[1])
        (self.folder / "r").mkdir()
        (self.folder / "r" / "reproduction.md").hardlink_to(self.folder / "e.toml")
        self.assertIn("is an input", self.call("reproduce", "table2", "--experiment", "e.toml", "--out", "r", code=2)[1])
        self.assertEqual([path.name for path in (self.folder / "r").iterdir()], ["reproduction.md"])


class Failures(Commands):
    def test_stdout_that_is_full_is_exit_4(self):
        for arguments in (["table", "swept"], self.GATE, ["list"], ["defaults", "pid"], ["--help"], ["--version"], ["metrics", "flown/flight.csv"],
                          ["sweep", "e.toml", "--dry-run"], ["identify", "flown/flight.csv"], ["vehicle", "check", "crazyflie"], ["completion", "bash"], ["man"],
                          ["table", "swept", "--format", "json"], ["score", "answers.jsonl", "trials"],
                          ["import", "--help"], ["import", PX4_LOG], ["export", "--help"], ["render", "--help"], ["replay", "trials/nothing/fit_1.csv"], ["gate", "swept", "--baseline", "base.csv", "--summary", "-"]):
            with self.subTest(arguments=arguments), open("/dev/full", "w") as full:
                _, err = self.call(*arguments, code=4, stdout=full)
                self.assertIn("No space left on device", err)
                self.assertEqual(err.count("\n"), 1, err)

    # the program aborted where it could not say what is wrong
    @unittest.skipUnless(os.path.exists("/dev/full"), "there is no full device")
    def test_stderr_that_is_full_changes_no_exit_code(self):
        for arguments, code in ((["table", "nothere"], 3), (["sweep", "nothere.toml", "--out", "s"], 2), (["fly"], 2), (["table", "--nothing"], 2), (["table", "swept"], 0)):
            with self.subTest(arguments=arguments), open("/dev/full", "w") as full:
                self.call(*arguments, code=code, stderr=full)

    @unittest.skipUnless(os.path.ismount("/dev/pts"), "there are no pseudo-terminals")
    def test_a_terminal_that_goes_away_ends_no_long_work(self):
        terminal, seen = os.openpty()
        process = subprocess.Popen([PROGRAM, "train", "train.toml", "--epochs", "1000000", "--out", "w"], cwd=self.folder, stderr=seen)
        os.close(seen)
        self.assertTrue(os.read(terminal, 1))  # its first line
        os.close(terminal)
        time.sleep(1.5)  # for the next
        process.terminate()
        self.assertEqual(process.wait(timeout=120), 130)

    @unittest.skipUnless(os.path.exists("/dev/full"), "there is no full device")
    def test_a_merge_that_fails_leaves_nothing(self):
        # a file-size limit stands for a disk that fills up at any of its writes
        self.call("sweep", "e.toml", "--set", "replicates=40", "--out", "one", "--shard", "1/2")
        self.call("sweep", "e.toml", "--set", "replicates=40", "--out", "two", "--shard", "2/2")
        before = self.files()
        self.call("merge", "one", "two", "--out", "there")
        size = (self.folder / "there" / "runs.sqlite").stat().st_size
        shutil.rmtree(self.folder / "there")
        for limit in range(4096, size, 4096):
            with self.subTest(limit=limit):
                self.call("merge", "one", "two", "--out", "whole", code=4, preexec_fn=lambda: limit_file_size(limit))
                self.assertEqual(self.files(), before)
                self.assertFalse((self.folder / "whole").exists())
        self.call("merge", "one", "two", "--out", "whole")

    def test_a_diagnosis_that_cannot_be_written_leaves_nothing(self):
        arguments = ["diagnose", "trials/nothing/fit_1.csv", "trials/nothing/fit_2.csv", "--jobs", "1", "--out", "dg"]
        before = self.files()
        self.call(*arguments, code=4, preexec_fn=lambda: limit_file_size(4096))
        self.assertEqual(self.files(), before)
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), sorted(path.name for path in self.shared.iterdir()))


def limit_file_size(size):
    import resource
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


class Signals(Commands):
    LONG = {
        "train": ["train", "train.toml", "--epochs", "1000000", "--out", "w"],
        "conceal": ["conceal", "t.toml", "--set", "duration_s=5000", "--out", "x", "--answers", "y", "--jobs", "1"],
        "diagnose": ["diagnose", "trials/nothing/fit_1.csv", "trials/nothing/fit_2.csv", "--out", "dg", "--jobs", "1"],
        "bench": ["bench", "--rounds", "1000"],
        "replay": ["replay", *(f"again_{i}.csv" for i in range(40)), "--stride", "1", "--jobs", "1"],  # half a minute
        "metrics": ["metrics", *(f"again_{i}.csv" for i in range(40))],
        "merge": ["merge", "one", "two", "--out", "whole"],  # of 20 000 runs
        "identify": ["identify", "trials/nothing/fit_1.csv", "--optimizer", "sr3", "--max-iterations", "1000000000", "--tolerance", "1e-300", "--lambda", "1"],
        "vehicle fit": ["vehicle", "fit", "trials/nothing/fit_1.csv", "--out", "v", "--jobs", "1"],
        "vehicle new": ["vehicle", "new", "--mass", "1kg", "--from-log", "pipe", "--out", "v"],  # its script waits for the pipe
    }

    def test_each_signal_ends_each_command_with_130_and_no_output(self):
        os.mkfifo(self.folder / "pipe")
        for part, out in (("1/2", "one"), ("2/2", "two")):
            self.call("sweep", "e.toml", "--set", "replicates=20000", "--set", "duration_s=0.004", "--shard", part, "--out", out)
        for i in range(40):
            for ending in ("csv", "meta.toml"):
                os.link(self.folder / f"trials/nothing/fit_1.{ending}", self.folder / f"again_{i}.{ending}")
        before = self.files()
        for name, arguments in self.LONG.items():
            for number in (signal.SIGTERM, signal.SIGINT, signal.SIGUSR1, signal.SIGHUP):
                with self.subTest(command=name, signal=number):
                    process = subprocess.Popen([PROGRAM, *arguments], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                               preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL))
                    # the handler is there at once; without one the signal is the default
                    wait_for(lambda: process.poll() is not None or catches(process.pid, number), 10.0)
                    process.send_signal(number)
                    _, err = process.communicate(timeout=120)
                    self.assertEqual(process.returncode, 130, err)
                    self.assertEqual(self.files(), before)

    # run had no handler at all; conceal and train flew to the end of a flight of hours
    @pytest.mark.slow
    def test_a_flight_and_the_writing_of_its_log_end_soon(self):
        (self.folder / "long.toml").write_text(experiment_toml("circle", duration_s=5000.0, more=CIRCLE + GUST))
        (self.folder / "winds.toml").write_text(experiment_toml("circle", duration_s=5000.0, more=CIRCLE + GUST + VARIANTS))
        before = self.files()
        beside = lambda: any(self.folder.rglob(".gustlab.*.*"))  # noqa: E731
        for command, writing in ((["run", "long.toml", "--out", "out"], False), (["run", "long.toml", "--out", "out"], True),
                                 (["conceal", "t.toml", "--set", "duration_s=5000", "--out", "out", "--answers", "y", "--jobs", "1"], False),
                                 (["conceal", "t.toml", "--set", "duration_s=1000", "--out", "out", "--answers", "y", "--jobs", "1"], True),
                                 (["train", "winds.toml", "--out", "out", "--jobs", "1"], False)):
            for number in (signal.SIGTERM, signal.SIGINT, signal.SIGUSR1):
                with self.subTest(command=command[0], writing=writing, signal=number):
                    process = subprocess.Popen([PROGRAM, *command], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
                    under_way = beside if writing else lambda: work_s(process.pid) > 0.2
                    wait_for(lambda: process.poll() is not None or under_way(), 120.0)
                    self.assert_ends_soon(process, number)
                    self.assertEqual(self.files(), before)
                    self.assertFalse((self.folder / "out").exists())

    def test_a_signal_that_nohup_ignores_stays_ignored(self):
        process = subprocess.Popen([PROGRAM, "train", "train.toml", "--epochs", "1000000", "--out", "w"], cwd=self.folder, stderr=subprocess.DEVNULL,
                                   preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
        wait_for(lambda: catches(process.pid, signal.SIGTERM), 10.0)
        self.assertFalse(catches(process.pid, signal.SIGHUP))
        process.terminate()
        self.assertEqual(process.wait(timeout=120), 130)


class Searches(Commands):
    """tune and calibrate, in the middle of a flight of an hour"""

    def test_a_search_ends_within_a_second_of_work(self):
        (self.folder / "long.toml").write_text(experiment_toml("circle", duration_s=3600.0, more=CIRCLE + GUST))
        (self.folder / "c.toml").write_text(calibration_toml(replicates=4, evaluations=100))
        (self.folder / "s.toml").write_text(TUNING)
        for command in (["tune", "long.toml", "--tuning", "s.toml"], ["calibrate", "long.toml", "--calibration", "c.toml"]):
            for number in (signal.SIGTERM, signal.SIGINT, signal.SIGUSR1):
                with self.subTest(command=command[0], signal=number):
                    process = subprocess.Popen([PROGRAM, *command, "--out", "out", "--jobs", "2"], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
                    until = time.monotonic() + 120.0
                    while process.poll() is None and work_s(process.pid) < 1.0 and time.monotonic() < until:
                        time.sleep(0.01)
                    self.assert_ends_soon(process, number)
                    shutil.rmtree(self.folder / "out", ignore_errors=True)


def work_s(pid):
    """seconds of processor time that a process has taken"""
    numbers = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(numbers[11]) + int(numbers[12])) / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    unittest.main()
