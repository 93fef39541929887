"""Reads Crazyflie micro-SD logs, format 1 and 2.

Layout (Crazyflie documentation, "uSD deck: logging", and the logs themselves), little-endian:
byte 0xBC; u16 version; u16 number of event types; per type: u16 id, name NUL, u16 number of variables, each
"name(type)" NUL, the type being a letter of Python's struct module; then records {u16 id, time, packed values}, the
time a u32 in milliseconds (version 1) or a u64 in microseconds (version 2); a CRC-32 over everything before it ends it.
"""

import hashlib
import struct
import zlib
from pathlib import Path

import numpy as np

from .problems import Finding, ImportFailure, some
from .progress import stage
from .tables import Table, read_bytes

MAGIC = 0xBC
# version -> (record header, seconds per tick)
RECORD_HEADER = {1: (struct.Struct("<HI"), 1e-3), 2: (struct.Struct("<HQ"), 1e-6)}
TIME_COLUMN = "tick_s"


class _Reader:
    def __init__(self, data: bytes, file: str):
        self.data, self.file, self.at = data, file, 0

    def fail(self, why: str):
        raise ImportFailure(f"{self.file}: byte {self.at}: {why}")

    def take(self, layout: str):
        size = struct.calcsize(layout)
        if self.at + size > len(self.data):
            self.fail("the header is cut off; fetch the file again")
        value = struct.unpack_from(layout, self.data, self.at)
        self.at += size
        return value[0]

    def text(self) -> str:
        end = self.data.find(b"\0", self.at)
        if end < 0:
            self.fail("a name in the header does not end; fetch the file again")
        value = self.data[self.at:end].decode("ascii", "replace")
        self.at = end + 1
        return value


def _event_types(reader: _Reader) -> dict:
    types = {}
    for _ in range(reader.take("<H")):
        identifier, name, variables, layout = reader.take("<H"), reader.text(), [], "<"
        for _ in range(reader.take("<H")):
            variable = reader.text()
            if not variable.endswith(")") or variable[-3:-2] != "(" or variable[-2] not in "bBhHiIlLqQefd?":
                reader.fail(f"variable `{variable}` has no type letter")
            variables.append(variable[:-3])
            layout += variable[-2]
        types[identifier] = (name, variables, struct.Struct(layout))
    return types


def read_usd(path: Path, event: str) -> Table:
    """Reads the records of one event type (for example "fixedFrequency") into columns; `tick_s` is the time [s].

    A file that ends inside a record keeps the records before it, and the table's remarks say so. A checksum that does
    not fit, with a complete record structure, is an error: any value may be wrong.
    """
    data = read_bytes(path)
    digest = hashlib.sha256(data).hexdigest()
    reader = _Reader(data, str(path))
    if not data or data[0] != MAGIC:
        reader.fail("not a Crazyflie uSD log (the first byte is not 0xBC)")
    reader.at = 1
    version = reader.take("<H")
    if version not in RECORD_HEADER:
        reader.fail(f"format version {version} is not known (1 and 2 are)")
    types = _event_types(reader)
    names = {name: identifier for identifier, (name, _, _) in types.items()}
    if event not in names:
        reader.fail(f"no event type `{event}` (the log has {some(names)})")
    head, tick_s = RECORD_HEADER[version]
    wanted, rows = names[event], []
    crc_fits = len(data) >= reader.at + 4 and zlib.crc32(data[:-4]) == struct.unpack("<I", data[-4:])[0]
    end = len(data) - 4 if crc_fits else len(data)
    stage("reading", lambda: reader.at / len(data))
    while reader.at < end:
        left = end - reader.at
        identifier = struct.unpack_from("<H", data, reader.at)[0] if left >= 2 else None
        if identifier is not None and identifier not in types:
            if crc_fits:
                reader.fail(f"unknown event type {identifier} between records")
            # fewer than four bytes are the rest of a checksum that was cut off, four are a checksum that does not fit
            if left >= 4:
                reader.fail("the checksum (CRC-32) does not fit" + (", and what follows is no record" if left > 4 else "")
                            + ": the file is damaged; fetch it again")
        if identifier not in types or left < head.size + types[identifier][2].size:
            break
        if identifier == wanted:
            rows.append((head.unpack_from(data, reader.at)[1],)
                        + types[identifier][2].unpack_from(data, reader.at + head.size))
        reader.at += head.size + types[identifier][2].size
    if not rows:
        raise ImportFailure(f"{path}: byte {reader.at}: no record of type `{event}`")
    return _table(str(path), digest, types[wanted][1], rows, tick_s, not crc_fits)


def _table(file: str, digest: str, variables: list, rows: list, tick_s: float, cut: bool) -> Table:
    # ticks stay exact: a 64-bit microsecond count of less than 285 years fits into a double
    values = np.array(rows, dtype=float)
    columns = {TIME_COLUMN: values[:, 0] * tick_s}
    columns.update({name: values[:, k + 1] for k, name in enumerate(variables)})
    non_finite = {name: int(np.flatnonzero(~np.isfinite(column))[0]) + 1
                  for name, column in columns.items() if not np.all(np.isfinite(column))}
    columns = {name: np.where(np.isfinite(column), column, np.nan) for name, column in columns.items()}
    table = Table(file, digest, columns, np.arange(1, len(rows) + 1), non_finite)
    if cut:
        table.remarks.append(Finding("gap", "time_s", columns[TIME_COLUMN][-1], columns[TIME_COLUMN][-1], "warning",
                                     "the log ends inside a record and without its checksum (power cut?): the "
                                     f"{len(rows)} complete records were kept, unchecked", True))
    return table
