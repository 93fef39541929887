"""How far long work is, on stderr, once it takes more than two seconds: one line that is rewritten on a terminal, a line every half a minute elsewhere."""

import os
import sys
import threading
import time
from pathlib import Path

from .interrupts import throw_if_interrupted
from .problems import printable

FIRST_s, REWRITE_s, LINE_s, LOOK_s = 2.0, 0.1, 30.0, 0.1


class Progress:
    """first_line_s: when the first line comes where it is no terminal."""

    def __init__(self, what: str, quiet: bool = False, clock=time.monotonic, stream=None, first_line_s: float = LINE_s):
        self.what, self.clock, self.stream = what, clock, stream or sys.stderr
        self.begin, self.last = clock(), None
        self.quiet = quiet or self.stream is None  # a closed stderr
        self.terminal = not self.quiet and self.stream.isatty()
        self.first_s, self.wait_s = (FIRST_s, REWRITE_s) if self.terminal else (first_line_s, LINE_s)

    def due(self) -> bool:
        now = self.clock()
        return not self.quiet and (now - self.begin >= self.first_s if self.last is None else now - self.last >= self.wait_s)

    def say(self, line: str) -> None:
        """Says a line, when the last one is long enough ago."""
        if not self.due():
            return
        self.last = self.clock()
        try:
            print(f"\r{line}\033[K" if self.terminal else line, end="" if self.terminal else "\n", file=self.stream, flush=True)
        except OSError:  # a stderr that takes nothing ends no work
            self.quiet = True

    def show(self, done: int, of: int) -> None:
        if done:
            self.say(f"{done}/{of} {self.what}, {(self.clock() - self.begin) * (of - done) / done:.0f} s left")

    def end(self) -> None:
        if self.terminal and self.last is not None and not self.quiet:
            print(file=self.stream, flush=True)


class LogProgress:
    """Which log of an import is read, its size, and how much of it is done where its reader tells (stage()).

    A thread looks ten times a second, so that no reader waits for it. Use: with LogProgress(...) as logs, and logs.begin(path) for each.
    """

    current = None  # readers need not be handed it

    def __init__(self, count: int, quiet: bool = False, clock=time.monotonic, stream=None):
        self.own = None if stream else _own_stderr()
        self.progress = Progress("logs", quiet, clock, stream or self.own, FIRST_s)
        self.count, self.number, self.log, self.doing, self.share = count, 0, "", "", None
        self.over = threading.Event()
        self.thread = threading.Thread(target=self._watch, daemon=True)

    def begin(self, path: Path) -> None:
        size = f" ({path.stat().st_size / 1e6:.1f} MB)" if path.is_file() else ""
        self.number += 1
        self.log, self.doing, self.share = printable(path.name) + size, "reading", None

    def line(self) -> str:
        before = f"log {self.number} of {self.count}: " if self.count > 1 else ""
        return f"{before}{self.doing} {self.log}{self.done()}"

    def done(self) -> str:
        try:
            return f", {100.0 * self.share():.0f} %" if self.share else ""
        except Exception:  # of a file that its reader has closed by now
            return ""

    def look(self) -> None:
        if self.number:
            self.progress.say(self.line())

    def _watch(self) -> None:
        while not self.over.wait(LOOK_s):
            self.look()

    def __enter__(self):
        LogProgress.current = self
        self.thread.start()
        return self

    def __exit__(self, *_):
        LogProgress.current = None
        self.over.set()
        self.thread.join()
        self.progress.end()
        if self.own:
            self.own.close()


def stage(doing: str, share=None) -> None:
    """For what works on a log: what begins now ("reading", "checking"), and a function that says how much of it is done, 0 to 1."""
    throw_if_interrupted()
    if LogProgress.current is not None:
        LogProgress.current.doing, LogProgress.current.share = doing, share


def _own_stderr():
    """A second way to stderr: readers may turn the first one aside. None where it is no file."""
    try:
        return os.fdopen(os.dup(sys.stderr.fileno()), "w", encoding="utf-8", errors="backslashreplace")
    except (OSError, AttributeError):
        return None
