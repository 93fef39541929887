"""What an import says while it takes long, by a clock of the test's own."""

import io
import unittest
from pathlib import Path
from unittest.mock import patch

import test_import_formats as formats
from import_fixture import MAP, ImportCase, cli, csv, flight, progress, usd
from test_import_px4 import synthetic
from ulog_fixture import px4_flight

from gustlab_import.column_map import load_map
from gustlab_import.from_table import read_table
from gustlab_import.kinds import kind_of, reader_of


class Clock:
    now = 100.0

    def __call__(self):
        return self.now


class Terminal(io.StringIO):
    def isatty(self):
        return True


class Said(ImportCase):
    def setUp(self):
        super().setUp()
        started = patch.object(progress, "FIRST_s", 2.0)
        started.start()
        self.addCleanup(started.stop)
        self.clock, self.done = Clock(), 0.0
        self.log = self.write("a.ulg", bytes(2_140_000))

    def logs(self, count=1, stream=None, quiet=False):
        self.stream = stream or io.StringIO()
        return progress.LogProgress(count, quiet, self.clock, self.stream)

    def after(self, logs, *seconds):
        """What is said when the thread looks at these times of the clock."""
        for now in seconds:
            self.clock.now = 100.0 + now
            logs.look()
        return self.stream.getvalue()

    def test_nothing_within_two_seconds_then_a_line_every_half_minute(self):
        logs = self.logs()
        self.assertEqual(self.after(logs, 3.0), "")   # no log has begun
        self.clock.now = 100.0
        logs = self.logs()
        logs.begin(self.log)
        self.assertEqual(self.after(logs, 0.1, 1.9), "")
        self.assertEqual(self.after(logs, 2.0, 2.1, 31.9), "reading a.ulg (2.1 MB)\n")
        self.assertEqual(self.after(logs, 32.0, 61.0), "reading a.ulg (2.1 MB)\n" * 2)

    def test_other_work_says_its_first_line_after_half_a_minute(self):
        stream = io.StringIO()
        work = progress.Progress("pictures", clock=self.clock, stream=stream)
        for now in (5.0, 29.0, 30.0, 31.0, 60.0):
            self.clock.now = 100.0 + now
            work.show(round(now), 120)
        self.assertEqual(stream.getvalue(), "30/120 pictures, 90 s left\n60/120 pictures, 60 s left\n")

    def test_a_terminal_s_line_is_written_over(self):
        logs = self.logs(stream=Terminal())
        logs.begin(self.log)
        with patch.object(progress.LogProgress, "current", logs):
            progress.stage("reading", lambda: self.done)
            self.done = 0.25
            self.after(logs, 2.0, 2.05)
            self.done = 0.5
            self.after(logs, 2.25)
            progress.stage("checking")
            self.after(logs, 2.5)
        logs.progress.end()
        self.assertEqual(self.stream.getvalue(), "\rreading a.ulg (2.1 MB), 25 %\033[K\rreading a.ulg (2.1 MB), 50 %\033[K\rchecking a.ulg (2.1 MB)\033[K\n")

    def test_of_several_logs_the_number_is_said(self):
        logs = self.logs(3)
        logs.begin(self.log)
        logs.begin(Path("b\x1b.ulg"))
        self.assertEqual(self.after(logs, 5.0), "log 2 of 3: reading b\\x1b.ulg\n")

    def test_quiet_and_closed_say_nothing(self):
        logs = self.logs(quiet=True)
        logs.begin(self.log)
        self.assertEqual(self.after(logs, 5.0), "")
        with patch("sys.stderr", None):
            logs = progress.LogProgress(1, clock=self.clock)
            logs.begin(self.log)
            self.clock.now += 5.0
            logs.look()

    def test_a_file_that_its_reader_closed_tells_no_share(self):
        logs, file = self.logs(), io.BytesIO(b"ab")
        logs.begin(self.log)
        logs.share = file.tell
        file.close()
        self.assertEqual(self.after(logs, 2.0), "reading a.ulg (2.1 MB)\n")


class Import(ImportCase):
    def test_an_import_begins_each_log_and_ends(self):
        log, begun = self.write("log.csv", csv(flight())), []
        with patch.object(progress.LogProgress, "begin", lambda logs, path: begun.append((path, progress.LogProgress.current is logs))):
            self.assertEqual(self.run_import(log, "--map", self.map)[0], 0)
            self.assertEqual(self.run_import(self.write("a.xyz", "?"))[0], 2)
        self.assertEqual(begun, [(log, True), (self.folder / "a.xyz", True)])
        self.assertIsNone(progress.LogProgress.current)


class Told:
    """Stands for a LogProgress: asks for the share as soon as a reader offers it."""

    def __init__(self):
        self.doing, self.shares = [], []

    def __setattr__(self, name, value):
        if name == "share" and value is not None:
            self.shares.append(value())
        elif name == "doing" and isinstance(value, str):
            self.doing.append(value)
        else:
            super().__setattr__(name, value)


class Readers(ImportCase):
    def other(self, case):
        """A case of other tests that writes logs."""
        one = case("setUp")
        one.setUp()
        self.addCleanup(one.doCleanups)
        return one

    def test_readers_tell_how_much_is_read(self):
        logs = {"ulog": self.write("a.ulg", px4_flight(synthetic()).bytes()), "dataflash": self.other(formats.DataFlash).write_log(),
                "tlog": self.other(formats.Telemetry).write_tlog(10.0), "bag": self.other(formats.Bags).write_bag(flight(3.0), "bag", "bag"),
                "blackbox": self.write("a.bfl", formats.blackbox(formats.Blackbox("setUp").columns())),
                "csv": self.write("a.csv", csv(flight(3.0))),
                "usd": self.write("a.usd", usd(2, [(1000 * k, 1.0, 0.1, 1, 2, 3, 4) for k in range(9)]))}
        maps = {kind: self.write(f"{kind}.toml", MAP.replace('"csv"', f'"{kind}"\nevent = "fixedFrequency"')) for kind in ("csv", "usd")}
        for kind, log in logs.items():
            with self.subTest(kind), patch.object(progress.LogProgress, "current", Told()) as told:
                if kind in maps:
                    read_table(log, load_map(str(maps[kind])))
                else:
                    reader_of(kind_of(log), log)(log)
                self.assertEqual(set(told.doing), {"reading"})
                self.assertTrue(told.shares and all(0.0 <= share <= 1.0 for share in told.shares), told.shares)


if __name__ == "__main__":
    unittest.main()
