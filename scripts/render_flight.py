#!/usr/bin/env python3
"""What `gustlab render` runs; see gustlab_flights/render.py."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from gustlab_flights.render import run  # noqa: E402
from gustlab_flights.problems import ended  # noqa: E402

if __name__ == "__main__":
    sys.exit(ended(run, sys.argv[1:]))
