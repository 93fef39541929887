"""Output that is replaced whole or not at all."""

import os
import tempfile
from pathlib import Path

from gustlab_import.write_log import file_on_the_way

from .problems import IO, USAGE, Refusal


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


def replace_files(writes: dict, inputs: tuple) -> None:
    """The same of several files, by their paths: all of them are there when it ends, or none is."""
    temporary, made = {}, []
    check_paths(writes)
    try:
        for path, write in writes.items():
            if path.exists() and any(other.exists() and path.samefile(other) for other in inputs):
                raise Refusal(f"{path}: is read by the same command; name another output", USAGE)
            made += [folder for folder in path.parents if not folder.exists()]
            path.parent.mkdir(parents=True, exist_ok=True)
            handle, temporary[path] = tempfile.mkstemp(dir=path.parent, prefix=".gustlab-", suffix=path.suffix)
            os.close(handle)
            write(Path(temporary[path]))
            os.chmod(temporary[path], 0o644)
        for path in writes:
            os.replace(temporary.pop(path), path)
        made = []
    except OSError as error:
        raise Refusal(f"{path}: cannot be written ({error.strerror or error})", IO) from None
    finally:
        for left in temporary.values():
            Path(left).unlink(missing_ok=True)  # pyarrow removes what it could not write
        for folder in made:
            if folder.exists():
                folder.rmdir()
