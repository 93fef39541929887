"""Outputs: a regular file is replaced whole or not at all, links are followed, devices, FIFOs and "-" (stdout) are written through."""

import contextlib
import os
import secrets
import sys
from pathlib import Path

from .interrupts import held_back, throw_if_interrupted
from .problems import IO, USAGE, ImportFailure

STDOUT = Path("-")


def file_on_the_way(folder: Path):
    """What stands where this folder or one of its parents should be, and is no folder; None: nothing."""
    there = next((path for path in (folder, *folder.parents) if path.exists()), None)
    return None if there is None or there.is_dir() else there


def check_outputs(paths, inputs=()) -> None:
    """Before long work: refuses what write_outputs would refuse."""
    for path in paths:
        _target(Path(path), inputs)


def write_outputs(files: dict, inputs=()) -> None:
    """Writes path -> bytes, all or none, never over one of `inputs`. Throws ImportFailure: 2 a wrong path, 4 what the disk refuses."""
    throw_if_interrupted()
    targets = {path: _target(Path(path), inputs) for path in files}
    for path, target in targets.items():
        if target is None:
            with _refused(path):
                _write_through(Path(path), files[path])
    with held_back():
        _replace([(path, target, files[path]) for path, target in targets.items() if target is not None])


def _target(path: Path, inputs):
    """The regular file that a path leads to, which need not be there; None: it is written through."""
    if path == STDOUT:
        return None
    target = Path(os.path.realpath(path))
    try:
        if path.exists() and not path.is_file() and not path.is_dir():
            return None
        wrong = "it is a folder, not a file" if target.is_dir() else "symbolic links in a circle" if target.is_symlink() else ""
        if not wrong and (file := file_on_the_way(path.parent)):
            wrong = f"{file} is a file, not a folder"
    except OSError as error:
        wrong = error.strerror
    if wrong:
        raise ImportFailure(f"{path}: cannot be written ({wrong}); name another output", USAGE)
    if target.exists() and any(other.exists() and target.samefile(other) for other in inputs):
        raise ImportFailure(f"{path}: is an input of this command (it would be lost); name another file", USAGE)
    folder = next(folder for folder in target.parents if folder.exists())
    if not os.access(folder, os.W_OK) or target.exists() and not os.access(target, os.W_OK):
        raise ImportFailure(f"{path}: cannot be written (Permission denied)", IO)
    return target


@contextlib.contextmanager
def _refused(path):
    try:
        yield
    except OSError as error:
        raise ImportFailure(f"{path}: cannot be written ({error.strerror})", IO) from error


def _write_through(path: Path, content: bytes) -> None:
    sys.stdout.flush()
    with open(sys.stdout.fileno() if path == STDOUT else path, "wb", closefd=path != STDOUT) as stream:
        stream.write(content)


def _replace(files: list) -> None:
    """(path as it was given, target, bytes) of regular files."""
    beside, made = {}, []
    try:
        for path, target, content in files:
            with _refused(path):
                made += [folder for folder in target.parents if not folder.exists()]
                target.parent.mkdir(parents=True, exist_ok=True)
                beside[target] = target.with_name(f".gustlab.{secrets.token_hex(8)}")
                with open(beside[target], "xb") as stream:
                    stream.write(content)
                if target.exists():
                    beside[target].chmod(target.stat().st_mode & 0o7777)
        for path, target, _ in files:
            with _refused(path):
                os.replace(beside[target], target)
                del beside[target]
        made = []
    finally:
        for left in beside.values():
            left.unlink(missing_ok=True)
        for folder in sorted(set(made), reverse=True):  # a folder with files in it stays
            with contextlib.suppress(OSError):
                folder.rmdir()
