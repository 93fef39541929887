"""Inputs that are broken on purpose: one message with its place, exit 2 or 3, soon, in little memory, and nothing written."""

import json
import os
import re
import resource
import shutil
import sqlite3
import subprocess
import tempfile
import time
import tomllib
import unittest
from pathlib import Path

from concealed_trials import trials_toml

PROGRAM = os.environ["GUSTLAB_PROGRAM"]

BODY = """<mujoco>{head}<worldbody>
<body><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.02"/>{inside}
<site name="a" pos="1 -1 0"/><site name="b" pos="-1 -1 0"/><site name="c" pos="-1 1 0"/><site name="d" pos="1 1 0"/>
</body></worldbody></mujoco>
"""

VEHICLE = """format = "gustlab-vehicle/1"
name = "quad"
mjcf = "body.xml"
[thrust]
coefficient = 1e-3
torque_ratio = 0.01
max_speed_radps = 200
radius_m = 0.1
""" + "".join(f'[[rotor]]\nsite = "{site}"\ndirection = "{turn}"\n' for site, turn in zip("abcd", ("ccw", "cw", "ccw", "cw")))

EXPERIMENT = """format = "gustlab-experiment/1"
name = "small"
vehicle = "v/vehicle.toml"
trajectories = ["hover"]
controllers = ["pid"]
duration_s = 0.2
"""

# a tetrahedron
MESH = "v 0 0 0\nv {0} 0 0\nv 0 {0} 0\nv 0 0 {0}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
WITH_MESH = ('<asset><mesh name="m" file="m.obj"/></asset>', '<geom type="mesh" mesh="m" contype="0" conaffinity="0" mass="0"/>')
MOST_BYTES = 2 << 30
MOST_SECONDS = 20.0  # an input that is refused takes milliseconds; without its limit each of these takes minutes or gigabytes


# a sanitizer reserves terabytes of addresses, which nothing stands behind
SANITIZED = b"-fsanitize" in subprocess.run([PROGRAM, "--version"], capture_output=True, check=True).stdout


def limit_memory():
    if not SANITIZED:
        resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))


class Commands(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="gustlab_test_"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.write("v/vehicle.toml", VEHICLE)
        self.write("v/body.xml", BODY.format(head="", inside=""))
        self.write("e.toml", EXPERIMENT)

    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text) if isinstance(text, bytes) else path.write_text(text)
        return path

    def call(self, *arguments, code=0):
        start = time.monotonic()
        done = subprocess.run([PROGRAM, *map(str, arguments)], cwd=self.folder, capture_output=True, timeout=60, preexec_fn=limit_memory)
        self.assertEqual(done.returncode, code, f"{arguments}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}")
        self.assertLess(time.monotonic() - start, MOST_SECONDS)
        return done.stdout.decode(), done.stderr.decode()

    def refuse(self, code, says, *arguments):
        before = {path: path.read_bytes() for path in self.folder.rglob("*") if path.is_file()}
        out, err = self.call(*arguments, code=code)
        self.assertEqual(out, "")
        self.assertIn(says, err)
        self.assertEqual(before, {path: path.read_bytes() for path in self.folder.rglob("*") if path.is_file()})

    def key(self):
        return self.call("sweep", "e.toml", "--dry-run")[0].split()[-1].rsplit(",", 1)[1]


