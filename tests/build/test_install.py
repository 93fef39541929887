"""`cmake --install`: a tree that can be moved, with completions that complete and a library that others can build on."""

import os
import re
import shutil
import subprocess
import unittest
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ["GUSTLAB_PROGRAM"])


def output(*command, **more):
    return subprocess.run([str(word) for word in command], capture_output=True, text=True, check=True, timeout=600, **more).stdout


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        made = Path(cls.folder.name, "made")
        # component by component would miss what has none
        output("cmake", "--install", PROGRAM.parent, "--prefix", made)
        cls.tree = made.rename(Path(cls.folder.name, "moved"))
        cls.program = cls.tree / "bin" / "gustlab"

    def test_it_flies_where_it_was_moved_to(self):
        environment = {key: value for key, value in os.environ.items() if key != "GUSTLAB_HOME"}
        said = output(self.program, "vehicle", "check", "crazyflie", env=environment)
        self.assertIn("contradictions        none", said)
        self.assertIn("gustlab-vehicle/1", output(self.program, "defaults", "vehicle", env=environment))

    def test_man_page_tells_every_command(self):
        page = (self.tree / "share/man/man1/gustlab.1").read_text(encoding="utf-8")
        for command in ("sweep", "diagnose", "vehicle new", "vehicle fit"):
            self.assertIn(f".SS gustlab {command}\n", page)
        self.assertTrue(page.startswith(".TH GUSTLAB 1"))

    def complete(self, *words):
        script = self.tree / "share/bash-completion/completions/gustlab"
        quoted = " ".join(f"'{word}'" for word in words)
        return output("bash", "-c", f'source "{script}"; COMP_WORDS=({quoted}); COMP_CWORD={len(words) - 1}; _gustlab; echo "${{COMPREPLY[@]}}"').split()

    def test_bash_completes_commands_options_and_choices(self):
        self.assertEqual(self.complete("gustlab", "swe"), ["sweep"])
        self.assertEqual(set(self.complete("gustlab", "vehicle", "")) & {"new", "check", "fit"}, {"new", "check", "fit"})
        self.assertEqual(self.complete("gustlab", "vehicle", "new", "--thr"), ["--thrust-to-weight", "--throttle-curve"])
        self.assertEqual(set(self.complete("gustlab", "table", "out", "--format", "")), {"md", "csv", "latex", "json", "html"})

    def test_options_of_the_commands_in_python_are_told_too(self):
        self.assertEqual(self.complete("gustlab", "import", "--keep"), ["--keep-unusable", "--keep-position"])
        self.assertEqual(set(self.complete("gustlab", "import", "a.ulg", "--format", "")), {"text", "json"})
        self.assertEqual(self.complete("gustlab", "render", "flight", "--sp"), ["--speed"])
        page = (self.tree / "share/man/man1/gustlab.1").read_text(encoding="utf-8")
        for command in ("import", "export", "render", "view"):
            said = output(self.program, command, "--help", env=os.environ | {"COLUMNS": "10000"})
            words = re.findall(r"(?m)^  (--[a-z-]+)", said)
            section = page.split(f".SS gustlab {command}\n")[1].split(".SS ")[0].replace("\\-", "-")
            self.assertEqual(re.findall(r"(?m)^\.B (--[a-z-]+)", section), words, command)

    def test_other_shells_take_their_completions(self):
        for shell, name in (("zsh", "zsh/site-functions/_gustlab"), ("fish", "fish/vendor_completions.d/gustlab.fish")):
            script = self.tree / "share" / name
            self.assertIn("thrust-to-weight", script.read_text(encoding="utf-8"))
            if shutil.which(shell):
                output(shell, "-n", script)
        # words that stand for themselves, and what an explanation holds of brackets and colons
        zsh = (self.tree / "share/zsh/site-functions/_gustlab").read_text(encoding="utf-8")
        self.assertIn("'*:word:(bash zsh fish)'", zsh)
        self.assertIn("default: estimated", zsh)
        if shutil.which("fish"):
            fish = lambda words: output("fish", "-c", f"source {script}; complete -C '{words}'").split("\n")  # noqa: E731
            self.assertEqual([line.split("\t")[0] for line in fish("gustlab vehicle new --thr") if line], ["--throttle-curve", "--thrust-to-weight"])
            self.assertEqual([line.split("\t")[0] for line in fish("gustlab completion ba") if line], ["bash"])

    def test_an_own_program_builds_on_it(self):
        build = Path(self.folder.name, "hover")
        # a library that was built with sanitizers needs them in every program
        cache = (PROGRAM.parent / "CMakeCache.txt").read_text(encoding="utf-8")
        kind = re.search(r"(?m)^CMAKE_BUILD_TYPE:\w+=(\w+)$", cache)[1].upper()
        sanitizers = re.findall(r"-f(?:no-)?sanitize\S+", re.search(rf"(?m)^CMAKE_CXX_FLAGS_{kind}:\w+=(.*)$", cache)[1])
        output("cmake", "-S", ROOT / "examples" / "hover", "-B", build, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={self.tree}", "-DCMAKE_BUILD_TYPE=Release",
               f"-DCMAKE_CXX_FLAGS={' '.join(sanitizers)}")
        output("cmake", "--build", build)
        said = output(build / "hover", "crazyflie", env=os.environ | {"GUSTLAB_HOME": str(self.tree / "share/gustlab")})
        where = re.match(r"crazyflie is at \((\S+), (\S+), (\S+)\) m after 5.0 s", said)
        self.assertIsNotNone(where, said)
        for flown_m, wanted_m in zip(map(float, where.groups()), (0.5, 0.0, 1.5)):
            self.assertAlmostEqual(flown_m, wanted_m, delta=0.01)


if __name__ == "__main__":
    unittest.main()
