"""What a test asks of a process that runs."""

import time
from pathlib import Path


def wait_for(true, seconds=20.0):
    """whether something becomes true within some time"""
    until = time.monotonic() + seconds
    while not true() and time.monotonic() < until:
        time.sleep(0.002)
    return true()


def catches(pid, number):
    """whether a process has a handler for a signal"""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("SigCgt:"):
            return bool(int(line.split()[1], 16) >> (number - 1) & 1)
    return False
