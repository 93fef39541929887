"""How far long work is, on stderr: one line that is rewritten on a terminal, a line every half a minute elsewhere."""

import sys
import time


class Progress:
    def __init__(self, what: str, quiet: bool = False):
        self.what, self.quiet = what, quiet
        self.begin = self.last = time.monotonic()
        self.terminal = sys.stderr.isatty()

    def show(self, done: int, of: int) -> None:
        now = time.monotonic()
        wait = 0.1 if self.terminal else 30.0
        if self.quiet or now - self.begin < 2.0 or now - self.last < wait or done == 0:
            return
        self.last = now
        left_s = (now - self.begin) * (of - done) / done
        line = f"{done}/{of} {self.what}, {left_s:.0f} s left"
        print(f"\r{line}\033[K" if self.terminal else line, end="" if self.terminal else "\n", file=sys.stderr, flush=True)

    def end(self) -> None:
        if self.terminal and not self.quiet and self.last > self.begin:
            print(file=sys.stderr)
