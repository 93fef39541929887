"""What a ULog lost: bytes that are no message, times that cannot be, and an end within a message. The rest is for pyulog."""

import struct
from dataclasses import dataclass

import numpy as np

HEAD = 16                   # mark, version and the time of the start
KINDS = frozenset(b"BFIMPQARDLCSO")
LONGEST = 10_000            # bytes of a message that could be meant (pyulog's own limit)
CHAIN = 4                   # messages one after the other that chance does not make
NEAR = 5                    # messages on either side that say what time it is
TIME_OFF_us = 5_000_000     # after the messages before and after: messages are written within a second of their time


@dataclass
class Lost:
    """Bytes from first to end that hold nothing to read, and the times of the last message before them and of the first after them [us]."""

    first: int
    end: int
    before_us: int = None
    after_us: int = None


def without_damage(data: bytes) -> tuple:
    """(the bytes that are messages, [Lost], (bytes there, bytes meant) of a message that the end of the file cuts, or None)"""
    messages, lost, tail = _walk(data)
    stamps = [(at, end, _time(data, at), _number(data, at + 3)) for at, end in messages if data[at + 2] == ord("D") and end - at >= 13]
    lost = _joined(lost + [Lost(at, end) for at, end in _wrong_times(stamps)])
    _put_times(lost, stamps)
    if _has_appended(data):   # places in the file are written in it
        return data, lost, tail
    kept, at = [], 0
    for part in lost:
        kept.append(data[at:part.first])
        at = part.end
    return b"".join(kept) + data[at:], lost, tail


def _put_times(lost: list, stamps: list) -> None:
    """Of the messages around; more than one, as a message may repeat what was published long before it."""
    ends = np.array([part.end for part in lost])
    firsts = np.array([part.first for part in lost])
    around = [(at, time) for at, _, time, _ in stamps
              if (k := int(np.searchsorted(ends, at, "right"))) == len(lost) or at < firsts[k]]
    places, times = [at for at, _ in around], [time for _, time in around]
    for part in lost:
        k = int(np.searchsorted(places, part.first))
        part.before_us = max(times[max(0, k - NEAR):k], default=None)
        part.after_us = min((t for t in times[k:k + NEAR] if part.before_us is None or t >= part.before_us), default=None)


def _walk(data: bytes) -> tuple:
    """([(first byte, end)] of the messages, [Lost], (bytes there, bytes meant) of the message at the end that is not whole)"""
    sizes, messages, lost, at = {}, [], [], HEAD
    while at < len(data):
        end = _end_of(data, at, sizes)
        if end is None:
            later = _stranger(data, at) or _next_chain(data, at + 1, sizes)
            if later is None:
                whole = _cut(data, at)
                if whole:
                    return messages, lost, (len(data) - at, whole)
                lost.append(Lost(at, len(data)))
                break
            lost.append(Lost(at, later))
            at = later
            continue
        if data[at + 2] == ord("A"):
            sizes.setdefault(_number(data, at + 4), None)
        elif data[at + 2] == ord("D") and sizes[_number(data, at + 3)] is None:
            sizes[_number(data, at + 3)] = end - at
        messages.append((at, end))
        at = end
    return messages, lost, None


def _number(data: bytes, at: int) -> int:
    return int.from_bytes(data[at:at + 2], "little")


def _end_of(data: bytes, at: int, sizes: dict):
    """End of the message that begins here, or None where none does: of data, only of a topic that is announced, and as long as always."""
    if at + 3 > len(data):
        return None
    end, kind = at + 3 + _number(data, at), data[at + 2]
    if end == at + 3 or end > len(data) or kind not in KINDS:
        return None
    if kind == ord("D"):
        known = sizes.get(_number(data, at + 3), 0)
        return end if known is None or known == end - at else None
    # these have any length: the next one says whether it is meant
    return end if _framed(data, at) and (end == len(data) or _framed(data, end)) else None


def _framed(data: bytes, at: int) -> bool:
    return at + 3 <= len(data) and data[at + 2] in KINDS and 0 < _number(data, at) <= LONGEST


def _stranger(data: bytes, at: int):
    """End of a message of a topic whose announcement was lost: by its frame and the frames behind it."""
    ends = [at]
    for _ in range(3):
        end = ends[-1]
        if end == len(data) and len(ends) > 1:
            break
        if not _framed(data, end):
            return None
        ends.append(end + 3 + _number(data, end))
    return ends[1] if data[at + 2] == ord("D") and ends[1] <= len(data) else None


def _next_chain(data: bytes, at: int, sizes: dict):
    """Where messages go on after damage; None where they do not. Once topics are announced that is at a sample, which chance does not make."""
    for first in range(at, len(data) - 3):
        if sizes and data[first + 2] != ord("D"):
            continue
        end, count = first, 0
        while count < CHAIN and end < len(data) and (later := _end_of(data, end, sizes)) is not None:
            end, count = later, count + 1
        if count == CHAIN or (count > 1 and end == len(data)):
            return first
    return None


def _cut(data: bytes, at: int) -> int:
    """Length of the message that the end of the file cuts, 0 where it is none."""
    if at + 3 > len(data):
        return 3
    size, kind = _number(data, at), data[at + 2]
    return size + 3 if kind in KINDS and 0 < size <= LONGEST and at + 3 + size > len(data) else 0


def _time(data: bytes, at: int) -> int:
    """Of a message of data: its first field, as PX4 writes all of them."""
    return struct.unpack_from("<Q", data, at + 5)[0]


def _wrong_times(stamps: list) -> list:
    """[(first byte, end)] of messages whose time is far after those around them, and after the next of their topic (the last of a
    topic: after all others). The only message of a topic may be older than the log."""
    if len(stamps) < 4 * NEAR:
        return []
    time, topic = (np.array(values, dtype=float) for values in list(zip(*stamps))[2:])
    medians = np.median(np.lib.stride_tricks.sliding_window_view(np.pad(time, NEAR, mode="edge"), NEAR), axis=1)
    before, after = medians[:len(time)], medians[NEAR + 1:]
    late = time - np.maximum(before, after) > TIME_OFF_us
    following = np.full(len(time), np.inf if late.all() else time[~late].max())
    order = np.argsort(topic, kind="stable")
    same = np.flatnonzero(np.diff(topic[order]) == 0)
    following[order[same]] = time[order[same + 1]]
    following[np.isin(topic, np.unique(topic)[np.unique(topic, return_counts=True)[1] == 1])] = np.inf
    return [stamps[k][:2] for k in np.flatnonzero(late & (time > following))]


def _joined(lost: list) -> list:
    out = []
    for part in sorted(lost, key=lambda part: part.first):
        if out and part.first <= out[-1].end:
            out[-1].end = max(out[-1].end, part.end)
        else:
            out.append(part)
    return out


def _has_appended(data: bytes) -> bool:
    """PX4 appends a crash report to a log that is already closed, and says where in the log's first message."""
    return data[HEAD + 2:HEAD + 3] == b"B" and len(data) > HEAD + 12 and bool(data[HEAD + 11] & 1)
