"""The layer rule: which folder under src/ may include which, the rooms of the diagnosis, and where third-party headers may appear."""

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)

# each folder may include itself, include/gustlab, util and what stands here; the order is from the bottom up
FOUNDATION = {"config", "flight_log", "metrics"}
PLUGINS = {"effects", "trajectories", "controllers"}
ALLOWED = {
    "util": set(),
    "config": set(),
    "flight_log": {"config"},
    "metrics": {"config", "flight_log"},
    "vehicle": FOUNDATION,
    "plant": FOUNDATION | {"vehicle"},
    "control": set(),
    "effects": FOUNDATION | {"control"},
    "trajectories": FOUNDATION | {"control"},
    "controllers": FOUNDATION | {"control"},
    "simulation": FOUNDATION | PLUGINS | {"vehicle", "plant", "control"},
    "sweep": FOUNDATION | PLUGINS | {"vehicle", "simulation"},
    "calibration": FOUNDATION | {"simulation", "sweep"},
    "identification": FOUNDATION | {"control"},
    "learning": FOUNDATION | PLUGINS | {"vehicle", "control", "identification", "simulation"},
    "diagnosis": FOUNDATION | PLUGINS | {"vehicle", "plant", "control", "identification", "simulation"},
    "report": FOUNDATION | {"sweep", "calibration", "learning", "identification", "diagnosis"},
}

# the rooms of src/diagnosis from the bottom up: each may include itself and those before it; the files beside them stand on top
DIAGNOSIS_ROOMS = ("result", "recording", "model", "estimation", "alignment", "selection", "rollout", "validation", "evidence", "hover", "output")
# a .cpp whose functions another header declares
SECOND_FILES = {
    "diagnosis/result/to_json": "diagnosis/result/diagnosis",
    "diagnosis/estimation/smoother": "diagnosis/estimation/innovation_filter",
    "diagnosis/evidence/rollouts_without_each": "diagnosis/evidence/gather_evidence",
}

# a third-party header stays behind the folder that wraps it
WRAPPED = {
    "mujoco/": ("src/plant/",),
    "sqlite3.h": ("src/sweep/",),
    "tinyxml2.h": ("src/plant/",),
    "ceres/": ("src/diagnosis/",),
    "nlopt.hpp": ("src/sweep/", "src/calibration/"),
    "CLI/": ("apps/",),
    "tbb/": ("src/util/",),
    "oneapi/": ("src/util/",),
}

CODE = {".cpp", ".hpp", ".h", ".py", ".sh", ".cmake"}


def code_files(*folders):
    for folder in folders:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in CODE and "__pycache__" not in path.parts:
                yield path


def includes(path):
    return [(bracket == "<", name) for bracket, name in INCLUDE.findall(path.read_text(encoding="utf-8"))]


class Layers(unittest.TestCase):
    def check(self, problems):
        self.assertFalse(problems, "\n" + "\n".join(problems))

    def test_every_folder_has_its_layer(self):
        folders = {path.relative_to(ROOT / "src").parts[0] for path in code_files("src")}
        self.assertTrue(folders)
        self.check([f"src/{name}: not in the layer rule" for name in sorted(folders - set(ALLOWED))])

    def test_the_rule_has_no_cycle(self):
        below = set()
        for folder, allowed in ALLOWED.items():
            self.assertLessEqual(allowed, below, f"{folder} may include what stands above it")
            below.add(folder)

    def test_nothing_includes_upwards(self):
        problems = []
        for path in code_files("src", "include"):
            where = path.relative_to(ROOT)
            folder = where.parts[1] if where.parts[0] == "src" else "include"
            allowed = ALLOWED.get(folder, set()) | {folder, "gustlab", "util"}
            for system, name in includes(path):
                first, _, rest = name.partition("/")
                if system or not rest:
                    continue
                if first == "..":
                    problems.append(f"{where}: \"{name}\" (write the path from src/)")
                elif first not in allowed:
                    problems.append(f"{where}: \"{name}\" ({folder} may include {', '.join(sorted(allowed))})")
        self.check(problems)

    def test_plugins_are_reached_through_their_registry(self):
        problems = []
        for path in code_files("src", "apps"):
            where = path.relative_to(ROOT)
            for system, name in includes(path):
                first, _, rest = name.partition("/")
                if not system and first in PLUGINS and where.parts[1] != first and rest != f"{first}.hpp":
                    problems.append(f"{where}: \"{name}\" (include {first}/{first}.hpp)")
        self.check(problems)

    def test_third_party_headers_stay_behind_their_wrapper(self):
        problems = []
        for path in code_files("src", "include", "apps"):
            where = path.relative_to(ROOT).as_posix()
            for _, name in includes(path):
                for prefix, places in WRAPPED.items():
                    if name.startswith(prefix) and not where.startswith(places):
                        problems.append(f"{where}: <{name}> (belongs to {', '.join(places)})")
        self.check(problems)

    def test_rooms_of_the_diagnosis_include_downwards(self):
        level = {room: number for number, room in enumerate(DIAGNOSIS_ROOMS)}
        problems = []
        for path in code_files("src/diagnosis"):
            where = path.relative_to(ROOT)
            room = where.parts[2] if len(where.parts) > 3 else None
            if room and room not in level:
                problems.append(f"{where}: the room {room} has no place in DIAGNOSIS_ROOMS")
                continue
            for system, name in includes(path):
                parts = name.split("/")
                if system or parts[0] != "diagnosis" or not room:
                    continue
                if len(parts) < 3 or level.get(parts[1], len(level)) > level[room]:
                    problems.append(f"{where}: \"{name}\" ({room} stands below it)")
        self.check(problems)

    def test_components_of_the_diagnosis_have_no_circle(self):
        """A component is a header with its .cpp (or two); two that need each other are one or hide a third."""
        needs, problems = {}, []
        for path in code_files("src/diagnosis"):
            component = path.relative_to(ROOT / "src").with_suffix("").as_posix()
            component = SECOND_FILES.get(component, component)
            if not (ROOT / "src" / f"{component}.hpp").exists():
                problems.append(f"src/{component}.cpp: which header declares it? (SECOND_FILES)")
            quoted = {name.removesuffix(".hpp") for system, name in includes(path) if not system}
            needs.setdefault(component, set()).update(quoted - {component})
        ended, path_here = set(), []

        def visit(component):
            if component in path_here:
                problems.append(" -> ".join(path_here[path_here.index(component):] + [component]))
            elif component not in ended:
                path_here.append(component)
                for other in sorted(needs.get(component, ())):
                    visit(other)
                path_here.pop()
                ended.add(component)

        for component in sorted(needs):
            visit(component)
        self.check(problems)

    def test_a_test_includes_every_header_of_the_diagnosis(self):
        included = {name for path in code_files("tests") for system, name in includes(path) if not system}
        headers = [path.relative_to(ROOT / "src").as_posix() for path in code_files("src/diagnosis") if path.suffix == ".hpp"]
        self.assertGreater(len(headers), 60)
        self.check([f"src/{header}: no test includes it" for header in headers if header not in included])


if __name__ == "__main__":
    unittest.main()
