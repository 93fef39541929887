"""Options of the commands that are written in Python, with the program's own wording of what is wrong."""

import argparse

from .problems import USAGE


class Options(argparse.ArgumentParser):
    """As argparse has it, but a wrong command line is said in one line."""

    def error(self, message: str):
        self.exit(USAGE, f"gustlab: {message} (see {self.prog} --help)\n")
