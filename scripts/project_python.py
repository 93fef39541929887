"""Continues a script in the project's Python environment (.venv/), wherever it was started from.

Import it before anything that only that environment has.
"""

import importlib.util
import os
import signal
import sys
from pathlib import Path


def _end(kind, error, trace) -> None:
    if not issubclass(kind, KeyboardInterrupt):
        return sys.__excepthook__(kind, error, trace)
    print("interrupted", file=sys.stderr, flush=True)
    os._exit(130)


# wherever a script is, it removes what it wrote in part, and ends as the program does
signal.signal(signal.SIGTERM, signal.default_int_handler)
sys.excepthook = _end

ROOT = Path(__file__).resolve().parents[1]
PYTHON = ROOT / ".venv" / "bin" / "python3"

if Path(sys.prefix).resolve() != (ROOT / ".venv").resolve() and PYTHON.exists():
    os.execv(PYTHON, [str(PYTHON), *sys.orig_argv[1:]])
if importlib.util.find_spec("numpy") is None:
    sys.exit(f"{sys.argv[0]}: numpy is missing ({PYTHON} is not there); run {ROOT / 'scripts' / 'setup.sh'}")
