"""Output that is replaced whole or not at all."""

import os
import tempfile
from pathlib import Path

from .problems import IO, USAGE, Refusal


def replace_file(path: Path, inputs: tuple, write) -> None:
    """Calls write(temporary path), then puts the result in the place of path."""
    path = Path(path)
    if path.exists() and any(other.exists() and path.samefile(other) for other in inputs):
        raise Refusal(f"{path}: is read by the same command (name another output)", USAGE)
    temporary = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=".gustlab-", suffix=path.suffix)
        os.close(handle)
        write(Path(temporary))
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except OSError as error:
        raise Refusal(f"{path}: cannot be written ({error.strerror or error})", IO) from None
    finally:
        if temporary and os.path.exists(temporary):
            os.unlink(temporary)
