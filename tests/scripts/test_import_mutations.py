"""Logs of every kind and column maps, damaged by Hypothesis: an answer with exit 0, 2 or 3, one line for what is wrong, and never a traceback.

GUSTLAB_MUTATIONS: how many of each kind; GUSTLAB_MUTATIONS_SEED: others. What fails is printed, as the list of what was done to the good file."""

import os
import unittest

import test_import_formats as formats
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st
from import_fixture import MAP, ImportCase, csv, flight, usd
from test_import_px4 import synthetic
from ulog_fixture import px4_flight

MUTATIONS = int(os.environ.get("GUSTLAB_MUTATIONS", "12"))
SEED = os.environ.get("GUSTLAB_MUTATIONS_SEED", "1")
WORDS = (b"", b"\0", b"\xff" * 4, b"\r", b"\n", b",", b'"', b"nan", b"inf", b"-1e999", b"1e308", b"[" * 2000, b"{", b"a." * 300, b"\xc3", b"0" * 200, b"\x7f\xff\xff\xff")


def damages(length: int):
    """One to five of: bytes changed, a piece cut out, repeated, moved, or a word in its place, or the end cut off.

    Half of it is where files say what they are."""
    anywhere = st.integers(0, max(0, length - 1))
    place = st.integers(0, min(length, 400) - 1) | anywhere
    piece = st.sampled_from((1, 2, 4, 8, 60, 1000))
    return st.lists(st.one_of(
        st.tuples(st.just("change"), place, st.binary(min_size=1, max_size=60)),
        st.tuples(st.just("cut out"), place, piece),
        st.tuples(st.just("repeat"), place, piece, st.sampled_from((1, 50))),
        st.tuples(st.just("move"), place, piece, anywhere),
        st.tuples(st.just("word"), place, st.sampled_from((0, 1, 60)), st.sampled_from(WORDS)),
        st.tuples(st.just("end"), place)), min_size=1, max_size=5)


def damaged(good: bytes, damage) -> bytes:
    bad = bytearray(good)
    for kind, at, *what in damage:
        if kind == "change":
            bad[at:at + len(what[0])] = what[0]
        elif kind == "cut out":
            del bad[at:at + what[0]]
        elif kind == "repeat":
            bad[at:at] = bad[at:at + what[0]] * what[1]
        elif kind == "move":
            piece = bad[at:at + what[0]]
            del bad[at:at + what[0]]
            bad[what[1]:what[1]] = piece
        elif kind == "word":
            bad[at:at + what[0]] = what[1]
        else:
            del bad[at:]
    return bytes(bad)


class Mutations(ImportCase):
    LAYOUT = formats.DataFlash.LAYOUT

    def survive(self, name: str, good: bytes, *more, change=None):
        """`change`: the file to damage, when it is not the log"""
        log = self.write(name, good)
        victim, sound = (log, good) if change is None else (change, change.read_bytes())
        code, _, err = self.run_import(log, "--out", self.folder / f"good_{name}", *more)
        self.assertEqual(code, 0, err)
        outs = iter(range(10**9))

        @seed(f"{SEED} {name}")
        @settings(max_examples=MUTATIONS, database=None, deadline=None, phases=(Phase.generate,), suppress_health_check=list(HealthCheck), print_blob=False)
        @given(damages(len(sound)))
        def answers(damage):
            victim.write_bytes(damaged(sound, damage))
            code, _, err = self.run_import(log, "--out", self.folder / f"out_{next(outs)}_{name}", *more)
            self.assertIn(code, (0, 2, 3), err)
            if code != 0:
                self.assertEqual(len(err.splitlines()), 1, err[:2000])
                self.assertTrue(err.removesuffix("\n").isprintable(), err[:2000])

        answers()

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
