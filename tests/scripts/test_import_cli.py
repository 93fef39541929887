"""The importer as a program: conversions, maps, exit codes, reproducible bytes."""

import gzip
import json
import os
import re
import time
import tomllib
import unittest
from pathlib import Path

import numpy as np
from import_fixture import MAP, ImportCase, csv, flight

MAPS = Path(__file__).resolve().parents[2] / "scripts" / "column_maps"


class Conversion(ImportCase):
    def test_units_orders_and_names(self):
        columns = flight()
        for name in ("gx", "gy", "gz"):
            columns[name] = np.degrees(columns[name])
        for name in ("ax", "ay", "az"):
            columns[name] = columns[name] / 9.80665
        columns["t"] = 1e3 * columns["t"] + 250.0
        columns["bat"] = 1e3 * columns["bat"]
        text = MAP.replace('"rad/s"', '"deg/s"').replace('"m/s^2"', '"g"').replace('column = "bat"',
                                                                                  'column = "bat"\nunit = "mV"')
        text = text.replace('column = "t"', 'column = "t"\nunit = "ms"\nzero = true')
        code, findings, err = self.inspect(columns, text)
        self.assertEqual((code, findings, err), (0, [], ""))
        written, source = self.written(), flight()
        self.assertEqual(list(written), ["time_s", "px", "py", "pz", "vx", "vy", "vz", "qw", "qx", "qy", "qz", "wx", "wy",
                                         "wz", "ax", "ay", "az", "u1", "u2", "u3", "u4", "vbat"])
        for ours, theirs in (("time_s", "t"), ("pz", "z"), ("qw", "qw"), ("qx", "qx"), ("wy", "gy"), ("az", "az"),
                             ("u4", "m4"), ("vbat", "bat")):
            np.testing.assert_allclose(written[ours], source[theirs], rtol=1e-7, atol=1e-7, err_msg=ours)

    def test_sidecar(self):
        log = self.write("log.csv", csv(flight()))
        self.run_import(log, "--map", self.map, "--out", self.out, "--vehicle", "iris")
        sidecar = tomllib.loads((self.out / "log_1.meta.toml").read_text())
        self.assertEqual((sidecar["format"], sidecar["vehicle"], sidecar["actuator"], sidecar["hold"], sidecar["source"]),
                         ("gustlab-flight/1", "iris", "pwm", "unknown", "recording"))
        self.assertEqual((sidecar["origin"]["file"], sidecar["origin"]["rows_written"]), ("log.csv", 2000))

    def test_a_vehicle_may_be_given_as_its_folder(self):
        from gustlab_import.vehicle_file import MODELS, find_vehicle
        vehicle = self.folder / "my_quad" / "vehicle.toml"
        vehicle.parent.mkdir()
        for file in (MODELS / "iris").iterdir():
            (vehicle.parent / file.name).write_bytes(file.read_bytes())
        for wanted, beside in ((str(vehicle), Path()), (str(vehicle.parent), Path()), ("my_quad", self.folder), ("my_quad/vehicle.toml", self.folder)):
            self.assertEqual(find_vehicle(wanted, beside), vehicle)
        # a name under models/ stays that
        vehicle.parent.rename(self.folder / "iris")
        self.assertEqual(find_vehicle("iris", self.folder), MODELS / "iris" / "vehicle.toml")
        (self.folder / "iris").rename(vehicle.parent)
        log = self.write("log.csv", csv(flight()))
        code, _, err = self.run_import(log, "--map", self.map, "--out", self.out, "--vehicle", vehicle.parent)
        self.assertEqual((code, tomllib.loads((self.out / "log_1.meta.toml").read_text())["vehicle"]), (0, "../my_quad/vehicle.toml"), err)
        # a map's is beside the flight logs
        self.write("folder.toml", MAP.replace('"crazyflie"', '"my_quad"'))
        self.assertEqual(self.run_import(log, "--map", self.folder / "folder.toml", "--out", self.out)[0], 2)
        code, _, err = self.run_import(log, "--map", self.folder / "folder.toml", "--out", self.folder)
        self.assertEqual((code, tomllib.loads((self.folder / "log_1.meta.toml").read_text())["vehicle"]), (0, "my_quad"), err)

    def test_a_name_that_is_no_utf_8_is_escaped_and_may_be_imported_again(self):
        log = self.write(os.fsdecode(b"caf\xe9.csv"), csv(flight()))
        for _ in range(2):
            code, out, err = self.run_import(log, "--map", self.map, "--out", self.out, "--format", "json")
            self.assertEqual((code, err), (0, ""))
            self.assertEqual(json.loads(out)["logs"][0]["file"], "caf\\xe9.csv")
            self.assertEqual(json.loads((self.out / "import.json").read_text(encoding="utf-8"))["logs"][0]["file"], "caf\\xe9.csv")
            sidecar = tomllib.loads((self.out / "caf\\xe9_1.meta.toml").read_text(encoding="utf-8"))
            self.assertEqual(sidecar["origin"]["file"], "caf\\xe9.csv")

    def test_section(self):
        log = self.write("log.csv", csv(flight()))
        code, _, _ = self.run_import(log, "--map", self.map, "--out", self.out, "--from", 5, "--to", 12)
        self.assertEqual(code, 0)
        time_s = self.written()["time_s"]
        self.assertEqual((time_s[0], time_s[-1]), (5.0, 12.0))

    def test_same_input_same_bytes(self):
        log = self.write("log.csv.gz", gzip.compress(csv(flight()).encode()))
        results = []
        for folder in ("one", "two"):
            self.run_import(log, "--map", self.map, "--out", self.folder / folder)
            results.append({path.name: path.read_bytes() for path in sorted((self.folder / folder).iterdir())})
        self.assertEqual(list(results[0]), ["import.json", "log_1.csv", "log_1.meta.toml"])
        self.assertEqual(results[0], results[1])
        self.assertNotIn(str(self.folder).encode(), b"".join(results[0].values()))

    def test_unusable_is_written_only_on_request(self):
        columns = flight()
        columns["m2"][500:700] = 90000.0
        self.assertEqual(self.inspect(columns)[0], 3)
        self.assertFalse(self.out.exists())
        self.assertEqual(self.inspect(columns, MAP, "--keep-unusable")[0], 0)
        self.assertFalse(tomllib.loads((self.out / "log_1.meta.toml").read_text())["origin"]["usable"])

    def test_one_unusable_input_writes_nothing(self):
        good, bad = self.write("good.csv", csv(flight())), flight()
        bad["m2"][500:700] = 90000.0
        code, out, err = self.run_import(good, self.write("bad.csv", csv(bad)), "--map", self.map, "--out", self.out)
        self.assertEqual(code, 3)
        self.assertIn("bad.csv: not usable", err)
        self.assertFalse(self.out.exists())


