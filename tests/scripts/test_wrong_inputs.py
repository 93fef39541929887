"""More than forty kinds of wrong input to `gustlab import` and `gustlab vehicle`: for each one message, exit 2 or 3, and no file."""

import gzip
import os
import shutil
import sqlite3
import subprocess
import unittest
from pathlib import Path
from tempfile import TemporaryDirectory

from import_fixture import MAP, csv, flight, usd, without_progress
from test_import_px4 import synthetic
from ulog_fixture import px4_flight

PROGRAM = os.environ["GUSTLAB_PROGRAM"]
NONSENSE = bytes(range(7, 256, 3)) * 40
NEW = ["vehicle", "new", "--mass", "1.2kg", "--arm", "0.25m", "--hover", "0.5", "--out", "out"]
BODY = """<mujoco><worldbody><body><freejoint/><inertial pos="0 0 0" mass="1.2" diaginertia="0.018 0.018 0.03"/>
<geom type="box" size="0.1 0.1 0.03"/>
<site name="a" pos="0.17 -0.17 0"/><site name="b" pos="-0.17 0.17 0"/><site name="c" pos="0.17 0.17 0"/><site name="d" pos="-0.17 -0.17 0"/>
</body></worldbody></mujoco>"""
VEHICLE = 'format = "gustlab-vehicle/1"\nmjcf = "body.xml"\n' + "".join(
    f'[[rotor]]\nsite = "{site}"\ndirection = "{turn}"\n' for site, turn in zip("abcd", ("ccw", "ccw", "cw", "cw"))) + "[thrust]\nhover = 0.5\n"


def quad(**options):
    return px4_flight(synthetic(), **options).bytes()


def changed(name, function):
    """the good table with one column changed"""
    columns = flight(5.0)
    columns[name] = function(columns[name])
    return csv(columns)


