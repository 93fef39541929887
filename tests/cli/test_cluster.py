"""scripts/cluster: a shard that is missing is an error, to merge again changes nothing, and a task asks a busy controller again."""

import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

from small_experiments import VARIANTS, experiment_toml

PROGRAM = os.environ["GUSTLAB_PROGRAM"]
CLUSTER = Path(__file__).resolve().parents[2] / "scripts" / "cluster"
MERGE = str(CLUSTER / "merge.sh")


class Merges(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.shared = Path(tempfile.mkdtemp(prefix="gustlab_test_"))
        cls.addClassCleanup(shutil.rmtree, cls.shared)
        for name, more in (("plain", ""), ("variants", VARIANTS)):
            (cls.shared / "e.toml").write_text(experiment_toml("hover", replicates=2, duration_s=0.2, more=more))
            for part in (1, 2):
                cls.sweep(f"{name}/shards/{part}", "--shard", f"{part}/2")
        cls.sweep("alone")

    @classmethod
    def sweep(cls, out, *more):
        subprocess.run([PROGRAM, "sweep", "e.toml", "--out", out, *more], cwd=cls.shared, check=True, capture_output=True)

    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="gustlab_test_"))
        self.addCleanup(shutil.rmtree, self.folder)
        shutil.copytree(self.shared, self.folder, dirs_exist_ok=True)

    def merge(self, parts, out, code=0):
        done = subprocess.run([MERGE, str(parts), out], cwd=self.folder, capture_output=True, text=True, timeout=60,
                              env=os.environ | {"GUSTLAB": PROGRAM})
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stderr

    def files(self):
        return {str(path.relative_to(self.folder)): path.read_bytes() for path in sorted(self.folder.rglob("*")) if path.is_file()}

    def test_a_shard_that_is_missing_is_named(self):
        shutil.copytree(self.folder / "plain" / "shards" / "1", self.folder / "second" / "shards" / "2")
        (self.folder / "hollow" / "shards" / "1").mkdir(parents=True)
        for parts, out, missing in ((3, "plain", 3), (2, "second", 1), (2, "hollow", 1), (2, "nowhere", 1)):
            with self.subTest(out=out):
                self.assertIn(f"{out}/shards/{missing}: shard {missing} of {parts} is missing", self.merge(parts, out, code=3))
                self.assertFalse((self.folder / out / "whole").exists())

    def test_run_again_it_says_so_and_changes_nothing(self):
        for out, wholes in (("plain", [""]), ("variants", ["/calm", "/other"])):
            self.assertEqual(self.merge(2, out), "")
            before = self.files()
            said = self.merge(2, out)
            for whole in wholes:
                self.assertIn(f"{out}/whole{whole}: the same shards are merged there already", said)
            self.assertEqual(self.files(), before)
        self.assertEqual(before["variants/whole/calm/runs.csv"], before["alone/calm/runs.csv"])
        shutil.rmtree(self.folder / "variants" / "whole" / "calm")
        self.merge(2, "variants")
        self.assertEqual(self.files(), before)

    def test_results_of_other_runs_are_never_overwritten(self):
        self.merge(2, "plain")
        shutil.copytree(self.folder / "plain" / "whole", self.folder / "variants" / "whole" / "calm")
        before = self.files()
        self.assertIn("variants/whole/calm: results of other runs are there", self.merge(2, "variants", code=2))
        self.assertEqual(self.files(), before)


class Tasks(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="gustlab_test_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def script(self, name, text):
        (self.folder / name).write_text(f"#!/usr/bin/env bash\n{text}\n")
        (self.folder / name).chmod(0o755)

    def code(self, *command, **variables):
        return subprocess.run(command, cwd=self.folder, timeout=60, env=os.environ | variables).returncode

    def task(self):
        """Runs one whose controller is busy once: its exit code, and what it asked of the controller."""
        asked = self.folder / "asked"
        asked.unlink(missing_ok=True)
        self.script("scontrol", 'echo "$@" >> asked; (($(wc -l < asked) > 1))')
        code = self.code(CLUSTER / "slurm_task.sh", self.folder, "4", "e.toml", "out", SLURM_ARRAY_JOB_ID="7", SLURM_ARRAY_TASK_ID="1",
                         PATH=f"{self.folder}:{os.environ['PATH']}")
        return code, asked.read_text() if asked.exists() else ""

    def test_an_interrupted_task_asks_again_to_be_queued(self):
        for ends_with, asked in ((130, 2), (0, 0), (139, 0)):
            with self.subTest(code=ends_with):
                self.script("shard.sh", f"exit {ends_with}")
                self.assertEqual(self.task(), (ends_with, "requeue 7_1\n" * asked))

    def test_a_signal_that_comes_before_it_is_heeded_is_an_interruption(self):
        # a program that has no handler of the signal yet (or no more) dies of the one that is passed on to it
        dies = 'kill -s USR1 "$PPID"; exec sleep 20'
        self.script("shard.sh", dies)
        self.assertEqual(self.task(), (130, "requeue 7_1\n" * 2))
        self.script("gustlab", dies)
        shard = (CLUSTER / "shard.sh", "1", "4", "e.toml", "out")
        self.assertEqual(self.code(*shard, GUSTLAB=str(self.folder / "gustlab")), 130)
        self.script("gustlab", "exit 139")
        self.assertEqual(self.code(*shard, GUSTLAB=str(self.folder / "gustlab")), 139)


if __name__ == "__main__":
    unittest.main()
