"""Logs of every kind and column maps, damaged at random: an answer with exit 0, 2 or 3, one line for what is wrong, and never a traceback.

GUSTLAB_MUTATIONS: how many of each kind; GUSTLAB_MUTATIONS_SEED: others."""

import os
import random
import unittest
from pathlib import Path

import test_import_formats as formats
from import_fixture import MAP, ImportCase, csv, flight, usd
from test_import_px4 import synthetic
from ulog_fixture import px4_flight

MUTATIONS = int(os.environ.get("GUSTLAB_MUTATIONS", "12"))
SEED = os.environ.get("GUSTLAB_MUTATIONS_SEED", "1")
WORDS = (b"", b"\0", b"\xff" * 4, b"\r", b"\n", b",", b'"', b"nan", b"inf", b"-1e999", b"1e308", b"[" * 2000, b"{", b"a." * 300, b"\xc3", b"0" * 200, b"\x7f\xff\xff\xff")


def mutated(good: bytes, chance: random.Random) -> bytes:
    """One to five of: bytes changed, a piece cut out, repeated, moved, or a word in its place."""
    bad = bytearray(good)
    for _ in range(chance.randint(1, 5)):
        # half of the damage is where files say what they are
        at = chance.randrange(max(1, min(len(bad), 400) if chance.random() < 0.5 else len(bad)))
        until = min(len(bad), at + chance.choice((1, 2, 4, 8, 60, 1000)))
        kind = chance.randrange(6)
        if kind == 0:
            bad[at:until] = chance.randbytes(until - at)
        elif kind == 1:
            del bad[at:until]
        elif kind == 2:
            bad[at:at] = bad[at:until] * chance.choice((1, 1, 50))
        elif kind == 3:
            to = chance.randrange(len(bad) + 1)
            bad[to:to] = bad[at:until]
        elif kind == 4:
            bad[at:at + chance.choice((0, 1, until - at))] = chance.choice(WORDS)
        else:
            del bad[at:]
        if not bad:
            break
    return bytes(bad)


class Mutations(ImportCase):
    LAYOUT = formats.DataFlash.LAYOUT

    def survive(self, name: str, good: bytes, *more, change=None):
        """`change`: the file to damage, when it is not the log"""
        chance = random.Random(f"{SEED} {name}")
        log = self.write(name, good)
        target, sound = (log, good) if change is None else (change, change.read_bytes())
        code, _, err = self.run_import(log, "--out", self.folder / f"good_{name}", *more)
        self.assertEqual(code, 0, err)
        for number in range(MUTATIONS):
            bad = mutated(sound, chance)
            target.write_bytes(bad)
            with self.subTest(name=name, number=number):
                try:
                    code, _, err = self.run_import(log, "--out", self.folder / f"out_{number}_{name}", *more)
                except BaseException:
                    if kept := os.environ.get("GUSTLAB_MUTATIONS_KEEP"):
                        (Path(kept) / f"{number}_{target.name}").write_bytes(bad)
                    raise
                self.assertIn(code, (0, 2, 3), err)
                # pymavlink says what it skips; a process of import's own sets that aside
                err = "\n".join(line for line in err.splitlines() if not line.startswith("Skipped "))
                if code != 0:
                    self.assertEqual(len(err.splitlines()), 1, err[:2000])
                    self.assertTrue(err.isprintable(), err[:2000])

    def test_tables(self):
        self.survive("log.csv", csv(flight(3.0)).encode(), "--map", self.map)

    def test_column_maps(self):
        self.survive("good.csv", csv(flight(3.0)).encode(), "--map", self.map, change=self.map)

    def test_parquet(self):
        import pyarrow
        import pyarrow.parquet
        path = self.folder / "made.parquet"
        pyarrow.parquet.write_table(pyarrow.table(flight(3.0)), path)
        self.survive("log.parquet", path.read_bytes(), "--map", self.write("p.toml", formats.ENU.format(kind="parquet")))

    def test_px4(self):
        self.survive("log.ulg", px4_flight(synthetic(8.0), armed=(0.0, 8.0), flying=(0.5, 7.5)).bytes())

    def test_telemetry(self):
        self.survive("log.tlog", formats.Telemetry.write_tlog(self, 20.0).read_bytes())

    def test_ardupilot(self):
        self.survive("log.bin", formats.DataFlash.write_log(self).read_bytes())

    def test_blackbox(self):
        self.survive("log.bbl", formats.blackbox(formats.Blackbox.columns(self)))

    def test_bags(self):
        for storage in ("bag", "SQLITE3", "MCAP"):
            made = formats.Bags.write_bag(self, flight(3.0), "b" + storage, storage)
            self.survive("log" + made.suffix, made.read_bytes(), "--map", self.write("m.toml", formats.Bags.MAP))

    def test_cards_of_a_crazyflie(self):
        columns = flight(6.0)
        names = {"stateEstimate.x": "x", "stateEstimate.y": "y", "stateEstimate.z": "z", "gyro.x": "gx", "gyro.y": "gy", "gyro.z": "gz",
                 "motor.m1": "m1", "motor.m2": "m2", "motor.m3": "m3", "motor.m4": "m4"}
        records = [(round(1e6 * t), *(float(columns[name][k]) for name in names.values())) for k, t in enumerate(columns["t"])]
        card_map = """format = "gustlab-column-map/1"
kind = "usd"
event = "fixedFrequency"
vehicle = "crazyflie"
[time]
column = "tick_s"
[position]
columns = ["stateEstimate.x", "stateEstimate.y", "stateEstimate.z"]
[rate]
columns = ["gyro.x", "gyro.y", "gyro.z"]
[actuator]
kind = "pwm"
columns = ["motor.m1", "motor.m2", "motor.m3", "motor.m4"]
"""
        self.survive("log.usd", usd(2, records, tuple((name, "f") for name in names)), "--map", self.write("c.toml", card_map))


if __name__ == "__main__":
    unittest.main()