def files():
    """name -> contents"""
    ulog, table = quad(), csv(flight(5.0))
    lines = table.splitlines()
    made = {"good.ulg": ulog, "good.csv": table, "good.toml": MAP, "other/good.csv": table, "body.xml": BODY, "vehicle.toml": VEHICLE,
            "empty.ulg": b"", "unknown.xyz": NONSENSE, "folder/log.ulg": ulog, "bare/notes.txt": b"nothing",
            "hexa.ulg": quad(mav_type=13).replace(b"CA_ROTOR_COUNT", b"CA_ROTOR_OTHER"), "wing.ulg": quad(mav_type=1), "vtol.ulg": quad(mav_type=22), "disarmed.ulg": quad(armed=(90.0, 91.0), flying=(90.0, 91.0)),
            "hop.ulg": quad(flying=(3.0, 4.0)), "no_motors.ulg": quad(motors_logged=False), "cut.ulg": ulog[:300], "cut.bin": b"\xa3\x95\x80\x80\x59FMT",
            "cut.usd": usd(2, [(k, 0.0, 0.0, 1, 2, 3, 4) for k in range(100)])[:60],
            "cut.bfl": b"H Product:Blackbox flight data recorder by Nicholas Sherlock\nH Data version:2\n", "cut.bag": b"#ROSBAG V2.0\nE",
            "cut.mcap": b"\x89MCAP0\r\n", "words.csv": "three words here\n", "header.csv": lines[0] + "\n",
            "ragged.csv": "\n".join(lines[:9] + ["1,2,3"]), "word.csv": table.replace(lines[5].split(",")[2], "north"),
            "twice.csv": table.replace(",y,", ",x,", 1), "packed.ulg.gz": gzip.compress(ulog), "cut.csv.gz": gzip.compress(table.encode())[:-200],
            "still.csv": changed("t", lambda t: 0.0 * t), "years.csv": changed("t", lambda t: 1e9 * t), "large.csv": changed("m2", lambda m: 5.0 * m),
            "broken.toml": MAP.replace('"crazyflie"', "crazyflie"), "typo.toml": MAP.replace("[position]", "[positon]"),
            "parquet.toml": MAP.replace('"csv"', '"parquet"'),
            "unit.toml": MAP.replace('"rad/s"', '"deg"'), "short.toml": MAP.replace('"qz", "qw"', '"qz"'), "lost.toml": MAP.replace('"gx"', '"roll_rate"'),
            "old.toml": MAP.replace("map/1", "map/9"), "less.toml": VEHICLE.split("[[rotor]]")[0],
            "site.toml": VEHICLE.replace('"a"', '"z"'), "hover.toml": VEHICLE.replace("0.5", "-0.5"), "key.toml": VEHICLE + "radius = 0.1\n",
            "body.toml": VEHICLE.replace("body.xml", "words.csv"), "taken/vehicle.toml": b"", "before/my_vehicle/vehicle.toml": b"", "theirs/import.json": b"[]",
            "semicolons.csv": table.replace(",", ";"), "wide.csv": table.encode("utf-16"), "decimal.csv": table.replace(".", ","),
            "quote.csv": table.replace("t,x", '"t,x', 1), "one.csv": "\n".join(lines[:2]) + "\n", "line\nbreak.ulg": b"",
            "mm.toml": MAP.replace('"z"]', '"z"]\nunit = "mm"', 1), "nobody.toml": MAP.replace('vehicle = "crazyflie"\n', ""),
            "numbers.toml": VEHICLE.replace("body.xml", "numbers.xml"), "numbers.xml": BODY.replace("-0.17 0.17 0", "left"),
            "stand.csv": "thrust_N,throttle\n" + "".join(f"{k},{k}\n" for k in range(9)), "few.csv": "thrust_N,speed_radps\n1,100\n"}
    made |= {"empty_x.csv": changed("x", lambda x: x * float("nan")), "empty_q.csv": changed("qw", lambda q: q * float("nan")), "empty_m.csv": changed("m3", lambda m: m * float("nan")),
             "empty_t.csv": changed("t", lambda t: t * float("nan")), "huge.csv": changed("x", lambda x: 1e308 * x), "huge_t.csv": changed("t", lambda t: 1e300 * t),
             "jump.csv": changed("t", lambda t: t + 1e9 * (abs(t - 0.5) < 0.001)), "backward.csv": changed("t", lambda t: -t), "degrees.csv": changed("gx", lambda w: 57.3 * w),
             "no_gravity.csv": changed("az", lambda a: a / 9.81), "no_unit.csv": changed("qw", lambda q: 3.0 * q), "below.csv": changed("m1", lambda m: -m),
             "nul.csv": table.replace(lines[4], "\0" * 40), "again.csv": "\n".join(lines[:200] + lines), "units.csv": "\n".join([lines[0], ",".join(["s"] + ["m"] * 21)] + lines[1:]),
             "remark.csv": "# made by hand\n" + table, "nameless.csv": table.replace("t,x,", "t,,", 1), "slow.csv": "\n".join([lines[0]] + lines[1::60]),
             "reversed.csv": "\n".join([lines[0]] + lines[:0:-1]), "list.csv": '{"t": [1, 2]}', "page.ulg": b"<html><body>404 not found</body></html>" * 10,
             "pointer.ulg": b"version https://git-lfs.github.com/spec/v1\noid sha256:aa\nsize 123\n", "packed.zip": b"PK\x03\x04" + bytes(200),
             "same.toml": MAP.replace('"m1", "m2"', '"m1", "m1"'), "nowhere.toml": MAP.replace('"crazyflie"', '"crazyfly"'), "nothing.toml": "",
             "number.toml": MAP.replace('["x", "y", "z"]', "[1, 2, 3]"), "order.toml": MAP.replace('"xyzw"', '"xxyw"'), "steam.toml": MAP.replace('"pwm"', '"steam"'),
             "two_times.toml": MAP + '[time]\ncolumn = "t"\n', "signs.toml": MAP.replace('["x", "y", "z"]', '["x", "y", "z"]\nsigns = [1, 1]'),
             "infinite.toml": MAP.replace('["x", "y", "z"]', '["x", "y", "z"]\nsigns = [inf, nan, 1]'), "range.toml": MAP.replace('kind = "pwm"', 'kind = "pwm"\nrange = [5, 5]')}
    made |= {"own.csv": b"time_s,px\n0,0\n", "own.meta.toml": b'format = "gustlab-flight-log/1"\n', "metadata.yaml": b"rosbag2_bagfile_information:\n  version: 4\n",
             "five.toml": MAP.replace('"m4"]', '"m4", "gx"]'), "fortnight.toml": MAP.replace("[time]", '[time]\nunit = "fortnight"'),
             "excel.toml": MAP.replace('"csv"', '"excel"'), "hex.csv": table.replace(lines[5].split(",")[2], "0x1F"), "tabs.csv": table.replace(",", "\t"),
             "three.toml": VEHICLE.replace('[[rotor]]\nsite = "d"\ndirection = "cw"\n', ""),
             "turn.toml": VEHICLE.replace('"ccw"', '"left"', 1), "one_site.toml": VEHICLE.replace('"b"', '"a"'), "speed.toml": VEHICLE.replace("0.5", "1.5"),
             "weightless.toml": VEHICLE.replace("body.xml", "weightless.xml"), "weightless.xml": BODY.replace('mass="1.2"', 'mass="0"'),
             "tied.toml": VEHICLE.replace("body.xml", "tied.xml"), "tied.xml": BODY.replace("<freejoint/>", ""), "nobody_there.toml": VEHICLE.replace("body.xml", "gone.xml"),
             "falls.csv": "throttle,thrust_N\n" + "".join(f"{k / 10},{9 - k}\n" for k in range(10)), "held.csv": "throttle,thrust_N\n" + "0.5,3\n" * 10,
             "weak.csv": "throttle,thrust_N\n" + "".join(f"{k / 10},{k * k / 100}\n" for k in range(10)), "mixed.csv": "throttle,thrust_N\n" + "".join(f"{k / 10},{-k if k == 3 else k}\n" for k in range(10)),
             "pushed.csv": "throttle,thrust_N\n" + "".join(f"{k / 10},{-k}\n" for k in range(10)), "ampere.csv": "throttle,current\n" + "0.5,3\n" * 10}
    made |= {"deep.toml": MAP + "notes = " + "[" * 100_000, "dotted.toml": MAP + ".".join("a" * 100_000) + " = 1\n", "latin.toml": MAP.encode() + b"notes = '\xe9'\n",
             "kind.toml": MAP.replace('kind = "csv"', "kind = 5"), "table.toml": MAP.replace('[position]\ncolumns = ["x", "y", "z"]', "position = 3"),
             "cell.csv": table.replace(lines[5].split(",")[2], "0." + "1" * 140_000), "return.csv": table.replace(lines[5].split(",")[2], "1\r2")}
    made |= {f"nonsense{kind}": NONSENSE for kind in (".ulg", ".bin", ".tlog", ".bag", ".db3", ".mcap", ".bfl", ".parquet", ".csv", ".toml")}
    return {name: text.encode() if isinstance(text, str) else text for name, text in made.items()}


