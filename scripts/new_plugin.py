#!/usr/bin/env python3
"""Adds a controller, an effect or a trajectory of your own, from a template that compiles and flies.

Writes src/<kind>s/NAME.cpp from examples/plugins/<kind>.cpp, declares its make_NAME and adds its row to that folder's registry.
Then scripts/build.sh compiles that folder again and links.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

FOLDERS = {"controller": "controllers", "effect": "effects", "trajectory": "trajectories"}
ROWS = {
    "controller": '    {{.name = "{name}", .says = "{says}",\n     .source = "say here where it is published", .make = make_{name}}},\n',
    "effect": '    {{.name = "{name}", .place = Place::wrench, .order = 10, .diagnosable = false,\n'
              '     .says = "{says}",\n     .shows_in = "say here what of a flight shows it", .confused_with = "",\n'
              '     .source = "say here where it is published", .make = make_{name}}},\n',
    "trajectory": '    {{.name = "{name}", .says = "{says}", .make = make_{name}}},\n',
}


def refuse(problem):
    print(f"new_plugin: {problem}", file=sys.stderr)
    sys.exit(2)


def inserted(text, before, new):
    """`text` with `new` before the last occurrence of `before`"""
    at = text.rindex(before)
    return text[:at] + new + text[at:]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=FOLDERS)
    parser.add_argument("name", help="lower case with underscores, as experiments will write it")
    parser.add_argument("--says", default="say here in one sentence what it does", help="one sentence for `gustlab list`")
    parser.add_argument("--tree", type=Path, default=Path(__file__).resolve().parents[1], help="checkout that it is added to (default: this one)")
    options = parser.parse_args()
    if not re.fullmatch(r"[a-z][a-z0-9_]*", options.name) or options.name == options.kind:
        refuse(f'"{options.name}" is not a name of its own (lower case letters, digits and underscores)')
    if '"' in options.says or "\\" in options.says or "\n" in options.says:
        refuse("--says: one line without quotes and backslashes")
    source = options.tree / "src" / FOLDERS[options.kind]
    new, registry, makers = source / f"{options.name}.cpp", source / "registry.cpp", source / f"{FOLDERS[options.kind]}.hpp"
    for path in (registry, makers):
        if not path.exists():
            refuse(f"{path}: is not there (--tree is a checkout of gustlab)")
    # the linker knows make_NAME() by its name alone, whatever it makes
    for kind, folder in FOLDERS.items():
        if f"make_{options.name}()" in (options.tree / "src" / folder / f"{folder}.hpp").read_text(encoding="utf-8"):
            refuse(f"{options.name} is the name of one of the {kind}s: choose another name")
    if new.exists():
        refuse(f"{new}: is there already: choose another name")
    template = (options.tree / "examples" / "plugins" / f"{options.kind}.cpp").read_text(encoding="utf-8")
    # with its kind behind it, so that a trajectory "jet" is no class Jet
    base = options.kind.capitalize()
    class_name = "".join(part.capitalize() for part in options.name.split("_")).removesuffix(base) + base
    new.write_text(template.replace(f"my_{options.kind}", options.name).replace(f"My{base}", class_name), encoding="utf-8")
    row = ROWS[options.kind].format(name=options.name, says=options.says)
    registry.write_text(inserted(registry.read_text(encoding="utf-8"), "};\n\n}  // namespace\n", row), encoding="utf-8")
    maker = f"std::unique_ptr<{options.kind.capitalize()}> make_{options.name}();\n"
    makers.write_text(inserted(makers.read_text(encoding="utf-8"), "\n}  // namespace gustlab", maker), encoding="utf-8")
    # how lines break depends on the lengths of name and sentence
    root = Path(__file__).resolve().parents[1]
    formatter = shutil.which("clang-format", path=f"{root / '.venv' / 'bin'}{os.pathsep}{os.environ.get('PATH', '')}")
    if formatter:
        subprocess.run([formatter, f"--style=file:{root / '.clang-format'}", "-i", new, registry, makers], check=True)
    else:
        print("new_plugin: no clang-format here: the layout of the new lines is not as the tests want it (scripts/setup.sh installs it)", file=sys.stderr)
    print(f"{new.relative_to(options.tree)}: write your {options.kind} there; its row is the last of {registry.relative_to(options.tree)}")


if __name__ == "__main__":
    main()