class BadInput(ImportCase):
    def fails(self, code: int, words: str, *arguments):
        got, _, err = self.run_import(*arguments)
        self.assertEqual((got, words in err, len(err.strip().splitlines())), (code, True, 1), err)
        self.assertFalse(self.out.exists())

    def log(self, text: str) -> Path:
        return self.write("log.csv", text)

    def test_tables(self):
        good = csv(flight(2.0)).splitlines()
        cases = {"log.csv:1:1: empty file": "", "log.csv:2:1: the file has a header and no samples": good[0] + "\n",
                 "log.csv:3:3: `abc` in column `y` is not a number":
                     "\n".join(good[:2] + [",".join(["0.01", "1", "abc"] + ["0"] * 19)]),
                 "log.csv:3:4: 3 cells where the header has 22": "\n".join(good[:2] + ["1,2,3"]),
                 "column `x` occurs twice": good[0].replace(",y,", ",x,") + "\n" + good[1],
                 "no column `gx`": "\n".join(good).replace("gx", "omega_x"), "too few": "\n".join(good[:6]),
                 "log.csv:4: column `t`: a row without a time": "\n".join(good[:3] + ["," + good[3].split(",", 1)[1]])}
        for words, text in cases.items():
            with self.subTest(words):
                self.fails(3, words, self.log(text), "--map", self.map, "--out", self.out)

    def test_many_columns_take_time_by_their_number(self):
        head, *rows = csv(flight(2.0)).splitlines()
        names = ",".join(f"c{i}" for i in range(100_000))
        log = self.log("\n".join([f"{head},{names}", *(row + ",1" * 100_000 for row in rows[:5])]))
        start = time.process_time()
        self.fails(3, "only 5 samples", log, "--map", self.map, "--out", self.out)
        self.assertLess(time.process_time() - start, 10.0)   # in proportion to the square of their number it took 50 s

    def test_a_column_that_is_missing_is_named_in_the_map_beside_the_nearest(self):
        text = MAP.replace('["x", "y", "z"]', '[  # px\n  "px", "pv",\n  "pz"]')
        names = ",".join(f"c{i}" for i in range(100_000))
        for more, cells in (("", ""), (f",{names}", ",1" * 100_000)):
            rows = csv(flight(2.0)).replace("t,x,y,z,", "t,px,py,pz,", 1).splitlines()[:6]
            log = self.log("\n".join([rows[0] + more, *(row + cells for row in rows[1:])]))
            said = f"m.toml:8:9: no column `pv` in {log}; did you mean `px`?"
            self.fails(3, said, log, "--map", self.write("m.toml", text), "--out", self.out)
        _, _, err = self.run_import(log, "--map", self.write("m.toml", MAP.replace('"x"', '"KAPPA"')), "--out", self.out)
        self.assertRegex(err, r"m.toml:7:12: no column `KAPPA` .*one of: ax, ay, .* and 100010 more")
        self.assertLess(len(err), 400)

    def test_dots_that_are_no_key_are_read(self):
        text = MAP.replace("[time]", 'notes = "' + "a. " * 90 + "..." * 100 + '"\n# ' + "." * 200 + "\n[time]", 1)
        self.assertEqual(self.run_import(self.log(csv(flight(5.0))), "--map", self.write("m.toml", text), "--out", self.out)[0], 0)

    def test_broken_gzip(self):
        packed = gzip.compress(csv(flight(2.0)).encode())[:-200]
        self.fails(3, "log.csv.gz:1:1: the gzip stream is broken", self.write("log.csv.gz", packed), "--map", self.map,
                   "--out", self.out)

    def test_binary_where_text_is_expected(self):
        self.fails(3, "not a text file", self.write("log.csv", b"\xbc\x01\x02\xff" * 50), "--map", self.map, "--out", self.out)

    def test_maps(self):
        log = self.log(csv(flight(2.0)))
        cases = {"unknown key `colums` in [position]; did you mean `columns`?": MAP.replace('columns = ["x"', 'colums = ["x"'),
                 'frame = "nwd" is not known; one of: world, body': MAP.replace('"world"', '"nwd"'),
                 'unit = "deg" is not a unit of rate': MAP.replace('"rad/s"', '"deg"'),
                 "unknown table [positions]; did you mean `position`?": MAP.replace("[position]", "[positions]"),
                 "[attitude] needs 4 columns, not 3": MAP.replace('"qz", "qw"', '"qz"'),
                 "`vehicle` is missing": MAP.replace('vehicle = "crazyflie"\n', ""),
                 "a map needs [time] and [actuator]": MAP.replace("[time]\ncolumn = \"t\"\n", ""),
                 'format is "gustlab-column-map/9"': MAP.replace("map/1", "map/9"),
                 "`walls` must be a list of walls; each is [px, py, nx, ny]": MAP + "[environment]\nwalls = [[1, 2]]\n",
                 "`ground_z_m` must be a number": MAP + "[environment]\nground_z_m = inf\n",
                 '"a,b" is no name of a column': MAP + '[[extra]]\nname = "a,b"\ncolumn = "t"\n',
                 "m.toml:3:": MAP.replace('vehicle = "crazyflie"', "vehicle = crazyflie")}
        for words, text in cases.items():
            with self.subTest(words):
                self.fails(2, words, log, "--map", self.write("m.toml", text), "--out", self.out)

    def test_unknown_map(self):
        self.fails(2, "built in: arpl, crazypad, nanobench, nanodrone", self.log("t\n1\n"), "--map", "nothing", "--out", self.out)

    def test_options_without_a_use(self):
        log = self.log(csv(flight(2.0)))
        self.fails(2, "--whole: an import without --map has no use for it (it is for column maps); leave it out", log, "--whole", "--out", self.out)
        self.fails(2, "not allowed with argument", log, "--map", self.map, "--out", self.out, "-q", "-v")

    def test_missing_file(self):
        self.fails(3, "cannot be read", self.folder / "nothing.csv", "--map", self.map, "--out", self.out)

    def test_empty_section(self):
        self.fails(2, "no sample between 50 and 60 s", self.log(csv(flight(2.0))), "--map", self.map, "--out", self.out,
                   "--from", 50, "--to", 60)

    def test_two_inputs_of_one_name(self):
        (self.folder / "other").mkdir()
        second = self.write("other/log.csv", csv(flight(2.0)))
        self.fails(2, "use two --out", self.log(csv(flight(2.0))), second, "--map", self.map, "--out", self.out)

    def test_two_inputs_of_one_name_are_told_apart(self):
        """By the path that was given; what is written names no folder."""
        (self.folder / "other").mkdir()
        good, bad = self.log(csv(flight(2.0))), self.write("other/log.csv", csv(flight(2.0)).replace(",", ";", 1))
        for path in (bad, self.write("other/log.ulg", b""), self.write("other/log.xyz", b"nothing")):
            self.assertTrue(self.run_import(path, "--map", self.map)[2].startswith(f"{path}:"), path)
        bad.write_text(csv({**flight(2.0), "m2": 5.0 * flight(2.0)["m2"]}), encoding="utf-8")
        code, out, err = self.run_import(good, bad, "--map", self.map)
        self.assertEqual((code, out.count(f"{good}: "), out.count(f"{bad}: ")), (3, 1, 1), err)
        self.assertTrue(err.startswith(f"{bad}: not usable: "), err)
        code, out, _ = self.run_import(good, "--map", self.map, "--out", self.out, "--format", "json")
        self.assertEqual(json.loads(out)["logs"][0]["file"], "log.csv")
        # what was asked for is data, and no message
        self.assertEqual(self.run_import(good, "--map", self.map, "--format", "json", "-q"), (0, out, ""))
        self.assertEqual(self.run_import(good, "--map", self.map, "-q"), (0, "", ""))
        for path in self.out.iterdir():
            self.assertNotIn(str(self.folder), path.read_text(encoding="utf-8"))

    def test_output_that_cannot_be_written(self):
        in_the_way = self.write("file", "")
        self.fails(2, "is a file, not a folder", self.log(csv(flight())), "--map", self.map, "--out", in_the_way / "out")

    def test_no_measurement(self):
        columns = {name: values for name, values in flight().items() if name in ("t", "m1", "m2", "m3", "m4")}
        text = MAP[:MAP.index("[position]")] + MAP[MAP.index("[actuator]"):MAP.index("[battery]")]
        self.fails(3, "nothing to compare a simulation with", self.log(csv(columns)), "--map", self.write("m.toml", text),
                   "--out", self.out)

    def test_built_in_maps_are_valid(self):
        import sys
        sys.path.insert(0, str(MAPS.parent))
        from gustlab_import.column_map import load_map
        for path in MAPS.glob("*.toml"):
            self.assertTrue(load_map(path.stem).get("", "published"), path.name)


