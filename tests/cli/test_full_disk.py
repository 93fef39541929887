"""A disk that is full from any one write on: exit 4 with the reason, nothing half, and with room again the same bytes."""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts"))

from import_fixture import MAP, csv, flight  # noqa: E402

PROGRAM = os.environ["GUSTLAB_PROGRAM"]
FULL = "No space left on device|database or disk is full|unable to open database file|disk I/O error"

EXPERIMENT = """
format = "gustlab-experiment/1"
name = "small"
vehicle = "crazyflie"
trajectories = ["circle"]
controllers = ["pid"]
replicates = 6
duration_s = 0.2
"""


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
        more = {"LD_PRELOAD": str(self.shared / "full_disk.so"), "FULL_DISK_COUNT": str(count), "FULL_DISK_FROM": str(full_from or 10**9)}
        done = subprocess.run([PROGRAM, *arguments], cwd=self.folder, text=True, capture_output=True, timeout=120, env=os.environ | more)
        return done.returncode, done.stderr, count.stat().st_size

    def sound(self, *arguments):
        code, err, writes = self.call(*arguments)
        self.assertEqual(code, 0, f"{arguments}\n{err}")
        return writes

    def files(self, folder="."):
        top = self.folder / folder
        return {str(path.relative_to(top)): path.read_bytes() for path in sorted(top.rglob("*")) if path.is_file()}

    def at_each_write(self, arguments, then):
        """Runs a command once for each of its writes with no room from that write on"""
        writes = self.sound(*arguments)
        wanted = self.files("out")
        self.assertGreater(writes, 3)
        for number in range(1, writes + 1):
            shutil.rmtree(self.folder / "out", ignore_errors=True)
            with self.subTest(command=arguments[0], write=number, of=writes):
                before = self.files()
                code, err, _ = self.call(*arguments, full_from=number)
                self.assertNotIn("Traceback", err)
                then(number, code, err, before, wanted)

    def leaves_nothing(self, number, code, err, before, wanted):
        self.assertEqual(code, 4, err)
        self.assertRegex(err, FULL)
        self.assertEqual(self.files(), before)
        self.assertFalse((self.folder / "out").exists())

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

    def test_merge_leaves_nothing(self):
        for part in ("1", "2"):
            self.sound("sweep", "e.toml", "--out", f"part{part}", "--shard", f"{part}/2")
        self.at_each_write(("merge", "part1", "part2", "--out", "out"), self.leaves_nothing)

    def test_diagnose_leaves_nothing(self):
        self.sound("run", "e.toml", "--set", "duration_s=2", "--trajectory", "circle", "--controller", "pid", "--out", "flown")
        self.at_each_write(("diagnose", "flown/flight.csv", "--out", "out", "--jobs", "1"), self.leaves_nothing)

    def test_import_leaves_nothing(self):
        (self.folder / "map.toml").write_text(MAP)
        (self.folder / "log.csv").write_text(csv(flight(8.0)))
        self.at_each_write(("import", "log.csv", "--map", "map.toml", "--out", "out"), self.leaves_nothing)


if __name__ == "__main__":
    unittest.main()
