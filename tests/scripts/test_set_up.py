"""The set-up: exact pins, an environment that follows them, and scripts that run from anywhere and refuse nonsense."""

import os
import re
import subprocess
import sys
import tempfile
import unittest
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = [*sorted((ROOT / "scripts").glob("*.sh")), ROOT / ".ci" / "run"]
PIN = re.compile(r"([A-Za-z0-9._-]+)==([A-Za-z0-9.]+)")


def pins(name):
    """(package, version) of each line of a requirements file; None where a line is no exact pin"""
    lines = (ROOT / "scripts" / name).read_text(encoding="utf-8").splitlines()
    wanted = [line for line in lines if line and not line.startswith(("#", "-r "))]
    return [(match.groups() if (match := PIN.fullmatch(line)) else None, line) for line in wanted]


class Requirements(unittest.TestCase):
    def test_every_requirement_is_pinned_exactly(self):
        for name in ("requirements.txt", "requirements-test.txt"):
            self.assertGreater(len(pins(name)), 10)
            for pin, line in pins(name):
                self.assertIsNotNone(pin, f"{name}: {line}")

    def test_mujoco_is_the_version_that_cmake_asks_for(self):
        asked = re.search(r"find_package\(MuJoCo (\S+) EXACT", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))
        self.assertIn(("mujoco-core", asked.group(1)), [pin for pin, _ in pins("requirements.txt")])

    @unittest.skipUnless(Path(sys.prefix).resolve() == (ROOT / ".venv").resolve(), "not run by .venv/bin/python")
    def test_environment_follows_the_pins(self):
        wanted = {pin for name in ("requirements.txt", "requirements-test.txt") for pin, _ in pins(name)}
        normal = {(re.sub(r"[-_.]+", "-", name).lower(), version) for name, version in wanted}
        found = {(re.sub(r"[-_.]+", "-", dist.name).lower(), dist.version) for dist in metadata.distributions()}
        self.assertEqual(normal - found, set())


class Scripts(unittest.TestCase):
    def test_each_is_executable_and_strict(self):
        for script in SCRIPTS:
            self.assertTrue(os.access(script, os.X_OK), script.name)
            self.assertIn("\nset -euo pipefail\n", script.read_text(encoding="utf-8"), script.name)
            self.assertEqual(subprocess.run(["bash", "-n", str(script)], check=False).returncode, 0, script.name)

    def test_wrong_arguments_are_usage_errors_from_any_directory(self):
        with tempfile.TemporaryDirectory() as elsewhere:
            for name, argument in (("setup.sh", "--tests"), ("build.sh", "fast"), ("clean_room.sh", "no_such_branch")):
                done = subprocess.run([str(ROOT / "scripts" / name), argument], cwd=elsewhere, capture_output=True,
                                      text=True, check=False)
                self.assertEqual(done.returncode, 2, name)
                self.assertTrue(done.stderr.startswith(("usage: ", "clean_room: ")), done.stderr)
                self.assertEqual(os.listdir(elsewhere), [])


if __name__ == "__main__":
    unittest.main()
