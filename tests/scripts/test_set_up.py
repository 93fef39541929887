"""The set-up: exact pins, an environment that follows them, and scripts that run from anywhere and refuse nonsense."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = [*sorted((ROOT / "scripts").glob("*.sh")), ROOT / ".ci" / "run"]
HELP = """
import runpy, sys
from pathlib import Path
scripts, elsewhere = sys.argv[1], sys.path[1:]
for program in sys.argv[2:]:
    # none finds the project's modules by what another one has done
    for name in [name for name, module in sys.modules.items() if (getattr(module, "__file__", None) or "").startswith(scripts)]:
        del sys.modules[name]
    sys.argv, sys.path = [program, "--help"], [str(Path(program).parent), *elsewhere]
    try:
        runpy.run_path(program, run_name="__main__")
    except SystemExit as end:
        assert not end.code, program
    print(end="\\0")
"""
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

    def test_help_says_how_each_is_used_and_does_nothing(self):
        for script in [*SCRIPTS, *sorted((ROOT / "scripts" / "cluster").glob("*.sh"))]:
            done = subprocess.run([str(script), "--help"], capture_output=True, text=True, check=False)
            self.assertEqual((done.returncode, done.stderr), (0, ""), script.name)
            self.assertGreater(len(done.stdout), 40, script.name)
        programs = [path for path in sorted((ROOT / "scripts").rglob("*.py")) if "__main__" in path.read_text(encoding="utf-8")]
        self.assertGreater(len(programs), 5)
        # in one process: packages that they import are read once
        done = subprocess.run([sys.executable, "-c", HELP, str(ROOT / "scripts"), *map(str, programs)], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        said = done.stdout.split("\0")
        self.assertEqual(len(said), len(programs) + 1)
        for program, text in zip(programs, said):
            self.assertTrue(text.startswith("usage: "), program.name)

    def test_figures_are_drawn_in_the_project_environment_whoever_starts_them(self):
        for script in sorted((ROOT / "scripts").glob("*.py")):
            if "__main__" in script.read_text(encoding="utf-8"):
                done = subprocess.run(["/usr/bin/python3", str(script), "--help"], capture_output=True, text=True, check=False)
                self.assertEqual((done.returncode, done.stderr), (0, ""), script.name)

    def test_a_build_tree_of_another_place_is_configured_again(self):
        with tempfile.TemporaryDirectory() as folder:
            tree, tools = Path(folder, "tree"), Path(folder, "tools")
            (tree / "scripts").mkdir(parents=True)
            build = tree / "build" / "release"
            build.mkdir(parents=True)
            tools.mkdir()
            shutil.copy(ROOT / "scripts" / "build.sh", tree / "scripts")
            (tools / "cmake").write_text('#!/bin/sh\necho "$*"\n', encoding="utf-8")
            (tools / "cmake").chmod(0o755)
            environment = os.environ | {"PATH": f"{tools}:{os.environ['PATH']}"}
            for home, configured in ((tree, False), (Path("/elsewhere"), True)):
                (build / "CMakeCache.txt").write_text(f"CMAKE_HOME_DIRECTORY:INTERNAL={home}\n", encoding="utf-8")
                (build / "build.ninja").touch()
                done = subprocess.run([str(tree / "scripts" / "build.sh")], env=environment, capture_output=True, text=True, check=True)
                self.assertEqual("--preset release --log-level" in done.stdout, configured)
                self.assertEqual((build / "CMakeCache.txt").exists(), not configured)


if __name__ == "__main__":
    unittest.main()