def table(name, column_map="good.toml"):
    return ["import", name, "--map", column_map, "--out", "out"]


def log(name, *more):
    return ["import", name, "--out", "out", *more]


def stand(name):
    return ["vehicle", "fit", "--thrust-stand", name, "--vehicle", "vehicle.toml", "--out", "out"]


def new(**options):
    """`vehicle new` with options changed or left out"""
    words = dict(zip(NEW[2::2], NEW[3::2])) | {f"--{key.replace('_', '-')}": value for key, value in options.items()}
    return ["vehicle", "new", *(word for key, value in words.items() if value is not None for word in (key, value))]


# command line, exit code, what the message says
WRONG = (
    # what is asked of import
    (["import"], 2, "gustlab: the following arguments are required: LOG"),
    (["import", "--owt", "out", "good.ulg"], 2, "gustlab: unrecognized arguments: --owt"),
    (log("good.ulg", "--format", "xml"), 2, "invalid choice: 'xml'"),
    (log("good.ulg", "--from", "soon"), 2, "invalid seconds value: 'soon'"),
    (log("good.ulg", "--from", "nan"), 2, "invalid seconds value: 'nan'"),
    (log("good.ulg", "--to", "-1"), 2, "no flight before -1 s"),
    (log("good.ulg", "--vehicle", "good.toml"), 2, "good.toml:1:1: --vehicle: not a vehicle file"),
    (log("good.ulg", "--from", "9", "--to", "5"), 2, "no flight between 9 and 5 s"),
    (log("good.ulg", "--vehicle", "crazyfly"), 2, "no vehicle of this name"),
    (log("good.ulg", "--vehicle", "nonsense.toml"), 2, "nonsense.toml:1:1: "),
    (log("good.ulg", "--map", "nothing"), 2, "no built-in map"),
    (["import", "good.ulg", "--out", "theirs"], 2, "no import wrote it; give another --out"),
    (["import", "good.csv", "other/good.csv", "--map", "good.toml", "--out", "out"], 2, "use two --out"),
    (log("good.ulg", "--wh"), 2, "gustlab: unrecognized arguments: --wh"),
    (log(""), 2, 'gustlab: there is an empty word behind "import"'),
    (["import", "good.ulg", "--out", "good.csv"], 2, "--out good.csv: good.csv is a file, not a folder (flight logs go into a folder); give a folder"),
    (log("good.ulg", "--vehicle", "numbers.toml"), 2, 'numbers.xml:1:1: --vehicle: pos="left" of site "b" (three numbers are needed)'),
    (["import", "good.csv", "--map", "good.toml", "--from", "100", "--out", "out"], 2, "good.csv: no sample after 100 s"),
    # a vehicle beside its flights
    (log("good.ulg", "--mass", "1.2"), 2, '--mass: "1.2" is not a number with a unit'),
    (log("good.ulg", "--arm", "0.25m"), 2, "gustlab: --mass is required (see gustlab import --help)"),
    (log("good.ulg", "--mass", "1.2kg", "--vehicle", "iris"), 2, "--mass: --vehicle iris says it already; leave one of them out"),
    (["import", "good.ulg", "--mass", "1.2kg"], 2, "--mass: a vehicle is written only beside flight logs; give --out DIR"),
    (log("good.ulg", "--mass", "1.2kg", "--layout", "hexa"), 2, '--layout: "hexa" has 6 rotors, and 4 flew in good.ulg'),
    (log("disarmed.ulg", "--mass", "1.2kg", "--arm", "0.25m", "--hover", "0.5"), 3, "never armed"),
    (["import", "good.ulg", "--out", "before", "--mass", "1.2kg", "--arm", "0.25m"], 2,
     "is there already, and otherwise (a vehicle is never overwritten); leave --mass out to use it, or give another --out"),
    (["import", "good.ulg", "--out", "before"], 2, "before/my_vehicle/vehicle.toml:1:1: --vehicle: not a vehicle file"),
    # which file
    (log("missing.ulg"), 3, "missing.ulg: cannot be read (No such file or directory)"),
    (log("bare"), 2, "bare: a folder without a log"),
    (log("folder"), 2, "folder: a folder; give the log in it: folder/log.ulg"),
    (log("empty.ulg"), 3, "empty.ulg: byte 0: the file is empty; fetch it again"),
    (log("packed.ulg.gz"), 2, "packed.ulg.gz: is compressed with gzip; unpack it first"),
    (log("line\nbreak.ulg"), 3, "line\\x0abreak.ulg: byte 0: the file is empty"),
    (log("pipe.ulg"), 2, "pipe.ulg: is a pipe or a device (a log is read more than once); save it as a file first"),
    (log("unknown.xyz"), 2, "no log format that is known begins like this"),
    *((log(f"nonsense{kind}"), 3, f"nonsense{kind}: ") for kind in (".ulg", ".bin", ".tlog", ".bag", ".db3", ".mcap", ".bfl")),
    (log("nonsense.csv"), 2, "a csv file needs a column map"),
    (table("nonsense.parquet", "parquet.toml"), 3, "nonsense.parquet: the Parquet file cannot be read"),
    (table("nonsense.parquet"), 3, "not a text file (invalid start byte); a binary file needs a map of its kind"),
    *((log(f"cut{kind}"), 3, f"cut{kind}: ") for kind in (".ulg", ".bin", ".bag", ".db3", ".mcap", ".bfl", ".usd")),
    # what flew: import.json says what was refused, and there is no flight
    (log("wing.ulg"), 3, "a fixed-wing aircraft"),
    (log("vtol.ulg"), 3, "a VTOL"),
    (log("disarmed.ulg"), 3, "never armed"),
    (log("hop.ulg"), 3, "too short"),
    (log("no_motors.ulg"), 3, "no_motors.ulg: no flight: "),
    # tables
    (table("words.csv"), 3, "words.csv:"),
    (table("nonsense.csv"), 3, "not a text file"),
    (table("header.csv"), 3, "header.csv:2:1: the file has a header and no samples"),
    (table("ragged.csv"), 3, "ragged.csv:10:4: 3 cells where the header has 22"),
    (table("word.csv"), 3, "word.csv:6:3: `north` in column `y` is not a number"),
    (table("twice.csv"), 3, "column `x` occurs twice"),
    (table("cut.csv.gz"), 3, "the gzip stream is broken"),
    (table("semicolons.csv"), 3, "semicolons.csv:1:1: cells are separated by semicolons; write commas"),
    (table("wide.csv"), 3, "wide.csv:1:1: not a text file (invalid start byte); it is UTF-16: save it as UTF-8"),
    (table("good.ulg"), 3, "it is a flight computer's log; `gustlab import` without --map reads it"),
    (table("decimal.csv"), 3, "cells where the header has 22 (decimal commas?)"),
    (table("quote.csv"), 3, "quote.csv:1:1: a quotation mark in the header is never closed"),
    (table("one.csv"), 3, "one.csv: only 1 sample: too few"),
    (table("still.csv"), 3, "still.csv"),
    (table("years.csv"), 3, "[time] unit is too large"),
    (table("large.csv"), 3, "large.csv: not usable"),
    (table("empty_x.csv"), 3, "empty_x.csv:1: column `x` holds no number, and [position] of the map names it; leave [position] out"),
    (table("empty_q.csv"), 3, "empty_q.csv:1: column `qw` holds no number, and [attitude] of the map"),
    (table("empty_m.csv"), 3, "empty_m.csv:1: column `m3` holds no number, and [actuator] of the map"),
    (table("empty_t.csv"), 3, "empty_t.csv:2: column `t`: a row without a time (500 of them)"),
    (table("huge.csv"), 3, "column `x` holds no number that could be meant"),
    (table("huge_t.csv"), 3, "huge_t.csv:3: column `t`: a time that is no number, or too large for one (499 of them)"),
    (table("jump.csv"), 3, "time runs backward"),
    (table("backward.csv"), 3, "time runs backward"),
    (table("reversed.csv"), 3, "time runs backward"),
    (table("degrees.csv"), 3, "rows lie outside -70 to 70 rad/s"),
    (table("no_gravity.csv"), 3, "gravity was removed"),
    (table("no_unit.csv"), 3, "these columns are no unit quaternion"),
    (table("below.csv"), 3, "rows lie outside 0 to 65535 pwm"),
    (table("nul.csv"), 3, "nul.csv:5:2: 1 cells where the header has 22"),
    (table("again.csv"), 3, "again.csv:201:1: `t` in column `t` is not a number"),
    (table("units.csv"), 3, "units.csv:2:1: `s` in column `t` is not a number"),
    (table("remark.csv"), 3, "remark.csv:1:1: the first line is a remark (`# made by hand`); the names of the columns must be there"),
    (table("nameless.csv"), 3, "good.toml:7:12: no column `x` in nameless.csv; did you mean `ax`?"),
    (table("slow.csv"), 3, "cannot be judged at 1.7 Hz"),
    (table("list.csv"), 3, "list.csv:2:1: the file has a header and no samples"),
    (log("page.ulg"), 3, "page.ulg: byte 0: not a PX4 ULog"),
    (log("pointer.ulg"), 3, "pointer.ulg: byte 0: not a PX4 ULog"),
    (log("packed.zip"), 2, "packed.zip: byte 0: no log format that is known begins like this"),
    (log("dangling.ulg"), 3, "dangling.ulg: cannot be read (No such file or directory)"),
    (log("circle.ulg"), 3, "circle.ulg: cannot be read (Too many levels of symbolic links)"),
    (log("n" * 300), 3, "cannot be read (File name too long)"),
    (log("good.ulg", "good.ulg"), 2, "good.ulg: would be written over good.ulg (both give good); use two --out"),
    (log("good.ulg", "--from", "inf"), 2, "invalid seconds value: 'inf'"),
    (log("own.csv"), 2, "own.csv: is a flight log already (own.meta.toml is beside it); give it to `gustlab diagnose`"),
    (log("metadata.yaml"), 2, "metadata.yaml: describes a ROS 2 bag and holds no samples; give the .db3 or .mcap beside it"),
    (log("good.ulg", "--vehicle", "three.toml"), 2, "good.ulg: 4 motors are logged and the vehicle ../three.toml has 3 rotors"),
    (log("good.ulg", "--vehicle", "body.xml"), 2, "body.xml:1:1: --vehicle: not a vehicle file ("),
    (table("hex.csv"), 3, "hex.csv:6:3: `0x1F` in column `y` is not a number"),
    (table("cell.csv"), 3, "cell.csv:1:1: not a table of comma separated cells (field larger than field limit (131072)); save it as CSV again"),
    (table("return.csv"), 3, "return.csv:6:4: 3 cells where the header has 22 (cut off while it was written?)"),
    (table("tabs.csv"), 3, "tabs.csv:1:1: cells are separated by tabs; write commas"),
    # column maps
    (table("good.csv", "deep.toml"), 2, "deep.toml:25:1: nested too deep"),
    (table("good.csv", "dotted.toml"), 2, "dotted.toml:26:1: a key of more than 100 parts"),
    (table("good.csv", "latin.toml"), 2, "latin.toml:1:1: the map cannot be read ("),
    (table("good.csv", "kind.toml"), 2, "kind.toml:2:1: `kind` must be a text in quotes"),
    (table("good.csv", "table.toml"), 2, "table.toml:6:1: unknown key `position` in [time]"),
    (log("good.ulg", "--vehicle", "dotted.toml"), 2, "dotted.toml:1:1: --vehicle: not a vehicle file (a key of more than 100 parts)"),
    (table("good.csv", "five.toml"), 2, "five.toml:1:1: [actuator] has 5 columns, and the vehicle crazyflie has 4 rotors; give the vehicle that flew"),
    (table("good.csv", "fortnight.toml"), 2, 'fortnight.toml:5:9: unit = "fortnight" is not a unit of time'),
    (table("good.csv", "excel.toml"), 2, 'kind = "excel" is not known; one of: csv'),
    (table("good.csv", "same.toml"), 2, "[actuator] names column `m1` twice"),
    (table("good.csv", "nowhere.toml"), 2, 'nowhere.toml:1:1: there is no vehicle "crazyfly" under models/ (a path ends in .toml); did you mean `crazyflie`?'),
    (table("good.csv", "nothing.toml"), 2, "nothing.toml:1:1: `format` is missing"),
    (table("good.csv", "number.toml"), 2, "`columns` must be a list of names"),
    (table("good.csv", "order.toml"), 2, 'order = "xxyw" is not known'),
    (table("good.csv", "steam.toml"), 2, 'kind = "steam" is not known'),
    (table("good.csv", "two_times.toml"), 2, "Cannot declare ('time',) twice"),
    (table("good.csv", "signs.toml"), 2, "[position] signs = [1, 1]; must be 3 numbers"),
    (table("good.csv", "infinite.toml"), 2, "`signs` must be a list of numbers from -1 to 1"),
    (table("good.csv", "range.toml"), 2, "[actuator] range = [5, 5]; must be [off, full]"),
    (table("good.csv", "broken.toml"), 2, "broken.toml:3:"),
    (table("good.csv", "typo.toml"), 2, "did you mean `position`?"),
    (table("good.csv", "unit.toml"), 2, 'unit = "deg" is not a unit of rate'),
    (table("good.csv", "short.toml"), 2, "[attitude] needs 4 columns, not 3"),
    (table("good.csv", "lost.toml"), 3, "lost.toml:15:12: no column `roll_rate` in good.csv; one of: ax, ay, az, bat, gx, "),
    (table("good.csv", "old.toml"), 2, 'format is "gustlab-column-map/9"'),
    (table("good.csv", "mm.toml"), 3, "good.csv: not usable: the velocity is 1000 times the derivative of the position: wrong unit"),
    (table("good.csv", "nobody.toml"), 2, "nobody.toml:1:1: `vehicle` is missing"),
    # vehicle new
    (new(mass="1.2"), 2, '"1.2" is not a number with a unit'),
    (new(mass="-1kg"), 2, '"-1kg" is not above zero'),
    (new(arm="0x1m"), 2, '"0x1m" is not a number with a unit'),
    (new(arm=None), 2, "--arm is missing"),
    (new(hover=None), 2, "--thrust-to-weight or --hover is missing"),
    (new(mass="1,2kg"), 2, '--mass: "1,2kg" is not a number with a unit'),
    (new(hover="60"), 2, "--hover: 60 is no hover throttle (it is between 0 and 1)"),
    (new(throttle_curve="2"), 2, "--throttle-curve: 2 is not a number from 0 to 1"),
    (new(thrust_to_weight="2"), 2, "--hover and --thrust-to-weight are two answers to one question: keep one"),
    (new(layout="hex"), 2, 'did you mean "hexa"?'),
    (new(prop="40in"), 2, "overlap"),
    (new(arm="1m", prop="30in", mass="1g"), 2, "--mass, --prop: 0.001 kg on 4 propellers of 0.762 m hover with tips at 0.56 m/s; propellers of that size are heavier than the "
                                               "whole vehicle; check both, and their units"),
    (new(mass="1g"), 2, "--mass, --arm: 0.001 kg on 4 propellers of some 0.2828 m, which fit between the motors, hover with tips at 1.5 m/s; "),
    (new(mass="900kg"), 2, "faster than sound; check both, and their units"),
    (new(arm="1e-9m"), 2, "--arm: 1e-09 m is no multirotor's (0.001 to 100 m from the centre to a motor); check its unit"),
    (new(arm="1cm"), 2, "which fit between the motors, do not hover: their tips would move at 1297 m/s, faster than sound"),
    (new(hover=None, thrust_to_weight="0.5"), 2, "--thrust-to-weight: a vehicle with 0.5 does not fly"),
    (new(hover="0.99"), 2, "--hover: 0.99 is a thrust to weight of 1.017: a vehicle with 1.017 does not fly"),
    (new(hover="0.001"), 2, "--hover: 0.001 is a thrust to weight of 2852: 2852 (no multirotor pushes"),
    (new(out="taken"), 2, "is there already"),
    (new(from_log="missing.ulg"), 3, "missing.ulg: cannot"),
    (new(from_log="--"), 3, "--: cannot be read (No such file"),
    (new(from_log="--help"), 3, "--help: cannot be read (No such file"),
    (new(from_log="wing.ulg"), 3, "not of a multicopter"),
    (new(from_log="good.ulg", layout="hexa"), 2, '--layout: "hexa" has 6 rotors, and 4 flew in good.ulg (its CA_ROTOR_COUNT); leave --layout out'),
    (new(from_px4="good.ulg", layout="octo"), 2, '--layout: "octo" has 8 rotors, and 4 flew in good.ulg'),
    (new(from_log="hexa.ulg", layout="x"), 2, '--layout: "x" has 4 rotors, and 6 flew in hexa.ulg (its MAV_TYPE 13)'),
    (new(from_log="cut.ulg"), 3, "cut.ulg: "),
    (new(from_log="cut.bfl"), 3, "cut.bfl: a log of PX4 (.ulg) or ArduPilot (.bin) is needed"),
    (new(from_log="folder"), 3, "folder: a folder; give the log in it"),
    # vehicle check and vehicle fit
    (["vehicle"], 2, "gustlab: a command is missing (see gustlab vehicle --help)"),
    (["vehicle", "make"], 2, 'gustlab: unknown command "make" (see gustlab vehicle --help)'),
    (["vehicle", "chek", "crazyflie"], 2, 'gustlab: unknown command "chek"; did you mean "check"?'),
    (["vehicle", "check", "taken"], 2, "taken/vehicle.toml: 4 required keys are missing:"),
    (["vehicle", "check", "crazyfly"], 2, 'did you mean "crazyflie"?'),
    (["vehicle", "check", "nonsense.toml"], 2, "nonsense.toml:1:1: not TOML"),
    (["vehicle", "check", "less.toml"], 2, "less.toml: 2 required keys are missing:"),
    (["vehicle", "check", "site.toml"], 2, 'there is no site "z"'),
    (["vehicle", "check", "hover.toml"], 2, '"hover" must be positive'),
    (["vehicle", "check", "key.toml"], 2, 'unknown key "radius"; did you mean "radius_m"?'),
    (["vehicle", "check", "body.toml"], 2, "words.csv:1:"),
    (["vehicle", "check", "body.xml"], 2, "body.xml: an MJCF and no vehicle file; give the vehicle.toml that names it"),
    (["vehicle", "check", "turn.toml"], 2, 'turn.toml:5:13: "left" is not a direction; write "ccw" or "cw"'),
    (["vehicle", "check", "one_site.toml"], 2, 'one_site.toml:7:8: site "a" carries two rotors'),
    (["vehicle", "check", "speed.toml"], 2, '"hover" of 1.5 is no actuator input (throttle is 0 to 1, rotor speed 20 to 8000 rad/s'),
    (["vehicle", "check", "weightless.toml"], 2, "weightless.xml:1: not a model that MuJoCo takes"),
    (["vehicle", "check", "tied.toml"], 2, "tied.xml: a vehicle has exactly one free joint"),
    (["vehicle", "check", "nobody_there.toml"], 2, 'nobody_there.toml:2:8: there is no file "gone.xml"'),
    (["vehicle", "fit", "--out", "out"], 2, "flight logs or --thrust-stand FILE.csv, one of them"),
    (["vehicle", "fit", "good.csv", "--vehicle", "vehicle.toml", "--out", "out"], 3, "a log needs its sidecar"),
    (["vehicle", "fit", "missing.csv", "--out", "out"], 3, "missing.csv: cannot read"),
    (stand("few.csv"), 3, "1 rows are too few"),
    (stand("stand.csv"), 3, "throttle is from 0 to 1"),
    (stand("falls.csv"), 3, "falls.csv: the map from throttle to thrust does not rise: it falls from 9 N at 0 to "),
    (stand("weak.csv"), 3, "weak.csv: a rotor of the vehicle carries 2.94 N in hover, and thrust does not rise to that as throttle rises"),
    (stand("mixed.csv"), 3, 'mixed.csv:5:5: "thrust_N" is negative (-3)'),
    (stand("held.csv"), 3, "held.csv: nothing can be told from these rows ("),
    (stand("pushed.csv"), 3, "pushed.csv: no row has thrust above zero"),
    (stand("ampere.csv"), 3, 'ampere.csv:1:1: column "thrust_N" is missing'),
    (stand("nonsense.csv"), 3, "nonsense.csv:1:"),
)


