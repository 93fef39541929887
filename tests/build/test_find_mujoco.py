"""FindMuJoCo: each place it looks in, the version check, and what it says when MuJoCo is missing."""

import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

MODULE = Path(__file__).resolve().parents[2] / "cmake" / "FindMuJoCo.cmake"
PROJECT = """
cmake_minimum_required(VERSION 3.25)
project(probe LANGUAGES CXX)
list(APPEND CMAKE_MODULE_PATH ${CMAKE_SOURCE_DIR}/cmake)
find_package(MuJoCo 4.0.1 EXACT REQUIRED)
if(TARGET mujoco::mujoco)
  message(STATUS "from the package")
else()
  get_target_property(place MuJoCo::MuJoCo IMPORTED_LOCATION)
  message(STATUS "from ${place} ${MuJoCo_VERSION}")
endif()
"""


class FindMuJoCo(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        (self.root / "cmake").mkdir()
        shutil.copy(MODULE, self.root / "cmake")
        (self.root / "CMakeLists.txt").write_text(PROJECT)

    def release(self, place, number, library):
        """lays out a MuJoCo release whose headers carry `number`"""
        header = self.root / place / "include" / "mujoco" / "mujoco.h"
        header.parent.mkdir(parents=True)
        header.write_text(f"#define mjVERSION_HEADER {number}\n")
        path = self.root / place / library
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("")
        return path

    def configure(self, *options, **environment):
        clean = {key: value for key, value in os.environ.items() if key != "MUJOCO_ROOT"}
        done = subprocess.run(
            ["cmake", "-S", str(self.root), "-B", str(self.root / "out"), "-G", "Ninja", *options],
            env=clean | environment, capture_output=True, text=True)
        return done.returncode, " ".join((done.stdout + done.stderr).split())

    def test_missing_says_what_to_do(self):
        code, text = self.configure()
        self.assertNotEqual(code, 0)
        self.assertIn("Could NOT find MuJoCo", text)
        self.assertIn("Run scripts/setup.sh, or set MUJOCO_ROOT to a MuJoCo 4.0.1 release", text)

    def test_wheel_in_the_environment_of_the_repository(self):
        path = self.release(".venv/lib/python3.11/site-packages/mujoco", 4000001, "libmujoco.so.4.0.1")
        code, text = self.configure()
        self.assertEqual(code, 0, text)
        self.assertIn(f"from {path} 4.0.1", text)

    def test_root_goes_before_the_wheel(self):
        self.release(".venv/lib/python3.11/site-packages/mujoco", 4000001, "libmujoco.so.4.0.1")
        path = self.release("elsewhere", 4000001, "lib/libmujoco.so")
        for options, environment in (
            ([f"-DMUJOCO_ROOT={self.root}/elsewhere"], {}),
            ([], {"MUJOCO_ROOT": f"{self.root}/elsewhere"}),
        ):
            code, text = self.configure("--fresh", *options, **environment)
            self.assertEqual(code, 0, text)
            self.assertIn(f"from {path} 4.0.1", text)

    def test_package_goes_before_the_wheel_unless_its_version_differs(self):
        wheel = self.release(".venv/lib/python3.11/site-packages/mujoco", 4000001, "libmujoco.so.4.0.1")
        package = self.root / "prefix" / "lib" / "cmake" / "mujoco"
        (self.root / "prefix" / "include").mkdir(parents=True)
        package.mkdir(parents=True)
        (package / "mujocoConfig.cmake").write_text(
            "add_library(mujoco::mujoco INTERFACE IMPORTED)\n"
            f"target_include_directories(mujoco::mujoco INTERFACE {self.root}/prefix/include)\n")
        for version, expected in (("4.0.1", "from the package"), ("3.3.7", f"from {wheel}")):
            (package / "mujocoConfigVersion.cmake").write_text(
                f"set(PACKAGE_VERSION {version})\n"
                "if(PACKAGE_VERSION VERSION_EQUAL PACKAGE_FIND_VERSION)\n  set(PACKAGE_VERSION_EXACT TRUE)\n"
                "  set(PACKAGE_VERSION_COMPATIBLE TRUE)\nendif()\n")
            code, text = self.configure("--fresh", f"-DCMAKE_PREFIX_PATH={self.root}/prefix")
            self.assertEqual(code, 0, text)
            self.assertIn(expected, text)

    def test_another_version_is_refused(self):
        for number, version, place in ((337, "3.3.7", "old"), (4001000, "4.1.0", "new")):
            self.release(place, number, "lib/libmujoco.so")
            code, text = self.configure("--fresh", f"-DMUJOCO_ROOT={self.root}/{place}")
            self.assertNotEqual(code, 0)
            self.assertIn(f'Found unsuitable version "{version}", but required is exact version "4.0.1"', text)
            self.assertIn("unset it to use .venv (scripts/setup.sh), or name a MuJoCo 4.0.1 release", text)


if __name__ == "__main__":
    unittest.main()
