"""Outputs and signals of the commands that Python scripts run: they are those of the other commands (test_outputs.py)."""

import os
import random
import shutil
import signal
import stat
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import pytest
from processes import catches, wait_for
from small_experiments import experiment_toml

PROGRAM = os.environ["GUSTLAB_PROGRAM"]
PX4_LOG = str(Path(__file__).resolve().parents[1] / "data" / "logs" / "px4_sitl_jmavsim.ulg")
SMALL = ("--size", "64x64", "--fps", "5")
EXPORT, RENDER = ("export", "flown", "--out"), ("render", "flown", *SMALL, "--out")
WRITERS = ((EXPORT, "x.mcap"), (EXPORT, "x.parquet"), (RENDER, "x.gif"), (RENDER, "x.mp4"))


class Commands(unittest.TestCase):
    bytes_of = {}  # of a name

    @classmethod
    def setUpClass(cls):
        cls.shared = Path(tempfile.mkdtemp(prefix="gustlab_test_"))
        cls.addClassCleanup(shutil.rmtree, cls.shared)
        (cls.shared / "e.toml").write_text(experiment_toml("hover", duration_s=1.0))
        subprocess.run([PROGRAM, "run", "e.toml", "--trajectory", "hover", "--controller", "pid", "--out", "flown"], cwd=cls.shared,
                       check=True, capture_output=True)

    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="gustlab_test_"))
        self.addCleanup(shutil.rmtree, self.folder)
        shutil.copytree(self.shared, self.folder, dirs_exist_ok=True)

    def call(self, *arguments, code=0):
        done = subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, timeout=120)
        self.assertEqual(done.returncode, code, f"{arguments}\n{done.stderr}")
        return done.stdout, done.stderr.decode()

    def written(self, command, name):
        """the bytes that a command writes into a file"""
        if name not in self.bytes_of:
            self.call(*command, name)
            self.bytes_of[name] = (self.folder / name).read_bytes()
            (self.folder / name).unlink()
        return self.bytes_of[name]

    def names(self):
        return sorted(path.name for path in self.folder.iterdir())


class Places(Commands):
    def test_a_pipe_is_written_through(self):
        for command, name in WRITERS:
            with self.subTest(name=name):
                wanted = self.written(command, name)
                os.mkfifo(self.folder / name)
                with open(self.folder / "read", "wb") as read, subprocess.Popen(["cat", name], cwd=self.folder, stdout=read) as reader:
                    self.call(*command, name)
                    reader.wait(timeout=10)
                self.assertEqual((self.folder / "read").read_bytes(), wanted)
                self.assertTrue(stat.S_ISFIFO((self.folder / name).stat().st_mode))
                (self.folder / name).unlink()

    @unittest.skipUnless(os.geteuid() == 0, "only root makes devices")
    def test_a_device_is_written_through(self):
        for number, code in ((3, 0), (7, 4)):
            for command, name in WRITERS:
                with self.subTest(name=name, code=code):
                    os.mknod(self.folder / name, stat.S_IFCHR | 0o666, os.makedev(1, number))
                    _, err = self.call(*command, name, code=code)
                    self.assertEqual(err.strip(), "" if code == 0 else f"{name}: cannot be written (No space left on device)")
                    self.assertTrue(stat.S_ISCHR((self.folder / name).stat().st_mode))
                    (self.folder / name).unlink()

    @pytest.mark.slow
    def test_a_link_stays_one_and_its_file_is_replaced(self):
        for command, name in WRITERS:
            with self.subTest(name=name):
                wanted = self.written(command, name)
                (self.folder / name).symlink_to(f"there/{name}")
                there = self.folder / "there" / name
                for hangs in (True, False):
                    if not hangs:
                        there.write_bytes(b"old")
                        there.chmod(0o640)
                    self.call(*command, name)
                    self.assertTrue((self.folder / name).is_symlink())
                    self.assertEqual(there.read_bytes(), wanted)
                self.assertEqual(stat.S_IMODE(there.stat().st_mode), 0o640)

    def test_a_link_to_a_folder_that_is_not_there_stays_one(self):
        for number, command in enumerate((("export", "flown", "--to", "csv"), ("import", PX4_LOG))):
            (self.folder / f"link{number}").symlink_to(f"there/{number}")
            self.call(*command, "--out", f"link{number}")
            self.assertTrue((self.folder / f"link{number}").is_symlink())
            self.assertTrue(any((self.folder / "there" / str(number)).iterdir()))

    def test_a_circle_of_links_is_a_wrong_path(self):
        (self.folder / "x.mcap").symlink_to("x.mcap")
        self.assertIn("x.mcap: cannot be written (symbolic links in a circle)", self.call(*EXPORT, "x.mcap", code=2)[1])

    def test_minus_is_stdout_or_refused(self):
        for kind in ("mcap", "parquet"):
            wanted = self.written(EXPORT, f"x.{kind}")
            self.assertEqual(self.call("export", "flown", "--to", kind, "--out", "-"), (wanted, ""))
        for command in (("export", "flown", "--to", "csv"), ("render", "flown")):
            self.assertRegex(self.call(*command, "--out", "-", code=2)[1], r"\A--out -: .*stdout.*\n\Z")
        self.assertEqual(self.names(), ["e.toml", "flown"])


class Signals(Commands):
    LONG = {"mp4": ("render", "flown", "--fps", "120", "--speed", "0.01", "--out", "sub/x.mp4"),
            "gif": ("render", "flown", "--fps", "120", "--speed", "0.01", "--out", "x.gif"),
            "import": ("import", PX4_LOG, "--out", "out", "--mass", "1.2kg", "--arm", "0.25m"),
            "export": ("export", "flown", "--out", "x.parquet")}

    def test_at_any_moment_they_end_with_130_and_leave_nothing(self):
        before, moment = self.names(), random.Random(1)
        for name, arguments in self.LONG.items():
            # all scripts listen in one place
            for number in (signal.SIGTERM, signal.SIGINT, signal.SIGUSR1, signal.SIGHUP) if name == "mp4" else (signal.SIGTERM,):
                with self.subTest(command=name, signal=number), tempfile.TemporaryDirectory() as scratch:
                    process = subprocess.Popen([PROGRAM, *arguments], cwd=self.folder, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL,
                                               text=True, env=os.environ | {"TMPDIR": scratch},
                                               preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL))
                    self.addCleanup(process.kill)
                    self.assertTrue(wait_for(lambda: catches(process.pid, signal.SIGTERM)))
                    time.sleep(moment.uniform(0.0, 0.3 if name in ("import", "export") else 2.0))  # while it imports modules, or works
                    process.send_signal(number)
                    _, err = process.communicate(timeout=60)
                    self.assertEqual(process.returncode, 130, err)
                    self.assertNotIn("Traceback", err)
                    self.assertEqual(self.names(), before)
                    self.assertEqual(os.listdir(scratch), [])


if __name__ == "__main__":
    unittest.main()