class Vehicles(Commands):
    PLAN = ("sweep", "e.toml", "--dry-run")

    def body(self, head="", inside=""):
        self.write("v/body.xml", BODY.format(head=head, inside=inside))

    def test_every_file_that_the_mjcf_names_is_part_of_the_key(self):
        self.body(*WITH_MESH)
        keys = []
        for size in (1, 2, 1):
            self.write("v/m.obj", MESH.format(size))
            keys.append(self.key())
        self.assertNotEqual(keys[0], keys[1])
        self.assertEqual(keys[0], keys[2])
        self.body('<asset><model name="x" file="part.xml"/></asset>', '<attach model="x" body="p" prefix="x"/>')
        for mass in ("1e-3", "2e-3"):
            self.write("v/part.xml", f'<mujoco><worldbody><body name="p"><geom size="0.01" mass="{mass}"/></body></worldbody></mujoco>')
            keys.append(self.key())
        self.assertEqual(len(set(keys)), 4)

    def test_a_mesh_counts_when_it_is_the_mass(self):
        self.body('<compiler meshdir="parts" inertiafromgeom="true"/><asset><mesh name="m" file="m.obj"/></asset>',
                  '<geom type="mesh" mesh="m" contype="0" conaffinity="0" density="6"/>')
        self.write("v/parts/m.obj", MESH.format(1))
        self.assertRegex(self.key(), "^[0-9a-f]{32}$")

    def test_nothing_outside_the_folder_is_read(self):
        self.write("part.xml", '<mujoco><worldbody><body name="p"/></worldbody></mujoco>')
        self.write("m.obj", MESH.format(1))
        (self.folder / "v" / "link.obj").symlink_to("../m.obj")
        attach = '<attach model="x" body="p" prefix="x"/>'
        for head, inside in (('<asset><model name="x" file="../part.xml"/></asset>', attach),
                             (f'<asset><model name="x" file="{self.folder}/part.xml"/></asset>', attach),
                             ('<asset><mesh name="m" file="link.obj"/></asset>', ""),
                             ('<asset><mesh name="m" file="../m.obj"/></asset>', ""),
                             ('<compiler meshdir=".."/><asset><mesh name="m" file="m.obj"/></asset>', ""),
                             (f'<compiler assetdir="{self.folder}"/><asset><mesh name="m" file="m.obj"/></asset>', "")):
            with self.subTest(head=head):
                self.body(head, inside)
                self.refuse(2, "outside the vehicle's folder", *self.PLAN)

    def test_what_is_too_large_is_refused(self):
        (self.folder / "v" / "self.xml").symlink_to("body.xml")
        for head, inside, says in (
                ('<asset><hfield name="h" nrow="20000" ncol="20000" size="1 1 1 1"/></asset>', "", '"nrow" of <hfield>'),
                ('<asset><texture name="t" type="2d" builtin="flat" width="30000" height="30000"/></asset>', "", '"width" of <texture>'),
                ("", '<replicate count="30000"><replicate count="30000"><site pos="0 0 0"/></replicate></replicate>', "elements"),
                ("", "<geom size='0.1' mass='0'/>" * 120000, "elements"),
                ("", '<replicate count="1400"><replicate count="2"><site pos="0 0 0"/></replicate></replicate>', "elements"),
                ('<size memory="100G"/>', "", '"memory" of <size>'),
                ('<size nuserdata="2000000000"/>', "", '"nuserdata" of <size>'),
                ('<size njmax="100000"/>', "", '"njmax" of <size>'),
                ('<custom><numeric name="n" size="2000000000"/></custom>', "", '"size" of <numeric>'),
                ('<sensor><user dim="100000000"/></sensor>', "", '"dim" of <user>'),
                ('<sensor><contact num="100000000" data="found"/></sensor>', "", '"num" of <contact>'),
                ('<sensor><gyro site="a" nsample="16000000" delay="1"/></sensor>', "", '"nsample" of <gyro>'),
                ('<actuator><general site="a" dyntype="user" actdim="1000000"/></actuator>', "", '"actdim" of <general>'),
                ('<asset><model name="x" file="body.xml"/></asset>', '<attach model="x" body="p" prefix="x"/>', "without end"),
                ('<asset><model name="x" file="self.xml"/></asset>', '<attach model="x" body="p" prefix="x"/>', "without end"),
                ('<include file="body.xml"/>', "", "<include> is not read"),
                ("", '<composite type="grid" count="1000 1000 1"/>', "<composite> is not read"),
                ("", "<body>" * 5000 + "</body>" * 5000, "body.xml:")):
            with self.subTest(says=says):
                self.body(head, inside)
                self.refuse(2, says, *self.PLAN)


