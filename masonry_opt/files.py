"""Files are written whole or not at all, and replace none without a mark of this package; plain data."""

import contextlib
import math
import os
import re
from base64 import b64encode
from collections.abc import Iterator
from enum import StrEnum
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np

from masonry_opt.errors import OptionError, OutputError

WRITER = "masonry_opt"  #: Who wrote a file, in its metadata; and a comment that says it.
MARK = f"written by {WRITER}"

JSON_KEY = "written_by"  #: The key of JSON files that says it.

#: Patterns of marks by the end of a file's name. Lists of names (.row, .col) bear that of their .nl file.
_MARKS = {
    ".toml": rf"\A# {MARK}",
    ".json": rf'\A\s*{{\s*"{JSON_KEY}":\s*"{WRITER}"',
    ".dxf": rf"\A\s*999\r?\n{MARK}",
    ".lp": rf"\A\\ {MARK}",
    ".mps": rf"\A\* {MARK}",
    ".nl": rf"\A[^\n]*# problem [\"']?{MARK}",
    ".obj": rf"\A# {MARK}",
    ".glb": rf'"generator":\s*"{WRITER}"',
    ".gltf": rf'"generator":\s*"{WRITER}"',
    ".png": rf"\A\x89PNG.*tEXtSoftware\x00{WRITER}",
    ".svg": rf"<dc:creator>\s*<cc:Agent>\s*<dc:title>{WRITER}</dc:title>",
    ".pdf": rf"/Creator \({WRITER}\)",
    ".html": rf'<meta name="generator" content="{WRITER}">',
}

_ENDS = 1 << 16  #: Bytes at either end of a file in which its mark stands: only of PDF files at the end.


def image_source(content: bytes | str, kind: str) -> str:
    """A picture's content, "png" or "svg", as the address of an image in HTML."""
    of = content.encode() if isinstance(content, str) else content
    return f"data:image/{kind.replace('svg', 'svg+xml')};base64,{b64encode(of).decode()}"


def picture_metadata(kind: str) -> dict[str, str | None]:
    """What a picture of a kind ("png", "svg", "pdf") says of itself: its mark, and no date."""
    if kind == "png":
        return {"Software": WRITER}
    return {"Creator": WRITER, "Date" if kind == "svg" else "CreationDate": None}


@contextlib.contextmanager
def writing(path: Path, kept: str = "") -> Iterator[None]:
    """Turn errors of writing a file into those of this package, which end with what is kept all the same."""
    try:
        yield
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror}{kept}") from None


def write_whole(path: str | Path, content: str | bytes) -> None:
    """Write a file so that a reader sees the old content or the new, never a part. Raises OSError if the
    folder is missing, full or cannot be written; the old file then stands."""
    path = Path(path)
    data = content.encode("utf-8") if isinstance(content, str) else content
    # A name of its own for every writer: of two that write at once, the last to end is kept whole.
    temporary = path.parent / f".writing.{uuid4().hex}"
    try:
        temporary.write_bytes(data)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def refuse_unwritable(path: Path, force: bool = False) -> None:
    """Raise OptionError if a file could not be written there, or, without ``force``, would replace one that
    was not written here: to be asked before long work."""
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
    refuse_replacing(path, force)


def refuse_replacing(path: Path, force: bool = False) -> None:
    """Raise OptionError if a file that holds something bears no mark of this package, unless ``force``."""
    if not force and os.path.lexists(path) and not path.is_dir() and not _is_replaceable(path):
        unmarked = f"is there already, and does not bear the mark of what {WRITER} writes"
        instead = "choose another name, or replace it with --force (in Python: force=True)"
        raise OptionError(f"{path}: {unmarked}: {instead}")


def _is_replaceable(path: Path) -> bool:
    if not path.is_file():  # a pipe, a device, a link to nothing
        return False
    suffix = path.suffix.lower()
    if suffix not in _MARKS:  # a list of names
        path, suffix = path.with_suffix(".nl"), ".nl"
    try:
        with path.open("rb") as stream:
            data = stream.read(_ENDS)
            if (size := path.stat().st_size) > _ENDS:
                stream.seek(max(_ENDS, size - _ENDS))
                data += stream.read()
    except OSError:
        return False
    return not data or re.search(_MARKS[suffix].encode(), data, re.DOTALL) is not None


def plain(value: Any) -> Any:
    """The same as JSON has it; NaN as None."""
    if isinstance(value, StrEnum):
        return str(value)
    if hasattr(value, "as_dict"):
        value = value.as_dict()
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return value + 0.0 if math.isfinite(value) else None  # no minus before a zero
    return value
