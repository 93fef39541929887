"""docs/tutorials: every command works, and the templates of `add your own` compile."""

import json
import os
import re
import shlex
import shutil
import subprocess
import unittest
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ["GUSTLAB_PROGRAM"]


def commands(page):
    """The shell blocks of a page, in order."""
    return re.findall(r"^```sh\n(.*?)^```", (ROOT / "docs" / "tutorials" / page).read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


def drawn(page):
    """The commands in the text of a page that draw what its blocks have flown."""
    text = (ROOT / "docs" / "tutorials" / page).read_text(encoding="utf-8")
    return [command.replace("scripts/", f"{ROOT}/scripts/") for command in re.findall(r"`(scripts/plot_[^`]+ [^`]+|gustlab render [^`]+)`", text)]


class Tutorials(unittest.TestCase):
    def setUp(self):
        folder = TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "bin").mkdir()
        (self.folder / "bin" / "gustlab").symlink_to(PROGRAM)

    def run_page(self, page):
        """What the blocks print, run one after the other in one folder."""
        environment = os.environ | {"PATH": f"{self.folder / 'bin'}:{os.environ['PATH']}"}
        printed = []
        self.assertTrue(drawn(page))
        for block in commands(page) + drawn(page):
            done = subprocess.run(["bash", "-euo", "pipefail", "-c", block], cwd=self.folder, env=environment, capture_output=True, text=True, check=False,
                                  timeout=900)
            self.assertEqual(done.returncode, 0, block + done.stderr)
            printed.append(done.stdout)
        self.assertGreater(len(printed), 1)
        return printed

    def test_compare_controllers(self):
        printed = self.run_page("compare_controllers.md")
        self.assertEqual(printed[1].count("| crazyflie |"), 6)
        self.assertTrue((self.folder / "flight" / "flight.csv").exists())

    @pytest.mark.slow
    def test_diagnose_a_flight(self):
        self.run_page("diagnose_a_flight.md")
        found = json.loads((self.folder / "diagnosis" / "diagnosis.json").read_text(encoding="utf-8"))
        sizes = {effect["effect"]: effect["parameters"] for effect in found["effects"]}
        self.assertIn("rotor_drag", sizes)
        self.assertTrue({"mass", "thrust_scale"} & set(sizes), sizes)

    def test_the_three_doors_lead_somewhere(self):
        text = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
        links = re.findall(r"\]\(([^)]+)\)", text)
        self.assertGreater(len(links), 8)
        for link in links:
            self.assertTrue((ROOT / "docs" / link).exists(), link)