class Depth(Commands):
    def test_toml_keys(self):
        deep = ".".join("a" * 200000)
        for text in (deep + " = 1\n", f"[{deep}]\n", "x = {" + deep + " = 1}\n", " . ".join("a" * 100000) + " = 1\n", '"""\n"""\n' + deep):
            self.write("deep.toml", text)
            self.refuse(2, "a key of more than", "sweep", "deep.toml", "--dry-run")
        self.refuse(2, "a key of more than", "sweep", "e.toml", "--dry-run", "--set", "a." * 1000 + "a=1")

    def test_dots_that_are_no_key_are_read(self):
        self.write("e.toml", EXPERIMENT + 'vehicle_notes = "' + "a." * 1000 + "\"  # " + "b." * 1000 + "\n")
        self.refuse(2, 'unknown key "vehicle_notes"', "sweep", "e.toml", "--dry-run")

    def test_json(self):
        diagnosis = self.write("trials/t/diagnosis/diagnosis.json", "[" * 100000)
        answer = '{"trial": "t", "effects": [], "kind": "clean"}\n'
        self.write("answers.jsonl", answer)
        out, err = self.call("score", "answers.jsonl", "trials")
        self.assertIn("1 ", out)
        self.assertIn("diagnosis.json:1:102: is no diagnosis (nested deeper than 100)", err)
        self.write("answers.jsonl", '{"trial": ' + '{"a":' * 100000 + "}" * 100000 + "}\n")
        self.refuse(3, "answers.jsonl:1:511: not an answer (nested deeper than 100)", "score", "answers.jsonl", "trials")
        self.write("answers.jsonl", '{"trial": "t", "kind": "single", "effects": [{"effect": "mass"}], "oracle": {"position_m": {"after": [0.1]}}}\n')
        diagnosis.write_text('{"verdict": "explained", "effects": [], "fit": {"horizon_s": [0.1], "position_m": {"after": [1]}}}')
        self.refuse(3, "answers.jsonl:1:11: the diagnosis of t", "score", "answers.jsonl", "trials")


