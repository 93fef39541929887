"""schemas/: what the program prints as JSON follows its schema, and every JSON format has one."""

import json
import os
import re
import subprocess
import unittest
from pathlib import Path
from tempfile import TemporaryDirectory

import jsonschema

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ["GUSTLAB_PROGRAM"]
# formats of files that are not JSON, or that only this program reads again
OTHERS = {"flight", "vehicle", "experiment", "column-map", "trials", "network", "calibration", "published", "tuning", "sets"}


def schema(name):
    return json.loads((ROOT / "schemas" / f"{name}.schema.json").read_text(encoding="utf-8"))


CALIBRATION = """format = "gustlab-calibration/1"
table = "table2"
first_replicate = 1001
replicates = 2
[[stage]]
name = "gust"
evaluations = 4
targets = [{trajectories = ["circle"], controllers = ["pid"], metrics = ["rmse_xy_m"]}]
parameters = [{key = "effect.gust.sigma_xy", min = 0.015, start = 0.025, max = 0.05, log = true, unit = "N"}]
"""

# two trials: of one the diagnosis is right but for a wrong name too many, of the other there is none
TRIALS = """format = "gustlab-trials/1"
name = "t"
vehicle = "crazyflie"
controllers = ["pid"]
trajectories = ["circle"]
fit = ["circle"]
holdout = ["circle"]
seed = 1
duration_s = 3.0
[[trial]]
name = "one"
effects = [{type = "mass", delta = 0.08}]
[[trial]]
name = "two"
effects = [{type = "mass", delta = 0.08}, {type = "rotor_drag", at_hover = 0.01}]
"""