class Template(ImportCase):
    """`gustlab defaults column-map`: everything that a map may say stands in it, and what is commented out is what it says."""

    TEXT = (MAPS.parents[1] / "configs" / "templates" / "column-map.toml").read_text(encoding="utf-8")
    WHOLE = re.sub(r"(?m)^# (?=\[|\w+ = )", "", TEXT)

    def test_every_key_stands_in_it(self):
        from gustlab_import.column_map import TABLES
        said = tomllib.loads(self.WHOLE)
        keys = {"": {key for key, value in said.items() if key not in TABLES}}
        keys |= {name: set(said[name][0] if isinstance(said[name], list) else said[name]) for name in TABLES if name}
        self.assertEqual(keys, {name: allowed for name, (allowed, _) in TABLES.items()})

    def test_every_choice_and_unit_stands_at_its_key(self):
        from gustlab_import.column_map import ACTUATORS, CHOICES, UNIT_OF, UNITS
        units = {(table, "unit"): UNITS[quantity] for table, quantity in UNIT_OF.items()}
        units |= {("actuator", "unit"): {unit for quantity in set(ACTUATORS.values()) - {"none"} for unit in UNITS[quantity]},
                  ("reference", "yaw_unit"): UNITS["angle"], ("extra", "quantity"): UNITS}
        table, lines = "", {}
        for line in self.WHOLE.splitlines():
            if header := re.match(r"\[+(\w+)\]", line):
                table = header[1]
            elif key := re.match(r"(\w+) = ", line):
                lines[table, key[1]] = line
        for key, choices in (CHOICES | units).items():
            missing = [choice for choice in choices if not re.search(rf"(?<![\w/]){re.escape(choice)}(?![\w/^])", lines[key])]
            self.assertEqual(missing, [], key)

    def test_its_values_are_those_that_hold_without_it(self):
        from gustlab_import.column_map import load_map
        # these two have none: quaternions have no unit, and not every log has pulses
        whole = re.sub(r'(?m)^(unit = "rad"  .*of rpy alone|range = ).*\n', "", self.WHOLE)
        said = load_map(str(self.write("whole.toml", whole)))
        self.assertEqual(len(said.tables), 13)
        self.write("short.toml", self.TEXT)
        columns = {name: np.full(500, 0.5) + 0.01 * k for k, name in enumerate(said.names() | {"qw", "qx", "qy", "qz"})}
        columns |= {"t": np.arange(500) * 0.01}
        for name in ("whole", "short"):
            code, out, err = self.run_import(self.write("log.csv", csv(columns)), "--map", self.folder / f"{name}.toml", "--keep-unusable",
                                             "--out", self.folder / name)
            self.assertIn("flight log_1: 0.00 to 4.99 s", out, err)
        written = {name: (self.folder / name / "log_1.csv").read_text().splitlines() for name in ("whole", "short")}
        head = [lines[0].split(",") for lines in written.values()]
        for name in head[1]:
            self.assertEqual(*([line.split(",")[columns.index(name)] for line in lines] for columns, lines in zip(head, written.values())), name)


if __name__ == "__main__":
    unittest.main()