class Stores(Commands):
    def test_a_store_that_was_changed_is_exit_3(self):
        self.call("sweep", "e.toml", "--out", "s")
        sound = (self.folder / "s" / "runs.sqlite").read_bytes()
        for change in ("DELETE FROM provenance", "DELETE FROM provenance WHERE name = 'settle_s'",
                       "UPDATE provenance SET value = 'soon' WHERE name = 'settle_s'", "UPDATE flown SET outcome = 'flew away'",
                       "UPDATE flown SET rmse_xy_m = 9e999", "UPDATE flown SET rmse_xy_m = 1e308", "UPDATE flown SET rmse_z_m = -1",
                       "DROP VIEW runs", "UPDATE plan SET run = 7", "DELETE FROM plan"):
            self.write("s/runs.sqlite", sound)
            database = sqlite3.connect(self.folder / "s" / "runs.sqlite")
            with database:
                database.execute(change)
            database.close()
            with self.subTest(change=change):
                self.refuse(3, "s/runs.sqlite: " if "plan" not in change else "s", "table", "s")

    def test_a_store_with_text_for_a_number_is_exit_3_everywhere(self):
        self.call("sweep", "e.toml", "--out", "s")
        self.call("gate", "s", "--baseline", "b.csv", "--update")
        sound = (self.folder / "s" / "runs.sqlite").read_bytes()
        for change, says in (("UPDATE flown SET rmse_xy_m = 'abc'", 's/runs.sqlite: hover pid 1: "abc" of rmse_xy_m is no figure'),
                             ("UPDATE flown SET rotor_sd_radps = 'abc'", 's/runs.sqlite: hover pid 1: "abc" of rotor_sd_radps is no figure'),
                             ("UPDATE plan SET replicate = 'abc'", "s/runs.sqlite: hover pid abc: this replicate is no number"),
                             ("UPDATE provenance SET value = 'zzz'", 's/runs.sqlite: "settle_s" of the provenance is no number ("zzz")'),
                             ("UPDATE provenance SET value = x'ff00fe'", 's/runs.sqlite: "settle_s" of the provenance is no number ("\\xff\\u0000\\xfe")')):
            self.write("s/runs.sqlite", sound)
            database = sqlite3.connect(self.folder / "s" / "runs.sqlite")
            with database:
                database.execute(change)
            database.close()
            for command in (["table", "s"], ["table", "s", "--format", "json"], ["gate", "s", "--baseline", "b.csv"], ["merge", "s", "--out", "m"]):
                with self.subTest(change=change, command=command):
                    self.refuse(3, says, *command)
                    self.assertFalse((self.folder / "m").exists())

    def test_a_refused_resume_changes_no_byte(self):
        self.call("sweep", "e.toml", "--out", "s")
        self.refuse(2, "another experiment", "sweep", "e.toml", "--out", "s", "--resume", "--seed", "9")
        self.refuse(2, "is of shard", "sweep", "e.toml", "--out", "s", "--resume", "--shard", "1/2")

    def test_a_store_that_was_killed_at_birth_is_gone_on_with(self):
        self.call("sweep", "e.toml", "--out", "whole")
        (self.folder / "s").mkdir()
        for journal in ("DELETE", "WAL"):
            shutil.rmtree(self.folder / "s")
            (self.folder / "s").mkdir()
            database = sqlite3.connect(self.folder / "s" / "runs.sqlite")
            database.execute(f"PRAGMA journal_mode = {journal}")
            database.execute("PRAGMA user_version = 0")
            database.close()
            # SQLite itself puts two files beside a store with a write-ahead log
            if journal == "DELETE":
                self.refuse(3, "not a result store", "table", "s")
            self.call("sweep", "e.toml", "--out", "s", "--resume")
            self.assertEqual((self.folder / "s" / "runs.csv").read_bytes(), (self.folder / "whole" / "runs.csv").read_bytes())

    def test_a_baseline_with_figures_of_no_flight_is_exit_3(self):
        self.call("sweep", "e.toml", "--out", "s")
        self.call("gate", "s", "--baseline", "b.csv", "--update")
        sound = (self.folder / "b.csv").read_text().split(",")
        for value in ("inf", "1e308", "-1", "nan(x)", ""):
            cells = list(sound)
            cells[-6] = value  # rmse_xy_m
            self.write("b.csv", ",".join(cells))
            self.refuse(3, "b.csv:2:", "gate", "s", "--baseline", "b.csv")
        self.refuse(3, "/dev/zero: cannot read (it is larger than 64 MiB)", "gate", "s", "--baseline", "/dev/zero")


