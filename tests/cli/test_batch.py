"""`gustlab diagnose --batch`: one line a set, a table of the fleet."""

import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

from concealed_trials import FIRST_SET, SECOND_SET, trials_toml

PROGRAM = os.environ["GUSTLAB_PROGRAM"]
MODELS = Path(__file__).resolve().parents[2] / "models"

SETS = FIRST_SET + """[[set]]
name = "broken"
fit = ["trials/broken.csv"]
vehicle = "crazyflie"
""" + SECOND_SET


class Batch(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="gustlab_test_"))
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "t.toml").write_text(trials_toml("one", "two"))
        (self.folder / "sets.toml").write_text(SETS)
        self.call("conceal", "t.toml", "--out", "trials", "--answers", "answers.jsonl")
        (self.folder / "trials" / "broken.csv").write_text("time_s,px\n0,0\n")
        shutil.copy(self.folder / "trials" / "one" / "fit_1.meta.toml", self.folder / "trials" / "broken.meta.toml")

    def call(self, *arguments, code=0):
        done = subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=300)
        self.assertEqual(done.returncode, code, f"{arguments}\n{done.stdout}\n{done.stderr}")
        return done.stdout, done.stderr

    def batch(self, out="out", code=0):
        return self.call("diagnose", "--batch", "sets.toml", "--out", out, code=code)

    def files(self, out="out"):
        return {str(path.relative_to(self.folder / out)): path.read_bytes() for path in sorted((self.folder / out).rglob("*")) if path.is_file()}

    def test_each_set_is_a_line_and_the_fleet_a_table(self):
        out, err = self.batch()
        lines = out.splitlines()
        self.assertEqual([line.split(":")[0] for line in lines[:3]], ["first", "broken", "second"])
        self.assertEqual(lines[1], "broken: unusable")
        self.assertIn("broken.csv:1:1", err)
        self.assertIn("| verdict | sets | of 3 |", lines)
        self.assertIn("| unusable | 1 | 33 % |", lines)
        self.call("diagnose", "trials/one/fit_1.csv", "trials/one/fit_2.csv", "--holdout", "trials/one/holdout_1.csv", "--out", "alone")
        self.assertEqual((self.folder / "alone" / "diagnosis.json").read_bytes(), self.files()["first/diagnosis.json"])

    def test_what_is_done_is_not_done_again_and_what_changed_is(self):
        out, _ = self.batch()
        times = {path: path.stat().st_mtime_ns for path in (self.folder / "out").rglob("*.json")}
        self.assertEqual(self.batch()[0], out)
        self.assertEqual(times, {path: path.stat().st_mtime_ns for path in (self.folder / "out").rglob("*.json")})
        sidecar = self.folder / "trials" / "two" / "fit_1.meta.toml"
        sidecar.write_text(sidecar.read_text().replace('notes = ""', 'notes = "changed"'))
        self.batch()
        changed = {path.parent.name for path in (self.folder / "out").rglob("*.json") if path.stat().st_mtime_ns != times[path]}
        self.assertEqual(changed, {"second"})

    def test_what_was_damaged_is_done_again(self):
        out, _ = self.batch()
        wanted = self.files()
        for damaged in ("", "{", "null", '{"verdict": "x"}', None):
            with self.subTest(damaged=damaged):
                path = self.folder / "out" / "first" / "diagnosis.json"
                path.unlink() if damaged is None else path.write_text(damaged)
                self.assertEqual(self.batch()[0], out)
                self.assertEqual(self.files(), wanted)

    def test_mistakes(self):
        for text, says in ((SETS.replace('"second"', '"first"'), '"first" is no name of a folder of its own'),
                           (SETS.replace('"first"', '"../first"'), "no name of a folder"),
                           (SETS.replace('"first"', r'"fi\u001b[31mrst"'), r'"fi\x1b[31mrst" is no name of a folder'),
                           (SETS.replace('"first"', r'"fi\nrst"'), "no name of a folder"),
                           (SETS.replace('"first"', r'"fi\u0000rst"'), "no name of a folder"),
                           (SETS.replace("holdout", "holdouts"), 'unknown key "holdouts"'),
                           ('format = "gustlab-sets/1"\n', "there is no [[set]]")):
            (self.folder / "sets.toml").write_text(text)
            self.assertIn(says, self.batch(code=2)[1])
            self.assertFalse((self.folder / "out").exists())
        self.assertIn("no flight is named", self.call("diagnose", "--out", "out", code=2)[1])

    def test_all_sets_are_checked_before_work_begins(self):
        twice = SETS + 'holdout = ["trials/two/fit_2.csv"]\n'
        sidecar = self.folder / "trials" / "two" / "fit_2.meta.toml"
        for text, *says in ((twice, 'sets.toml:13:11: set "second": trials/two/fit_2.csv: is given twice'),
                            (SETS.replace("two/fit_2", "two/gone"), 'sets.toml:12:7: set "second": trials/two/gone.csv: cannot read (No such file'),
                            (SETS + 'vehicle = "crazyflyie"\n', 'sets.toml:13:11: set "second": unknown vehicle "crazyflyie" (known: ', 'did you mean "crazyflie"?'),
                            (twice.replace("one/fit_2", "one/gone"), 'sets.toml:4:7: set "first": ', 'sets.toml:13:11: set "second": ')):
            with self.subTest(says[0]):
                (self.folder / "sets.toml").write_text(text)
                out, err = self.batch(code=2)
                for words in says:
                    self.assertIn(words, err)
                self.assertEqual(out, "")
                self.assertFalse((self.folder / "out").exists())
        (self.folder / "sets.toml").write_text(SETS)
        sidecar.write_text(sidecar.read_text().replace('"crazyflie"', '"crazyflyie"'))
        self.assertIn('sets.toml:12:7: set "second": trials/two/fit_2.meta.toml: unknown vehicle "crazyflyie"', self.batch(code=2)[1])

    def test_a_flight_that_names_no_vehicle_flew_with_that_of_the_others(self):
        sidecar = self.folder / "trials" / "two" / "fit_2.meta.toml"
        sidecar.write_text(sidecar.read_text().replace('vehicle = "crazyflie"\n', ""))
        self.assertIn("| unusable | 1 | 33 % |", self.batch()[0])

    def test_a_vehicle_is_found_beside_the_file_of_sets(self):
        shutil.copytree(MODELS / "crazyflie", self.folder / "fleet" / "my_quad")
        for vehicle in ("my_quad", "./my_quad", "my_quad/vehicle.toml", "crazyflie"):
            with self.subTest(vehicle):
                (self.folder / "fleet" / "sets.toml").write_text(
                    f'format = "gustlab-sets/1"\n[[set]]\nname = "a"\nfit = ["../trials/broken.csv"]\nvehicle = "{vehicle}"\n')
                # the vehicle is there, and then no set has a usable flight
                self.assertIn("a: unusable", self.call("diagnose", "--batch", "fleet/sets.toml", "--out", "out", code=3)[0])


if __name__ == "__main__":
    unittest.main()
