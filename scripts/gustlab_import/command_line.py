"""Options of the commands that are written in Python, with the program's own wording of what is wrong."""

import argparse
import math

from .problems import USAGE, printable


def seconds(text: str) -> float:
    """Of --from and --to: a number, and no nan, which nothing is before or after."""
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(text)
    return value


class Options(argparse.ArgumentParser):
    """As argparse has it, but a wrong command line is said in one line."""

    def __init__(self, **words):
        super().__init__(allow_abbrev=False, **words)

    def error(self, message: str):
        self.exit(USAGE, printable(f"gustlab: {message} (see {self.prog} --help)") + "\n")
