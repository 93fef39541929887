"""Output that is replaced whole or not at all."""

import os
import shutil
import stat
import sys
import tempfile
from pathlib import Path

from gustlab_import.write_log import file_on_the_way

from .problems import IO, USAGE, Refusal

STDOUT = Path("-")


def replace_file(path: Path, inputs: tuple, write) -> None:
    """Calls write(temporary path), then puts the result in the place of path."""
    replace_files({Path(path): write}, inputs)


def check_paths(paths) -> None:
    """Refuses a path that is a folder, or that has a file where a folder should be."""
    for path in paths:
        if path.is_dir():
            raise Refusal(f"{path}: is a folder, not a file; name another output", USAGE)
        if file := file_on_the_way(path.parent):
            raise Refusal(f"{path}: cannot be written ({file} is a file, not a folder); name another output", USAGE)


def where_writing_ends(path: Path) -> Path:
    """Links are followed, also to a file that is not there yet."""
    end = Path(os.path.realpath(path)) if path.is_symlink() else path
    if end.is_symlink():
        raise Refusal(f"{path}: cannot be written (its links lead in a circle); name another output", USAGE)
    return end


def is_written_through(path: Path) -> bool:
    """A device or a pipe, which nothing takes the place of; also stdout."""
    return path == STDOUT or path.exists() and not stat.S_ISREG(path.stat().st_mode)


def write_through(temporary: str, path: Path) -> None:
    with open(temporary, "rb") as source, (os.fdopen(os.dup(sys.stdout.fileno()), "wb") if path == STDOUT else open(path, "wb")) as end:
        shutil.copyfileobj(source, end)
    os.unlink(temporary)


def replace_files(writes: dict, inputs: tuple) -> None:
    """The same of several files, by their paths: all of them are there when it ends, or none is."""
    temporary, made = {}, []
    writes = {where_writing_ends(path): write for path, write in writes.items()}
    check_paths(writes)
    try:
        for path, write in writes.items():
            if path.exists() and any(other.exists() and path.samefile(other) for other in inputs):
                raise Refusal(f"{path}: is read by the same command; name another output", USAGE)
            made += [folder for folder in path.parents if not folder.exists()]
            path.parent.mkdir(parents=True, exist_ok=True)
            beside = None if is_written_through(path) else path.parent
            handle, temporary[path] = tempfile.mkstemp(dir=beside, prefix=".gustlab-", suffix=path.suffix)
            os.close(handle)
            write(Path(temporary[path]))
            os.chmod(temporary[path], stat.S_IMODE(path.stat().st_mode) if path.is_file() else 0o644)
        for path in writes:
            (write_through if is_written_through(path) else os.replace)(temporary[path], path)
            del temporary[path]
        made = []
    except OSError as error:
        raise Refusal(f"{path}: cannot be written ({error.strerror or error})", IO) from None
    finally:
        for left in temporary.values():
            Path(left).unlink(missing_ok=True)  # pyarrow removes what it could not write
        for folder in made:
            if folder.exists():
                folder.rmdir()
