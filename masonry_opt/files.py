"""Files are written whole or not at all."""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path

from masonry_opt.errors import OptionError


def write_whole(path: str | Path, content: str | bytes) -> None:
    """Write a file so that a reader sees the old content or the new, never a part.

    Raises OSError if the folder is missing, full or cannot be written; the old file then stands.
    """
    path = Path(path)
    data = content.encode("utf-8") if isinstance(content, str) else content
    # A name of its own for every writer: of two that write at once, the last to end is kept whole.
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=".writing.")
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(data)
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    except BaseException:
        with contextlib.suppress(OSError):  # the folder may be gone: the first error is the cause
            os.unlink(temporary)
        raise


def refuse_unwritable(path: Path) -> None:
    """Raise OptionError if a file could not be written there: to be asked before long work."""
    try:
        path.lstat()
    except (FileNotFoundError, NotADirectoryError):
        pass
    except (OSError, ValueError) as error:  # a path no file can have
        raise OptionError(f"{path}: cannot be written: {error}") from None
    if not path.parent.is_dir():
        raise OptionError(f"{path}: cannot be written: there is no folder {path.parent}")
    if path.is_dir() or not os.access(path.parent, os.W_OK):
        why = "is a folder" if path.is_dir() else f"folder {path.parent} does not let files be written"
        raise OptionError(f"{path}: cannot be written: {why}")


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
