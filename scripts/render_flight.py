#!/usr/bin/env python3
"""What `gustlab render` runs; see gustlab_flights/render.py."""

import project_python  # noqa: F401, I001 (first: it may start this script again in .venv)
import sys

from gustlab_flights.render import run
from gustlab_flights.problems import ended

if __name__ == "__main__":
    sys.exit(ended(run, sys.argv[1:]))