class Schemas(unittest.TestCase):
    def test_each_is_a_schema_of_its_own_version(self):
        for path in (ROOT / "schemas").glob("*.schema.json"):
            name = path.name.removesuffix(".schema.json")
            jsonschema.Draft202012Validator.check_schema(schema(name))
            version = schema(name)["properties"]["format"]["const"].removeprefix(f"gustlab-{name}/") if "format" in schema(name)["properties"] else "1"
            self.assertEqual(schema(name)["$id"], f"urn:gustlab:{name}:{version}")

    def test_every_json_format_has_one(self):
        found = set()
        for path in [*(ROOT / "src").rglob("*.cpp"), *(ROOT / "apps").rglob("*.cpp"), *(ROOT / "scripts").rglob("*.py")]:
            found |= set(re.findall(r'"gustlab-([a-z-]+)/[0-9]+"', path.read_text(encoding="utf-8")))
        self.assertEqual({name for name in found - OTHERS if not (ROOT / "schemas" / f"{name}.schema.json").exists()}, set())

    def test_the_example_of_a_diagnosis_follows_it(self):
        jsonschema.validate(json.loads((ROOT / "tests/report/diagnosis_example.json").read_text(encoding="utf-8")), schema("diagnosis"))

    def test_what_is_printed_follows(self):
        with TemporaryDirectory() as folder:
            def gustlab(*arguments):
                return subprocess.run([PROGRAM, *arguments], cwd=folder, capture_output=True, text=True, check=True, timeout=300).stdout

            Path(folder, "e.toml").write_text('format = "gustlab-experiment/1"\nname = "e"\nvehicle = "crazyflie"\ntrajectories = ["lemniscate"]\n'
                                              'controllers = ["pid"]\nduration_s = 4\n', encoding="utf-8")
            gustlab("run", "e.toml", "--trajectory", "lemniscate", "--controller", "pid", "--out", "run")
            gustlab("sweep", "e.toml", "--out", "sweep")
            Path(folder, "axes.toml").write_text(Path(folder, "e.toml").read_text(encoding="utf-8") +
                                                 '[[axis]]\nkey = "offboard_delay_s"\nvalues = [0.0, 0.1]\nalone = true\n', encoding="utf-8")
            gustlab("sweep", "axes.toml", "--out", "axes")
            for name, text in (
                ("outcome", Path(folder, "run/outcome.json").read_text(encoding="utf-8")),
                ("metrics", gustlab("metrics", "run/flight.csv", "--format", "json")),
                ("table", gustlab("table", "sweep", "--format", "json")),
                ("comparison", gustlab("compare", "axes.toml", "axes", "--format", "json")),
                ("replay", gustlab("replay", "run/flight.csv", "--format", "json")),
                ("list", gustlab("list", "--format", "json")),
                ("defaults", gustlab("defaults", "pid", "--format", "json")),
                ("bench", gustlab("bench", "--rounds", "1", "--format", "json")),
                ("vehicle-check", gustlab("vehicle", "check", "crazyflie", "--format", "json")),
            ):
                with self.subTest(name):
                    jsonschema.validate(json.loads(text), schema(name))

    def test_a_score_and_its_answers_follow(self):
        with TemporaryDirectory() as place:
            folder = Path(place)

            def gustlab(*arguments):
                return subprocess.run([PROGRAM, *arguments], cwd=folder, capture_output=True, text=True, check=True, timeout=300).stdout

            (folder / "t.toml").write_text(TRIALS, encoding="utf-8")
            gustlab("conceal", "t.toml", "--out", "trials", "--answers", "answers.jsonl")
            answers = (folder / "answers.jsonl").read_text(encoding="utf-8").splitlines()
            self.assertEqual(len(answers), 2)
            for answer in answers:
                jsonschema.validate(json.loads(answer), schema("answer"))
            (folder / "trials/one/diagnosis").mkdir()
            (folder / "trials/one/diagnosis/diagnosis.json").write_bytes((ROOT / "tests/report/diagnosis_example.json").read_bytes())
            score = json.loads(gustlab("score", "answers.jsonl", "trials", "--format", "json"))
            jsonschema.validate(score, schema("score"))
            self.assertEqual((score["trials"], score["without_diagnosis"], len(score["not_right"])), (2, 1, 2))
            # nothing that the schema speaks of is empty, so each part was looked at
            for part in (score["effects"], score["parameters"]["each"], score["reliability"]["bins"], score["confusion"]["concealed"], score["verdicts"]):
                self.assertTrue(part)

    def test_a_reproduction_follows(self):
        with TemporaryDirectory() as place:
            subprocess.run([PROGRAM, "reproduce", "table2", "--out", "out"], cwd=place, capture_output=True, text=True, check=True, timeout=300)
            reproduction = json.loads((Path(place) / "out/reproduction.json").read_text(encoding="utf-8"))
            jsonschema.validate(reproduction, schema("reproduction"))
            self.assertEqual({cell["use"] for cell in reproduction["cells"]}, {"fitted", "predicted"})
            self.assertEqual({cell["provenance"] for cell in reproduction["cells"]},
                             {"fitted", "predicted blind", "by construction", "chosen after seeing"})

    def test_a_calibration_follows(self):
        with TemporaryDirectory() as place:
            folder = Path(place)
            (folder / "e.toml").write_text('format = "gustlab-experiment/1"\nname = "e"\nvehicle = "crazyflie"\ntrajectories = ["circle"]\n'
                                           'controllers = ["pid"]\nduration_s = 2.0\n[trajectory.circle]\nperiod_s = 5.0\n'
                                           '[[effect]]\ntype = "gust"\nsigma_xy = 0.03\ncorrelation_time = 0.5\n', encoding="utf-8")
            (folder / "e.calibration.toml").write_text(CALIBRATION, encoding="utf-8")
            subprocess.run([PROGRAM, "calibrate", "e.toml", "--out", "out"], cwd=folder, capture_output=True, text=True, check=True, timeout=300)
            fitted = json.loads((folder / "out/calibration.json").read_text(encoding="utf-8"))
            jsonschema.validate(fitted, schema("calibrated"))
            self.assertEqual([len(fitted["stages"][0][key]) for key in ("parameters", "targets")], [1, 1])


if __name__ == "__main__":
    unittest.main()