class AddYourOwn(unittest.TestCase):
    def add(self, tree, *arguments):
        return subprocess.run([str(ROOT / "scripts" / "new_plugin.py"), *arguments, "--tree", str(tree)], capture_output=True, text=True, check=False)

    def tree(self):
        folder = TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        for name in ("src/controllers", "src/effects", "src/trajectories", "examples"):
            shutil.copytree(ROOT / name, Path(folder.name) / name)
        return Path(folder.name)

    def test_each_template_compiles_with_its_row(self):
        tree = self.tree()
        # names that classes of the program have, too
        for kind, place, name in (("controller", "controllers", "offboard"), ("effect", "effects", "wrench"), ("trajectory", "trajectories", "jet")):
            done = self.add(tree, kind, name)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            for source in (f"{name}.cpp", "registry.cpp"):
                subprocess.run(["c++", "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Wshadow", "-Werror", f"-I{tree}/src", f"-I{ROOT}/include",
                                f"-I{ROOT}/src", "-isystem", "/usr/include/eigen3", str(tree / "src" / f"{place}" / source)],
                               check=True, timeout=600)
            self.assertEqual(self.add(tree, kind, name).returncode, 2)

    def test_the_commands_of_the_page_and_rows_that_the_contract_tests_accept(self):
        tree = self.tree()
        page = (ROOT / "docs" / "tutorials" / "add_your_own.md").read_text(encoding="utf-8")
        lines = re.findall(r"^scripts/new_plugin\.py (.*)$", page, re.MULTILINE)
        self.assertEqual(sorted(line.split()[0] for line in lines), ["controller", "effect", "trajectory"])
        for line in lines:
            self.assertEqual(self.add(tree, *shlex.split(line)).returncode, 0, line)
        for path in tree.rglob("registry.cpp"):
            self.assertEqual(re.findall(r"\.(?:says|source|shows_in) = \"\"", path.read_text(encoding="utf-8")), [])

    def test_what_is_written_is_formatted_whatever_the_lengths(self):
        tree = self.tree()
        for kind in ("controller", "effect", "trajectory"):
            for name, says in ((f"z_{kind}", "short"), (f"of_a_long_name_that_leaves_no_room_{kind}", "a sentence of what it does " * 6)):
                self.assertEqual(self.add(tree, kind, name, "--says", says.strip()).returncode, 0)
        written = [str(path) for path in tree.rglob("*.?pp") if not (ROOT / path.relative_to(tree)).exists()
                   or path.read_bytes() != (ROOT / path.relative_to(tree)).read_bytes()]
        self.assertEqual(len(written), 6 + 3 + 3)
        done = subprocess.run([ROOT / ".venv" / "bin" / "clang-format", f"--style=file:{ROOT}/.clang-format", "--dry-run", "--Werror", *written], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_wrong_names_are_refused(self):
        tree = self.tree()
        before = sorted(tree.rglob("*"))
        for arguments in (("controller", "My Law"), ("controller", "pid"), ("effect", "pid"), ("effect", "effect"), ("plant", "mine"),
                          ("effect", "mine", "--says", 'a "b"')):
            self.assertEqual(self.add(tree, *arguments).returncode, 2, arguments)
        self.assertEqual(sorted(tree.rglob("*")), before)
        with TemporaryDirectory() as empty:
            self.assertEqual(self.add(empty, "controller", "mine").returncode, 2)
            self.assertEqual(os.listdir(empty), [])

    @unittest.skipUnless(os.environ.get("GUSTLAB_ADD_YOUR_OWN"), "builds the whole program: the target `add_your_own` does it")
    def test_the_page_builds_and_flies_a_controller_an_effect_and_a_trajectory(self):
        folder = TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        tree = Path(folder.name) / "gustlab"
        shutil.copytree(ROOT, tree, ignore=lambda place, names: {".git", ".venv", "build", "out"} & set(names) if place == str(ROOT) else set())
        (tree / ".venv").symlink_to(ROOT / ".venv")
        page = (tree / "docs" / "tutorials" / "add_your_own.md").read_text(encoding="utf-8")
        blocks = re.findall(r"^```\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
        self.assertEqual(len(blocks), 3)
        mine = re.search(r"cat > mine\.toml.*?^END$", commands("compare_controllers.md")[0], re.MULTILINE | re.DOTALL)[0]
        environment = os.environ | {"PATH": f"{tree}/build/release:{os.environ['PATH']}"}
        for block in (mine, *blocks):
            done = subprocess.run(["bash", "-euo", "pipefail", "-c", block], cwd=tree, env=environment, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, block + done.stdout[-3000:] + done.stderr)
        # each has flown, and the spring pulls
        self.assertEqual(json.loads((tree / "flight" / "outcome.json").read_text(encoding="utf-8"))["outcome"], "completed")
        self.assertEqual(json.loads((tree / "flight_of_both" / "outcome.json").read_text(encoding="utf-8"))["outcome"], "completed")
        weak = ["gustlab", "run", "mine.toml", "--set", 'trajectories=["to_and_fro"]', "--trajectory", "to_and_fro", "--controller", "pid",
                "--set", "effect.spring.stiffness=0", "--out", "without"]
        subprocess.run(weak, cwd=tree, env=environment, check=True)
        self.assertNotEqual((tree / "without" / "flight.csv").read_bytes(), (tree / "flight_of_both" / "flight.csv").read_bytes())


if __name__ == "__main__":
    unittest.main()
