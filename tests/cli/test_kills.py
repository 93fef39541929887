"""Commands killed by SIGKILL or SIGTERM at random moments: what was done stays; begun again they write the same bytes."""

import contextlib
import os
import random
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

from concealed_trials import FIRST_SET, SECOND_SET, trials_toml
from small_experiments import CIRCLE, GUST, calibration_toml, experiment_toml

PROGRAM = os.environ["GUSTLAB_PROGRAM"]
# kills of each command that meet it at work; the target `kills` takes more. GUSTLAB_KILLS_SEED: other moments
KILLS = int(os.environ.get("GUSTLAB_KILLS", "3"))
SEED = int(os.environ.get("GUSTLAB_KILLS_SEED", "20"))

EXPERIMENT = experiment_toml("circle", "hover", replicates=40, duration_s=1.0, more=CIRCLE + GUST)
CALIBRATION = calibration_toml(replicates=4, evaluations=8)


class Kills(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="gustlab_test_"))
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "e.toml").write_text(EXPERIMENT)
        (self.folder / "e.calibration.toml").write_text(CALIBRATION)
        (self.folder / "t.toml").write_text(trials_toml("one", "two", duration_s=2.0))
        (self.folder / "sets.toml").write_text(FIRST_SET + SECOND_SET)
        self.moments = random.Random(f"{SEED} {self.id()}")

    def call(self, *arguments):
        """seconds"""
        start = time.monotonic()
        done = subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=900)
        self.assertEqual(done.returncode, 0, f"{arguments}\n{done.stdout}\n{done.stderr}")
        return time.monotonic() - start

    def files(self, out):
        top = self.folder / out
        return {str(path.relative_to(top)): path.read_bytes() for path in sorted(top.rglob("*")) if path.is_file()}

    def kill(self, arguments, within_s):
        """Starts the command and ends it after a random time; None if it was done before that"""
        process = subprocess.Popen([PROGRAM, *arguments], cwd=self.folder, text=True,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        with process.stderr:
            time.sleep(self.moments.uniform(0.0, within_s))
            sign = self.moments.choice([signal.SIGKILL, signal.SIGTERM])
            process.send_signal(sign)
            error = process.stderr.read()
            code = process.wait(timeout=900)
        if code == 0:
            return None
        # a SIGTERM before the program listens ends it at once
        self.assertIn(code, [-signal.SIGKILL] if sign == signal.SIGKILL else [130, -signal.SIGTERM], error)
        return sign

    def killed(self, kills, whole, again, check, finish=None):
        """Kills `again` until so many kills met it at work, up to five times before it may end, and compares its bytes
        with those of `whole`. check(): what must hold after each kill; finish(): carries it to the end, by default `again`
        itself. Arguments end with the folder"""
        within_s = self.call(*whole)
        wanted, met, ends = self.files(whole[-1]), [], 0
        while len(met) < kills:
            shutil.rmtree(self.folder / again[-1], ignore_errors=True)
            for _ in range(5):
                sign = self.kill(again, within_s)
                if sign is None:
                    break
                met.append(sign)
                check(wanted)
                if len(met) == kills:
                    break
            (finish or self.call)(*again)
            ends += 1
            self.same(again[-1], wanted)
        hard = met.count(signal.SIGKILL)
        print(f"{whole[0]}: {len(met)} kills ({hard} SIGKILL, {len(met) - hard} SIGTERM), "
              f"{ends} times carried to the end with the same bytes", file=sys.stderr)

    def same(self, out, wanted):
        found = self.files(out)
        for name, content in wanted.items():
            if not name.endswith(".sqlite"):
                self.assertEqual(found.get(name), content, name)

    def flown(self, out):
        """keys of the runs that a store holds"""
        path = self.folder / out / "runs.sqlite"
        if not path.exists():
            return set()
        with contextlib.closing(sqlite3.connect(path)) as database:  # an open reader keeps the store locked
            tables = database.execute("SELECT count(*) FROM sqlite_master WHERE name = 'flown'").fetchone()[0]
            return {row for row in database.execute("SELECT * FROM flown")} if tables else set()

    def test_killed_sweep_loses_no_run(self):
        before = set()

        def keeps(_):
            nonlocal before
            after = self.flown("killed")
            if (self.folder / "killed").exists():
                self.assertLessEqual(before, after)
            before = after

        def whole_again(*again):
            nonlocal before
            self.call(*again)
            self.assertLessEqual(before, self.flown("killed"))
            before = set()

        self.killed(4 * KILLS, ("sweep", "e.toml", "--jobs", "2", "--out", "whole"),
                    ("sweep", "e.toml", "--jobs", "2", "--resume", "--out", "killed"), keeps, whole_again)

    def test_killed_merge_can_be_made_again(self):
        for part in ("1", "2"):
            self.call("sweep", "e.toml", "--set", "replicates=400", "--set", "duration_s=0.1", "--shard", f"{part}/2",
                      "--out", f"part{part}")

        def whole_or_nothing(wanted):
            # where there is a store, it is whole
            if (self.folder / "killed" / "runs.sqlite").exists():
                self.assertEqual(self.flown("killed"), self.flown("whole"))
                shutil.rmtree(self.folder / "killed")

        def parts_again(*again):
            shutil.rmtree(self.folder / "killed", ignore_errors=True)
            self.call(*again)

        arguments = ("merge", "part1", "part2", "--out")
        self.killed(4 * KILLS, (*arguments, "whole"), (*arguments, "killed"), whole_or_nothing, parts_again)

    def no_half_file(self, wanted):
        for name, content in self.files("killed").items():
            if name in wanted:
                self.assertEqual(content, wanted[name], name)

    def test_killed_batch_goes_on(self):
        self.call("conceal", "t.toml", "--out", "trials", "--answers", "answers.jsonl")
        arguments = ("diagnose", "--jobs", "1", "--batch", "sets.toml", "--out")
        self.killed(KILLS, (*arguments, "whole"), (*arguments, "killed"), self.no_half_file)

    def test_killed_calibration_goes_on(self):
        before = []

        def keeps(wanted):
            nonlocal before
            self.no_half_file(wanted)
            path = self.folder / "killed" / "flown.jsonl"
            after = [line for line in path.read_text().splitlines(keepends=True) if line.endswith("\n")] if path.exists() else []
            if not (self.folder / "killed" / "values.txt").exists():  # else it was done
                self.assertEqual(after[:len(before)], before)
            before = after

        def whole_again(*again):
            nonlocal before
            self.call(*again)
            before = []

        arguments = ("calibrate", "e.toml", "--jobs", "1", "--out")
        self.killed(KILLS, (*arguments, "whole"), (*arguments, "killed"), keeps, whole_again)


if __name__ == "__main__":
    unittest.main()
