#!/usr/bin/env python3
"""What `gustlab import` runs; see gustlab_import/cli.py."""

import project_python  # noqa: F401, I001 (first: it may start this script again in .venv)
import sys

from gustlab_import.cli import main

if __name__ == "__main__":
    sys.exit(main())
