"""What these commands refuse, with the program's exit codes."""

import sys

from gustlab_import.problems import printable, told

USAGE, DATA, IO = 2, 3, 4


class Refusal(Exception):
    """`place: problem (why)`; code is the exit code."""

    def __init__(self, message: str, code: int = DATA):
        super().__init__(message)
        self.code = code


def ended(command, arguments) -> int:
    """Runs a command; its exit code. A refusal is one line on stderr."""
    try:
        return told(lambda: command(arguments))
    except Refusal as refusal:
        print(printable(str(refusal)), file=sys.stderr)
        return refusal.code