class WrongInputs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        place = TemporaryDirectory(prefix="gustlab_test_")
        cls.addClassCleanup(place.cleanup)
        cls.folder = Path(place.name)
        for name, contents in files().items():
            (cls.folder / name).parent.mkdir(parents=True, exist_ok=True)
            (cls.folder / name).write_bytes(contents)
        os.mkfifo(cls.folder / "pipe.ulg")
        os.symlink("no_file", cls.folder / "dangling.ulg")
        os.symlink("circle.ulg", cls.folder / "circle.ulg")
        with sqlite3.connect(cls.folder / "whole.db3") as database:
            database.execute("CREATE TABLE topics (name TEXT)")
        database.close()
        (cls.folder / "cut.db3").write_bytes((cls.folder / "whole.db3").read_bytes()[:3000])

    def state(self):
        return {path: path.read_bytes() if path.is_file() else None for path in self.folder.rglob("*")}

    def left(self, before):
        """what was written, but for a record of what import refused; the folder is as it was afterwards"""
        after = self.state()
        written = [path.relative_to(self.folder).as_posix() for path in after if after[path] != before.get(path, "nothing")]
        shutil.rmtree(self.folder / "out", ignore_errors=True)
        self.assertEqual(self.state(), before)
        return [] if written == ["out", "out/import.json"] else written

    def test_a_layout_that_does_not_turn_as_the_log_says_is_written_with_a_warning(self):
        for layout, warns in (("x", False), ("x-betaflight", False), ("+", True), ("x-crazyflie", False)):
            done = subprocess.run([PROGRAM, *new(from_log="good.ulg", layout=layout)], cwd=self.folder, capture_output=True, text=True, check=False)
            shutil.rmtree(self.folder / "out")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(done.stderr.startswith(f'warning: --layout: the rotors of "{layout}" do not lie and turn as those of good.ulg'), warns, done.stderr)
            self.assertEqual(done.stderr.count("\n"), int(warns))

    def test_one_message_each(self):
        self.assertGreaterEqual(len(WRONG), 40)
        before = self.state()
        for arguments, code, says in WRONG if "GUSTLAB_EVERY_TEST" in os.environ else WRONG[::4]:
            with self.subTest(" ".join(arguments)):
                done = subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, text=True, check=False, timeout=120)
                # a list of keys that are missing goes on in indented lines
                first, *more = without_progress(done.stderr).rstrip("\n").split("\n")
                self.assertEqual(done.returncode, code, done.stderr)
                self.assertIn(says, first)
                self.assertTrue(all(line.startswith(("  ", "(")) for line in more), done.stderr)
                self.assertRegex(first, "^(gustlab: |--[a-z-]+[ :,]|[^ ]+: |vehicle fit takes |unknown vehicle )")
                self.assertNotRegex(done.stderr, r"Traceback|terminate|Error\b.*Error\b|0x[0-9a-f]{6}")
                self.assertLess(len(first), 300)
                self.assertTrue(first.isprintable(), first)
                self.assertEqual(self.left(before), [])


if __name__ == "__main__":
    unittest.main()
