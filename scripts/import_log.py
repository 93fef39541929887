#!/usr/bin/env python3
"""What `gustlab import` runs; see gustlab_import/cli.py."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from gustlab_import.cli import main  # noqa: E402

if __name__ == "__main__":
    sys.exit(main())