class Logs(Commands):
    def setUp(self):
        super().setUp()
        self.write("e.toml", EXPERIMENT.replace("0.2", "4.0").replace("v/vehicle.toml", "crazyflie"))
        self.call("run", "e.toml", "--trajectory", "hover", "--controller", "pid", "--out", "flown")
        self.log = (self.folder / "flown" / "flight.csv").read_text().splitlines()
        self.columns = self.log[0].split(",")

    def with_cell(self, column, value, row=100):
        cells = self.log[row].split(",")
        cells[self.columns.index(column)] = value
        self.write("flown/flight.csv", "\n".join([*self.log[:row], ",".join(cells), *self.log[row + 1:]]) + "\n")
        return f"flown/flight.csv:{row + 1}:{len(','.join(cells[:self.columns.index(column)])) + 2}: "

    def test_a_cell_that_no_statistic_can_take_is_a_finding_with_its_place(self):
        for column, value in (("rotor3", "1e6"), ("ax", "1e100"), ("wx", "1e300"), ("px", "1e308"), ("vbat", "-1e9"), ("u1", "1e7")):
            if column not in self.columns:
                continue
            place = self.with_cell(column, value)
            for command in (["metrics", "flown/flight.csv"], ["diagnose", "flown/flight.csv", "--out", "dg"], ["replay", "flown/flight.csv"],
                            ["identify", "flown/flight.csv"]):
                with self.subTest(column=column, command=command[0]):
                    self.refuse(3, f"{place}{float(value):.4g} in column {column}".replace("e+0", "e+0"), *command)

    def test_a_missing_column_names_itself_and_what_may_be_meant(self):
        self.write("flown/flight.csv", "\n".join([self.log[0].replace(",px,", ",pq,"), *self.log[1:]]) + "\n")
        self.refuse(3, 'column "px" is missing (a tracking error needs position and reference); did you mean "pq"?', "metrics", "flown/flight.csv")
        self.write("flown/flight.csv", "\n".join([self.log[0].replace(",px,", ",PX,"), *self.log[1:]]) + "\n")
        self.refuse(3, 'column "px" is missing (a tracking error needs position and reference); did you mean "PX"?', "metrics", "flown/flight.csv")

    def test_a_repair_is_said_once_and_changes_no_figure(self):
        sound, said = self.call("metrics", "flown/flight.csv")
        self.assertEqual(said, "")
        self.write("flown/flight.csv", "\n".join([*self.log[:101], self.log[100], *self.log[101:]]) + "\n")
        out, err = self.call("metrics", "flown/flight.csv")
        self.assertEqual(err, "warning: flown/flight.csv:102: 1 rows repeat the one before and are dropped\n")
        self.assertEqual(out, sound)

    def test_a_loop_of_links_is_named(self):
        (self.folder / "LOOP").symlink_to("LOOP")
        self.refuse(3, "LOOP: not a flight log", "metrics", "LOOP")

    def test_a_jump_in_time_takes_time_by_rows(self):
        shutil.copytree(self.folder / "flown", self.folder / "late")
        sound, late = "flown/flight.csv", "late/flight.csv"
        self.log[0] = self.log[0].replace("rotor", "other")  # the speeds come from the commands
        self.write(sound, "\n".join(self.log) + "\n")
        for first, by_s in ((len(self.log) - 1, 9e10), (len(self.log) // 2, 1e9)):
            rows = [line.split(",", 1) for line in self.log[1:]]
            times = [str(float(cells[0]) + (by_s if row >= first else 0.0)) for row, cells in enumerate(rows, 1)]
            self.write(late, "\n".join([self.log[0], *(f"{at},{cells[1]}" for at, cells in zip(times, rows))]) + "\n")
            for command in (["replay", late], ["identify", late], ["diagnose", late, "--out", "dg"],
                            ["diagnose", sound, "--holdout", late, "--out", "dg"]):
                with self.subTest(first=first, command=command):
                    self.call(*command)

    def test_many_columns_take_time_by_their_number(self):
        names = [f"c{i}" for i in range(100000)]
        rows = [line + "," + ",".join("1" for _ in names) for line in self.log[1:6]]
        self.write("flown/flight.csv", "\n".join([self.log[0] + "," + ",".join(names), *rows]) + "\n")
        start = time.process_time(), resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        self.call("metrics", "flown/flight.csv")
        self.assertLess(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - start[1], 3.0)

    def test_control_characters_are_not_obeyed(self):
        self.with_cell("px", "\x1b[2J1")
        _, err = self.call("metrics", "flown/flight.csv", code=3)
        self.assertNotIn("\x1b", err)
        self.assertIn("\\x1b[2J1", err)
        for arguments in (["list", "\x1b[31m"], ["\x1b[31m"], ["defaults", "\x9b31m\u009b"], ["--\x1b"]):
            _, err = self.call(*arguments, code=2)
            self.assertIsNone(re.search("[\x00-\x09\x0b-\x1f\x7f-\x9f]", err), repr(err))

    def test_nor_in_what_is_printed_for_people(self):
        self.write("flown/\x1b[31m.csv", "\n".join(self.log[:50]) + "\n")
        shutil.copy(self.folder / "flown" / "flight.meta.toml", self.folder / "flown" / "\x1b[31m.meta.toml")
        self.call("sweep", "e.toml", "--out", "s")
        with sqlite3.connect(self.folder / "s" / "runs.sqlite") as store:
            store.execute("UPDATE plan SET trajectory = char(27) || '[31m'")
        store.close()
        self.write("a.jsonl", '{"trial": "\\u001b[31m", "kind": "clean", "effects": []}\n')
        for arguments in (["metrics", "flown/\x1b[31m.csv"], ["table", "s"], ["score", "a.jsonl", "."]):
            out, _ = self.call(*arguments)
            self.assertNotIn("\x1b", out)
            self.assertIn("\\x1b[31m", out)


    def test_a_name_that_is_no_utf_8_is_escaped_in_what_is_written(self):
        name = os.fsdecode(b"caf\xe9")
        for end in (".csv", ".meta.toml"):
            (self.folder / "flown" / ("flight" + end)).rename(self.folder / (name + end))
        out, _ = self.call("metrics", name + ".csv", "--format", "json")
        self.assertEqual(json.loads(out)["logs"][0]["file"], "caf\\xe9.csv")
        json.loads(self.call("replay", name + ".csv", "--format", "json")[0])
        self.call("diagnose", name + ".csv", "--out", "dg")
        document = json.loads((self.folder / "dg" / "diagnosis.json").read_text(encoding="utf-8"))
        self.assertIn("caf\\xe9.csv", json.dumps(document, ensure_ascii=False).replace("\\\\", "\\"))
        self.assertIn("caf\\xe9.csv", (self.folder / "dg" / "report.html").read_text(encoding="utf-8"))
        tomllib.loads((self.folder / "dg" / "augmented.toml").read_text(encoding="utf-8"))

    def test_a_copy_of_a_flight_is_not_held_out(self):
        for end in (".csv", ".meta.toml"):
            shutil.copy(self.folder / "flown" / ("flight" + end), self.folder / ("copy" + end))
        for option in ([], ["--holdout"], ["--reference"]):
            with self.subTest(option=option):
                _, said = self.call("diagnose", "flown/flight.csv", *option, "copy.csv", "--out", "dg")
                self.assertIn("copy.csv: is a copy of flown/flight.csv: set aside", said)


class Settings(Commands):
    def test_places_of_what_is_not_there_or_is_a_folder(self):
        self.refuse(2, "controller.daiml.weights=.: ", "sweep", "e.toml", "--dry-run", "--set", 'controllers=["daiml"]', "--set", "controller.daiml.weights=.")
        (self.folder / "loop.toml").symlink_to("loop.toml")
        self.refuse(2, "loop.toml: cannot read", "sweep", "loop.toml", "--dry-run")
        (self.folder / "v" / "body.xml").unlink()
        (self.folder / "v" / "body.xml").symlink_to("body.xml")
        self.refuse(2, 'v/vehicle.toml:3:8: cannot read "', "sweep", "e.toml", "--dry-run")
        (self.folder / "v" / "vehicle.toml").unlink()
        (self.folder / "v" / "vehicle.toml").symlink_to("vehicle.toml")
        self.refuse(2, "vehicle.toml: cannot read", "sweep", "e.toml", "--dry-run")

    def test_an_include_that_cannot_be_read_is_named_where_it_stands(self):
        (self.folder / "loop.toml").symlink_to("loop.toml")
        for name in ("nothere.toml", "loop.toml", "v"):
            self.write("i.toml", EXPERIMENT + f'include = ["{name}"]\n')
            self.refuse(2, f'i.toml:7:11: "{name}" cannot be read (', "sweep", "i.toml", "--dry-run")

    # 700 Hz gave 500 Hz, and 333 Hz steps of 2 and 4 ms in turns
    def test_a_rate_of_the_log_that_does_not_divide_the_loop_is_refused(self):
        self.write("t.toml", trials_toml("nothing"))
        for command in (["run", "e.toml"], ["sweep", "e.toml", "--logs"], ["conceal", "t.toml", "--answers", "a"]):
            with self.subTest(command=command[0]):
                self.refuse(2, '--set log_rate_hz=333: "log_rate_hz" 333 Hz does not divide the rate of controller "pid", 500 Hz (steps '
                            "between rows would be unequal); write log_rate_hz = 250 or 500", *command, "--set", "log_rate_hz=333", "--out", "o")
        self.write("t.toml", "log_rate_hz = 700\n" + trials_toml("nothing"))
        self.refuse(2, 't.toml:1:15: "log_rate_hz" 700 Hz is above the rate of controller "pid", 500 Hz (', "conceal", "t.toml", "--answers", "a",
                    "--out", "o")

    # an hour took a gigabyte, and a day 15
    def test_a_log_that_is_too_long_is_refused_before_it_is_flown(self):
        self.write("t.toml", trials_toml("nothing"))
        long = ("--set", "duration_s=90000", "--out", "o")
        for command in (["run", "e.toml", *long], ["sweep", "e.toml", "--logs", *long], ["conceal", "t.toml", "--answers", "a", *long]):
            with self.subTest(command=command[0]):
                self.refuse(2, "000 rows is too long (the most are 3000000); fly less than 90000 s, or log_rate_hz = 33.3333333333 at most", *command)
                self.assertFalse((self.folder / "o").exists())
        # of as long a flight fewer rows
        self.call("run", "e.toml", "--set", "vehicle=crazyflie", "--set", "duration_s=7000", "--set", "log_rate_hz=10", "--out", "o")
        self.assertEqual((self.folder / "o" / "flight.csv").read_bytes().count(b"\n"), 70001)

    def test_an_option_before_its_command_is_called_one(self):
        for words, name, before in ((["--set", "a=1", "run", "e.toml"], "--set", ""), (["--set=a=1", "run", "e.toml"], "--set", ""),
                                    (["-j3", "run"], "-j", ""), (["vehicle", "--mass", "1kg", "new"], "--mass", "vehicle ")):
            self.refuse(2, f'gustlab: unknown option "{name}" before a command (options of a command stand behind it); write gustlab {before}COMMAND {name}\n', *words)
        self.call("-q", "vehicle", "check", "crazyflie")
        self.call("vehicle", "-v", "check", "crazyflie")

    def test_an_empty_file_is_no_network(self):
        for name in ("empty", "/dev/null"):
            self.write("empty", "")
            self.write("w.toml", EXPERIMENT.replace('"pid"', '"daiml"') + f'[controller.daiml]\nweights = "{name}"\n')
            self.refuse(3, f'{name}:1:1: the file is empty (w.toml:8:11 names it as "weights")', "sweep", "w.toml", "--out", "s")

    def test_one_wind_is_nothing_to_train_on(self):
        self.write("t.toml", EXPERIMENT + '[[variant]]\nname = "calm"\nset = ["seed=1"]\n')
        self.refuse(2, "t.toml:7:1: 1 wind condition to train on", "train", "t.toml", "--out", "w")

    def test_a_budget_beyond_counting_is_refused(self):
        self.write("t.toml", 'format = "gustlab-tuning/1"\nflights = 9223372036854775807\nfirst_replicate = 1000\nreplicates = 1\nsearch_seeds = [1]\n'
                             '[[controller]]\nname = "pid"\n[[controller.parameters]]\nname = "position_gain"\nmin = 1.0\nmax = 2.0\nstart = 1.5\n')
        self.refuse(2, 't.toml:2:11: "flights" is out of range', "tune", "e.toml", "--tuning", "t.toml", "--out", "o")


if __name__ == "__main__":
    unittest.main()
