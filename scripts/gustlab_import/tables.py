"""Reads tabular recordings (CSV or CSV.gz) into named columns and remembers the line of every row."""

import csv
import gzip
import hashlib
import io
import math
import zlib
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .problems import DATA, ImportFailure
from .progress import stage


LARGEST = 1e30   # of a number that could be meant; nanoseconds since 1970 are 2e18


@dataclass
class Table:
    """Columns of one recording; a missing sample is NaN.

    file       path of the file as it was given
    sha256     of the bytes of the file
    columns    name -> (n,) float64
    line       (n,) line (CSV) or record number (binary) of every row, for messages
    non_finite name -> line of the first cell that said NaN or infinity
    """

    file: str
    sha256: str
    columns: dict
    line: np.ndarray
    non_finite: dict = field(default_factory=dict)
    remarks: list = field(default_factory=list)


def read_bytes(path: Path) -> bytes:
    try:
        return Path(path).read_bytes()
    except OSError as error:
        raise ImportFailure(f"{path}: cannot be read ({error.strerror})") from error


def first_bytes(path: Path, count: int) -> bytes:
    try:
        with open(path, "rb") as file:
            return file.read(count)
    except OSError as error:
        raise ImportFailure(f"{path}: cannot be read ({error.strerror})") from error


def read_csv(path: Path) -> Table:
    """Reads a comma separated file with one header line; `.gz` is unpacked."""
    raw = read_bytes(path)
    digest = hashlib.sha256(raw).hexdigest()
    if raw[:2] == b"\x1f\x8b":
        try:
            raw = gzip.decompress(raw)
        except (OSError, EOFError, zlib.error) as error:
            raise ImportFailure(f"{path}:1:1: the gzip stream is broken ({error}); fetch the file again") from error
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ImportFailure(f"{path}:1:1: not a text file ({error.reason}); {_instead_of_text(raw)}") from error
    lines = io.StringIO(text, newline=None)
    stage("reading", lambda: lines.tell() / len(text))
    try:
        return _table_of(csv.reader(lines), path, digest)
    except csv.Error as error:
        raise ImportFailure(f"{path}:1:1: not a table of comma separated cells ({error}); save it as CSV again") from error


def _table_of(rows, path: Path, digest: str) -> Table:
    header = [name.strip() for name in next(rows, [])]
    if not header or header == [""]:
        raise ImportFailure(f"{path}:1:1: empty file (no header line)")
    if any("\n" in name for name in header):
        raise ImportFailure(f"{path}:1:1: a quotation mark in the header is never closed")
    if len(header) == 1 and any(mark in header[0] for mark in ";\t"):
        raise ImportFailure(f"{path}:1:1: cells are separated by {'semicolons' if ';' in header[0] else 'tabs'}; write commas "
                            "(and decimal points)")
    if header[0].startswith(("#", "//", "%")):
        raise ImportFailure(f"{path}:1:1: the first line is a remark (`{header[0][:40]}`); the names of the columns must be there: delete what stands before them")
    doubled = sorted(name for name, count in Counter(header).items() if count > 1)
    if doubled:
        column = header.index(doubled[0]) + 1
        raise ImportFailure(f"{path}:1:{column}: column `{doubled[0]}` occurs twice; rename one of them")
    cells, lines, non_finite = [], [], {}
    for row in rows:
        if not row:
            continue
        if len(row) != len(header):
            why = "cut off while it was written?" if len(row) < len(header) else "decimal commas?"
            raise ImportFailure(f"{path}:{rows.line_num}:{min(len(row), len(header)) + 1}: {len(row)} cells where the "
                                f"header has {len(header)} ({why})")
        cells.append([_number(cell, str(path), rows.line_num, k, header[k], non_finite) for k, cell in enumerate(row)])
        lines.append(rows.line_num)
    if not cells:
        raise ImportFailure(f"{path}:2:1: the file has a header and no samples")
    data = np.array(cells)
    return Table(str(path), digest, {name: data[:, k] for k, name in enumerate(header)}, np.array(lines), non_finite)


def _instead_of_text(raw: bytes) -> str:
    from .kinds import kind_by_mark   # kinds imports this module
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "it is UTF-16: save it as UTF-8"
    kind = kind_by_mark(raw[:64])
    if kind in ("ulog", "dataflash", "blackbox"):
        return "it is a flight computer's log; `gustlab import` without --map reads it"
    return "a binary file needs a map of its kind (usd, parquet, ros)"


def read_parquet(path: Path) -> Table:
    """Reads the columns of numbers of a Parquet file; nulls are no samples."""
    import pyarrow
    import pyarrow.parquet  # a second to import
    digest = hashlib.sha256(read_bytes(path)).hexdigest()
    try:
        table = pyarrow.parquet.read_table(path)
    except (pyarrow.ArrowException, OSError, ValueError) as error:
        raise ImportFailure(f"{path}: the Parquet file cannot be read ({str(error).splitlines()[0]}); fetch it again") from error
    columns, non_finite = {}, {}
    for name in table.column_names:
        kind = table.schema.field(name).type
        if pyarrow.types.is_temporal(kind):
            unit = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}[getattr(kind, "unit", "us")]
            columns[name] = unit * table.column(name).cast(pyarrow.int64()).to_numpy().astype(float)
        elif pyarrow.types.is_integer(kind) or pyarrow.types.is_floating(kind) or pyarrow.types.is_boolean(kind):
            values = table.column(name).cast(pyarrow.float64()).to_numpy()
            bad = np.flatnonzero(np.abs(values) >= LARGEST)
            if len(bad):
                non_finite[name] = int(bad[0]) + 1
            columns[name] = np.where(np.abs(values) < LARGEST, values, np.nan)
    if not columns or not table.num_rows:
        raise ImportFailure(f"{path}: no columns of numbers, or no rows, are in the Parquet file")
    return Table(str(path), digest, columns, np.arange(1, table.num_rows + 1), non_finite)


def _number(cell: str, file: str, line: int, index: int, name: str, non_finite: dict) -> float:
    if not cell.strip():
        return math.nan
    try:
        value = float(cell)
    except ValueError:
        raise ImportFailure(f"{file}:{line}:{index + 1}: `{cell.strip()[:40]}` in column `{name}` is not a number",
                            DATA) from None
    if not abs(value) < LARGEST:
        non_finite.setdefault(name, line)
        return math.nan
    return value
