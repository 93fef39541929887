"""Continues a script in the project's Python environment (.venv/), wherever it was started from.

Import it before anything that only that environment has.
"""

import importlib.util
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PYTHON = ROOT / ".venv" / "bin" / "python3"

if Path(sys.prefix).resolve() != (ROOT / ".venv").resolve() and PYTHON.exists():
    os.execv(PYTHON, [str(PYTHON), *sys.orig_argv[1:]])
if importlib.util.find_spec("numpy") is None:
    sys.exit(f"{sys.argv[0]}: numpy is missing ({PYTHON} is not there); run {ROOT / 'scripts' / 'setup.sh'}")
