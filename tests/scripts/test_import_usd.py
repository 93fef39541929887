"""Crazyflie micro-SD logs: both versions, cut off, damaged, and not such logs at all."""

import struct
import unittest
import zlib

import numpy as np
from import_fixture import ImportCase, usd

MAP = """format = "gustlab-column-map/1"
kind = "usd"
event = "fixedFrequency"
vehicle = "crazyflie_real"
[time]
column = "tick_s"
zero = true
[actuator]
kind = "pwm"
columns = ["motor.m1", "motor.m2", "motor.m3", "motor.m4"]
[[extra]]
name = "roll_rate"
column = "gyro.x"
quantity = "rate"
unit = "deg/s"
[position]
columns = ["acc.z", "acc.z", "acc.z"]
"""


def records(count: int, ticks_per_step: int) -> list:
    rng = np.random.default_rng(5)
    return [(5000 + k * ticks_per_step, 1.0 + rng.normal(0, 0.01), 90.0 * np.sin(0.05 * k) + rng.normal(0, 0.5),
             *(int(m) for m in rng.integers(30000, 40000, 4))) for k in range(count)]


class Usd(ImportCase):
    def take(self, content: bytes, map_text: str = MAP, *more) -> tuple:
        return self.run_import(self.write("log00", content), "--map", self.write("usd.toml", map_text), "--out", self.out, *more)

    def check_values(self, version: int, ticks_per_step: int):
        rows = records(400, ticks_per_step)
        code, out, err = self.take(usd(version, rows))
        self.assertEqual((code, err), (0, ""))
        written = self.written("log00_1.csv")
        np.testing.assert_allclose(written["time_s"], 0.01 * np.arange(400), atol=1e-9)
        np.testing.assert_array_equal(written["u3"], [row[5] for row in rows])
        np.testing.assert_allclose(written["roll_rate"], np.radians([row[2] for row in rows]), rtol=1e-6)
        self.assertNotIn("ERROR", out)

    def test_version_1_counts_milliseconds(self):
        self.check_values(1, 10)

    def test_version_2_counts_microseconds(self):
        self.check_values(2, 10000)

    def test_records_of_another_type_are_passed_over(self):
        body = bytearray(usd(2, records(100, 10000))[:-4])
        first = len(usd(2, [])) - 4
        body[first:first] = struct.pack("<HQ", 7, 1)
        body += struct.pack("<I", zlib.crc32(bytes(body)))
        self.assertEqual(self.take(bytes(body))[0], 0)
        self.assertEqual(len(self.written("log00_1.csv")["time_s"]), 100)

    def test_cut_off_inside_a_record(self):
        content = usd(2, records(300, 10000))
        code, out, _ = self.take(content[:-15])
        self.assertEqual(code, 0)
        self.assertIn("ends inside a record and without its checksum", out)
        self.assertEqual(len(self.written("log00_1.csv")["time_s"]), 299)

    def test_cut_off_at_every_length_is_never_a_crash(self):
        content = usd(1, records(12, 10))
        for length in range(len(content)):
            self.out = self.folder / f"out_{length}"   # another log of the same name is not written over the first
            code, _, err = self.take(content[:length])
            self.assertIn(code, (0, 3), f"{length}: {err}")
            self.assertTrue(code == 0 or err.startswith(f"{self.folder / 'log00'}: byte ") or "too few" in err, f"{length}: {err}")

    def test_wrong_checksum(self):
        content = bytearray(usd(2, records(300, 10000)))
        content[-10] ^= 1
        code, _, err = self.take(bytes(content))
        self.assertEqual(code, 3)
        self.assertIn("checksum (CRC-32) does not fit", err)
        self.assertFalse(self.out.exists())

    def test_damage_inside(self):
        content = bytearray(usd(2, records(300, 10000)))
        first = len(usd(2, [])) - 4
        content[first + 26 * 22] ^= 0x55
        code, _, err = self.take(bytes(content))
        self.assertEqual(code, 3)
        self.assertIn("the file is damaged", err)

    def test_what_it_is_not(self):
        good = usd(2, records(50, 10000))
        cases = {"the first byte is not 0xBC": b"time,x\n1,2\n", "format version 3": good[:1] + b"\x03\x00" + good[3:],
                 "the header is cut off": good[:3], "no event type `fast`": good, "has no type letter":
                 good.replace(b"acc.z(f)", b"acc.z(?]")}
        for words, content in cases.items():
            text = MAP.replace('"fixedFrequency"', '"fast"') if "fast" in words else MAP
            code, _, err = self.take(content, text)
            self.assertEqual(code, 3, words)
            self.assertIn(words, err)

    def test_no_record(self):
        code, _, err = self.take(usd(2, []))
        self.assertEqual(code, 3)
        self.assertIn("no record of type `fixedFrequency`", err)


class WithoutAMap(ImportCase):
    def test_the_firmwares_names_are_known(self):
        import json
        t = np.arange(600) / 100.0
        noise = np.random.default_rng(7)
        records = [(round(1e6 * s), 1.0 + 0.01 * noise.normal(), 90.0 * np.sin(s) + 0.1 * noise.normal(),
                    *(int(v) for v in 40000 + 300 * noise.normal(size=4))) for s in t]
        names = (("acc.x", "f"), ("gyro.x", "f"), ("motor.m1", "H"), ("motor.m2", "H"), ("motor.m3", "H"), ("motor.m4", "H"),
                 ("gyro.y", "f"), ("gyro.z", "f"))
        rows = [(tick, a, g, *motors, g, g) for tick, a, g, *motors in records]
        code, out, err = self.run_import(self.write("log00", usd(2, rows, names)), "--out", self.out, "--format", "json")
        self.assertEqual((code, err), (0, ""))
        log = json.loads(out)["logs"][0]
        self.assertEqual((log["kind"], log["flights"][0]["rates_hz"]["body_rate"]), ("crazyflie-usd", 100))
        written = self.written("log00_1.csv")
        np.testing.assert_allclose(written["wx"], np.radians([row[2] for row in rows]), rtol=1e-6, atol=1e-7)

    def test_other_names_need_a_map(self):
        rows = [(1000 * k, 1.0, 2.0) for k in range(50)]
        code, _, err = self.run_import(self.write("log00", usd(2, rows, (("my.a", "f"), ("my.b", "f")))))
        self.assertEqual((code, "give a column map with --map" in err), (3, True), err)


if __name__ == "__main__":
    unittest.main()
