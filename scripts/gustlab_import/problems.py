"""What an importer can say: findings about the data, and failures that end the program."""

import contextlib
import os
import re
import sys
from dataclasses import dataclass

from .interrupts import throw_if_interrupted

USAGE, DATA, IO = 2, 3, 4
MOST_NAMES = 12  # in one message
HALF = re.compile("[\ud800-\udfff]")


def printable(text: str) -> str:
    """As a terminal may see it: a file name may hold anything."""
    return "".join(c if c.isprintable() else f"\\x{ord(c):02x}" for c in valid_utf8(text))


def valid_utf8(text: str) -> str:
    """As a file may hold it: a byte of a name that is no UTF-8, which Python keeps as half of a pair, as \\xNN."""
    return HALF.sub(lambda half: f"\\x{ord(half[0]) & 0xff:02x}", text)


def some(names) -> str:
    """Names for a message: a dozen of them, and how many there are besides."""
    names = sorted(names)
    more = len(names) - MOST_NAMES
    return ", ".join(names[:MOST_NAMES]) + (f" and {more} more" if more > 0 else "")


class ImportFailure(Exception):
    """A problem that ends a command; `code` is the exit code (2 usage or map, 3 data, 4 file system)."""

    def __init__(self, message: str, code: int = DATA):
        super().__init__(message)
        self.code = code


@contextlib.contextmanager
def understood(path):
    """What a decoded log's fields make impossible (not there, of another kind, out of range) becomes one line that names it."""
    try:
        yield
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise ImportFailure(f"{path}: what the log holds is not as its kind of logs have it ({type(error).__name__}: {error}); is it damaged? "
                            "fetch it again") from error


class _Stdout:
    """stdout whose failures are not taken for those of other files."""

    def __init__(self, stream):
        self.stream = stream

    def write(self, text: str) -> int:
        with self._watched():
            return self.stream.write(text)

    def flush(self):
        with self._watched():
            self.stream.flush()

    @contextlib.contextmanager
    def _watched(self):
        try:
            yield
        except OSError as error:
            raise _StdoutFailure(error) from None

    def __getattr__(self, name: str):
        return getattr(self.stream, name)


class _StdoutFailure(Exception):
    pass


def told(command) -> int:
    """Runs what prints to stdout; its exit code, 4 where stdout takes no more (a full disk is said, a closed pipe is not)."""
    stdout = _Stdout(sys.stdout)
    try:
        with contextlib.redirect_stdout(stdout):
            try:
                code = command()
            except SystemExit as end:   # what argparse printed is not written yet
                code = end.code
            stdout.flush()
            return code
    except _StdoutFailure as failure:
        error = failure.args[0]
        os.dup2(os.open(os.devnull, os.O_WRONLY), stdout.fileno())   # Python would try again at its end
        if not isinstance(error, BrokenPipeError):
            print(f"stdout: cannot write ({error.strerror})", file=sys.stderr)
        return IO


def ended(command, *arguments) -> int:
    """Runs a command; its exit code. What it refuses is one line on stderr."""
    try:
        return told(lambda: command(*arguments))
    except ImportFailure as failure:
        throw_if_interrupted()
        print(printable(str(failure)), file=sys.stderr)
        return failure.code
    except BrokenPipeError:
        return IO
    except OSError as error:  # a name that no file can have, a disk that is gone
        print(printable(f"{str(error.filename)[:200]}: cannot be read ({error.strerror})"), file=sys.stderr)
        return DATA


@dataclass(frozen=True)
class Finding:
    """One fact about a recording.

    kind      gap | duplicate | frozen | held | out_of_range | unit | frame | sign | inconsistent | delay | filtered | ground
    column    the FlightLog column (or columns, comma separated) it is about
    from_s    first and last time of the flight log that it covers [s]
    severity  "note" (harmless), "warning" (limits what can be told), "error" (the recording is not usable as it is)
    repaired  True when the written log no longer has the fault
    """

    kind: str
    column: str
    from_s: float
    to_s: float
    severity: str
    says: str
    repaired: bool = False

    def as_dict(self) -> dict:
        return {"kind": self.kind, "column": self.column, "from_s": round(float(self.from_s), 6),
                "to_s": round(float(self.to_s), 6), "severity": self.severity, "says": self.says,
                "repaired": self.repaired}


def merged(findings: list) -> list:
    """One finding where the same was said of several columns of one kind."""
    out = {}
    for f in findings:
        key = (f.kind, f.says, f.severity, f.repaired)
        old = out.get(key)
        out[key] = f if old is None else Finding(f.kind, old.column + "," + f.column, min(old.from_s, f.from_s),
                                                 max(old.to_s, f.to_s), f.severity, f.says, f.repaired)
    return list(out.values())
