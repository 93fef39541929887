"""A log that is longer than what a command keeps of it in memory."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

PROGRAM = os.environ["GUSTLAB_PROGRAM"]
INSTRUMENTED = any(mark in Path(PROGRAM).read_bytes() for mark in (b"__asan_init", b"__tsan_init"))

COLUMNS = ("time_s px py pz rpx rpy rpz vx vy vz rvx rvy rvz qw qx qy qz wx wy wz ax ay az vbat " + " ".join(f"u{i}" for i in range(1, 9)) + " "
           + " ".join(f"rotor{i}" for i in range(1, 9)) + " a b c d").split()
ROWS = 300_000  # numbers of them are 106 MB


# a small process between, since a child's peak begins with that of its parent
MEASURE = ("import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL); "
           "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)")


def peak_mb(*arguments):
    """Of the program with these arguments."""
    return int(subprocess.run([sys.executable, "-S", "-c", MEASURE, PROGRAM, *arguments], capture_output=True, check=True).stdout) / 1024


class LongLog(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="gustlab_test_")
        self.addCleanup(folder.cleanup)
        self.log = str(Path(folder.name) / "long.csv")
        row = ",".join("1" if name == "qw" else "0" if name[0] in "rqw" else "0.5" for name in COLUMNS[1:])
        with open(self.log, "w", encoding="ascii") as file:
            file.write(",".join(COLUMNS) + "\n")
            for begin in range(0, ROWS, 10_000):
                file.write("".join(f"{i}e-3,{row}\n" for i in range(begin, begin + 10_000)))
        Path(self.log).with_suffix(".meta.toml").write_text('format = "gustlab-flight/1"\nvehicle = "crazyflie"\nactuator = "rotor_speed"\n')

    @unittest.skipIf(INSTRUMENTED, "memory of a sanitizer is its own")
    def test_metrics_keeps_little_of_it(self):
        self.assertLess(peak_mb("metrics", self.log), 70)

    def test_metrics_counts_every_row(self):
        done = subprocess.run([PROGRAM, "metrics", self.log], capture_output=True, text=True, check=True)
        self.assertIn(f"| 3-D | {ROWS} | 0.8660 | 0.8660 | 0.8660 | 0.8660 |", done.stdout)


if __name__ == "__main__":
    unittest.main()
