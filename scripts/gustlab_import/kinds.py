"""Which reader a file needs: by its first bytes, and by its name where bytes do not tell."""

from pathlib import Path

from .column_map import MAPS
from .problems import USAGE, ImportFailure
from .tables import first_bytes

MAGIC = ((b"ULog\x01\x12\x35", "ulog"), (b"\xa3\x95", "dataflash"), (b"FMT, 128,", "dataflash"), (b"#ROSBAG V", "ros"), (b"SQLite format 3", "ros"),
         (b"\x89MCAP", "ros"), (b"H Product:Blackbox", "blackbox"), (b"\xbc", "usd"), (b"PAR1", "parquet"))
ENDINGS = {".ulg": "ulog", ".bin": "dataflash", ".log": "dataflash", ".tlog": "tlog", ".bag": "ros", ".db3": "ros", ".mcap": "ros", ".bfl": "blackbox",
           ".bbl": "blackbox", ".csv": "csv", ".gz": "csv", ".parquet": "parquet"}


def kind_by_mark(head: bytes) -> str:
    """By the first bytes of a file; empty where they do not tell."""
    return next((kind for magic, kind in MAGIC if head.startswith(magic)), "")


def kind_of(path: Path) -> str:
    if path.is_dir():
        inside = sorted(p.name for p in path.iterdir() if p.suffix.lower() in ENDINGS)
        raise ImportFailure(f"{path}: a folder" + (f"; give the log in it: {path / inside[0]}" if inside else " without a log"), USAGE)
    if path.exists() and not path.is_file():
        raise ImportFailure(f"{path}: is a pipe or a device (a log is read more than once); save it as a file first", USAGE)
    head = first_bytes(path, 64)
    if kind := kind_by_mark(head):
        return kind
    if not head:
        raise ImportFailure(f"{path}: byte 0: the file is empty; fetch it again")
    if head.startswith(b"\x1f\x8b") and not path.name.lower().endswith(".csv.gz"):
        raise ImportFailure(f"{path}: is compressed with gzip; unpack it first (gunzip), and give the log", USAGE)
    kind = ENDINGS.get(path.suffix.lower())
    if kind:
        return kind
    if head.startswith(b"rosbag2_bagfile_information"):
        raise ImportFailure(f"{path}: describes a ROS 2 bag and holds no samples; give the .db3 or .mcap beside it", USAGE)
    known = ", ".join(dict.fromkeys(ENDINGS))
    raise ImportFailure(f"{path}: byte 0: no log format that is known begins like this, and `{path.suffix}` is none of {known}",
                        USAGE)


def reader_of(kind: str, path: Path):
    """The function that reads files of a kind; imported only when it is needed, as some libraries take a second."""
    if kind == "ulog":
        from .read_ulog import read_ulog
        return read_ulog
    if kind in ("dataflash", "tlog"):
        from . import read_mavlink
        return read_mavlink.read_dataflash if kind == "dataflash" else read_mavlink.read_tlog
    if kind == "blackbox":
        from .read_blackbox import read_blackbox
        return read_blackbox
    if kind == "usd":
        from .read_usd_names import read_usd_by_names
        return read_usd_by_names
    if kind == "csv" and path.with_suffix(".meta.toml").is_file():
        raise ImportFailure(f"{path}: is a flight log already ({path.with_suffix('.meta.toml').name} is beside it); give it to `gustlab diagnose`", USAGE)
    if kind in ("csv", "parquet"):
        built_in = ", ".join(sorted(p.stem for p in MAPS.glob("*.toml")))
        raise ImportFailure(f"{path}: a {kind} file needs a column map: --map NAME|FILE.toml (built in: {built_in}); `gustlab defaults column-map` prints one to begin with", USAGE)
    from .read_ros import read_ros
    return read_ros
