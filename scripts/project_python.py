"""Continues a script in the project's Python environment (.venv/), wherever it was started from; signals end it as they end the program.

Import it before anything that only that environment has.
"""

from gustlab_import import interrupts  # first: what follows takes a moment
import os
import sys

if os.path.dirname(os.path.realpath(sys.argv[0])) == os.path.dirname(os.path.realpath(__file__)):  # not a test
    interrupts.listen()

import importlib.util  # noqa: E402
from pathlib import Path  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]
PYTHON = ROOT / ".venv" / "bin" / "python3"

if Path(sys.prefix).resolve() != (ROOT / ".venv").resolve() and PYTHON.exists():
    os.execv(PYTHON, [str(PYTHON), *sys.orig_argv[1:]])
if importlib.util.find_spec("numpy") is None:
    sys.exit(f"{sys.argv[0]}: numpy is missing ({PYTHON} is not there); run {ROOT / 'scripts' / 'setup.sh'}")
