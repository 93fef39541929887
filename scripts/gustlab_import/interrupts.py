"""SIGINT, SIGTERM, SIGUSR1 and SIGHUP end a script with 130, as they end the program; what it has begun is removed on the way out."""

import contextlib
import os
import signal
import sys

CODE = 130
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1, signal.SIGHUP)
_came = []


def _end(number: int, _frame) -> None:
    _came.append(number)
    signal.signal(number, signal.SIG_DFL)  # a second one ends it at once
    # libraries that are half imported make errors of their own of it
    sys.excepthook = lambda *_: os._exit(CODE)
    sys.unraisablehook = lambda *_: None
    raise SystemExit(CODE)


def throw_if_interrupted() -> None:
    """For long work: a library that is just being imported may have caught what a signal threw."""
    if _came:
        raise SystemExit(CODE)


def listen() -> None:
    for number in SIGNALS:
        # who starts a program with nohup wants it to live on
        if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, _end)


@contextlib.contextmanager
def held_back():
    """Around what must not stay half done: a signal that comes meanwhile is heard at its end."""
    came = []
    heard = [number for number in SIGNALS if signal.getsignal(number) is _end]
    for number in heard:
        signal.signal(number, lambda number, _frame: came.append(number))
    try:
        yield
    finally:
        for number in heard:
            signal.signal(number, _end)
    if came:
        _end(came[0], None)
