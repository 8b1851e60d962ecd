"""Functions that write files, protect files of other programs, and convert values to JSON.

A file is written whole or not at all. It replaces only a file that this package wrote, unless ``force`` is
set.
"""

import contextlib
import hashlib
import json
import math
import os
import re
from base64 import b64encode
from collections.abc import Callable, Iterable, Iterator, Mapping
from enum import StrEnum
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np

from masonry_opt.errors import OptionError, OutputError

#: Name of this package in the metadata of the files that it writes.
WRITER = "masonry_opt"

#: Text of the comment that names this package as the writer of a file.
MARK = f"written by {WRITER}"

#: Key of a JSON file whose value is the name of the package that wrote the file.
JSON_KEY = "written_by"

#: Endings of the files with row and column names that accompany an .nl file. These files cannot contain
#: ``MARK``. The mark in the .nl file shows that this package wrote them.
_NAME_LISTS = (".row", ".col")

#: Map from the ending of a file's name to a regular expression for the mark. The mark is the text in a file
#: that shows that this package wrote the file.
_MARKS = {
    ".toml": rf"\A# {MARK}",
    ".json": rf'\A\s*{{\s*"{JSON_KEY}":\s*"{WRITER}"',
    ".dxf": rf"\A\s*999\r?\n{MARK}",
    ".cnf": rf"\Ac {MARK}",
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

#: Name of the file that records the SHA-256 digests of files that this package wrote to a folder. By its
#: digest, a later run recognises a file without ``MARK``, such as a table or a chart.
RECORD = ".masonry_opt.json"

#: Number of bytes at the start and at the end of a file that are searched for the mark of this package. Only
#: PDF files have the mark at the end.
_SEARCHED_BYTES = 1 << 16


def image_source(content: bytes | str, kind: str) -> str:
    """Return a picture ("png" or "svg") as a data URI, which an HTML page can use as an image source."""
    data = content.encode() if isinstance(content, str) else content
    return f"data:image/{kind.replace('svg', 'svg+xml')};base64,{b64encode(data).decode()}"


def picture_metadata(kind: str) -> dict[str, str | None]:
    """Return the metadata of a "png", "svg" or "pdf" picture: the name of this package, without a date."""
    if kind == "png":
        return {"Software": WRITER}
    return {"Creator": WRITER, "Date" if kind == "svg" else "CreationDate": None}


@contextlib.contextmanager
def writing(path: Path, note: str = "") -> Iterator[None]:
    """Convert an OSError in the ``with`` block to an OutputError.

    ``note`` is added to the message; it says which results remain.
    """
    try:
        yield
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror}{note}") from None


def write_whole(path: str | Path, content: str | bytes) -> None:
    """Write a file in one step: readers see either the old content or the complete new content.

    Raises OSError if the folder does not exist or cannot be written, or if the disk is full; the old file
    then remains.
    """
    path = Path(path)
    # Each writer has a temporary file with a unique name, so two processes that write the same file do not
    # mix their contents.
    temporary = path.parent / f".writing.{uuid4().hex}"
    try:
        temporary.write_bytes(_encoded(content))
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_together(contents: Mapping[Path, str | bytes]) -> None:
    """Write several files, each completely or not at all.

    ``contents`` maps each path to the content of its file. All contents are first written to temporary files,
    so that a full disk leaves every old file as it was. Raises OutputError, which names the first file that
    cannot be written.
    """
    temporaries = {path: path.parent / f".writing.{uuid4().hex}" for path in contents}
    try:
        for path, temporary in temporaries.items():
            with writing(path):
                temporary.write_bytes(_encoded(contents[path]))
        for path, temporary in temporaries.items():
            with writing(path):
                temporary.replace(path)
    finally:
        for temporary in temporaries.values():
            with contextlib.suppress(OSError):
                temporary.unlink(missing_ok=True)


def write_folder(
    folder: Path,
    contents: Mapping[str, str | bytes],
    force: bool = False,
    is_own: Callable[[str], bool] = lambda _: False,
) -> list[Path]:
    """Write files into a folder, and return their paths; ``contents`` maps names to contents.

    The record of the folder lists their digests, which show a later run that it may replace the files. A
    recorded file of an earlier run that is not among the contents is removed if ``is_own`` is true of its
    name. A file that was changed after it was written is not removed. :func:`refuse_outputs` raises
    OptionError if a file cannot be replaced.
    """
    refuse_outputs(folder, contents, force)
    record = _recorded(folder)
    for name, content in contents.items():
        # If this package wrote the existing file, the record also keeps the digest of the existing file. This
        # file remains in the folder until the new file replaces it.
        before = [digest for digest in record.get(name, []) if digest == _digest_of(folder / name)]
        record[name] = [*before, hashlib.sha256(_encoded(content)).hexdigest()]
    lines = json.dumps({JSON_KEY: WRITER, "files": record}, indent=1, ensure_ascii=False) + "\n"
    write_together({folder / RECORD: lines})
    paths = {folder / name: content for name, content in contents.items()}
    write_together(paths)
    for name in [name for name in record if is_own(name) and name not in contents]:
        if _digest_of(folder / name) in record[name]:
            with writing(folder / name):
                (folder / name).unlink()
    return [*paths]


def _encoded(content: str | bytes) -> bytes:
    """Return the content of a file as bytes; text is encoded as UTF-8."""
    return content.encode("utf-8") if isinstance(content, str) else content


def refuse_outputs(folder: Path, names: Iterable[str], force: bool = False) -> None:
    """Raise OptionError if files of a folder cannot be replaced; to be called before a long computation.

    A missing folder has no files. Without ``force``, only files that this package wrote are replaced.
    """
    for name in (*names, RECORD):
        path = folder / name
        if path.is_dir():
            raise OptionError(
                f"{path}: cannot be written, because a folder has this name: choose another folder"
            )
        refuse_replacing(path, force)


def refuse_unwritable(path: Path, force: bool = False) -> None:
    """Raise OptionError if a file cannot be written at a path; to be called before a long computation.

    Without ``force``, OptionError is also raised if the file would replace a file of another program.
    """
    try:
        path.lstat()
    except (FileNotFoundError, NotADirectoryError):
        pass
    except (OSError, ValueError) as error:
        # The operating system does not accept this path, which may be too long, for example.
        raise OptionError(f"{path}: cannot be written: {error}") from None
    if not path.parent.is_dir():
        raise OptionError(
            f"{path}: cannot be written, because the folder {path.parent} does not exist: create the folder"
        )
    if path.is_dir() or not os.access(path.parent, os.W_OK):
        obstacle = "a folder has this name" if path.is_dir() else f"the folder {path.parent} is not writable"
        raise OptionError(f"{path}: cannot be written, because {obstacle}: choose another path")
    refuse_replacing(path, force)


def refuse_replacing(path: Path, force: bool = False) -> None:
    """Raise OptionError if this package did not write an existing file, unless ``force`` is True.

    An empty file may always be replaced.
    """
    if not force and os.path.lexists(path) and not path.is_dir() and not is_replaceable(path):
        raise OptionError(
            f"{path}: the file exists already, and {WRITER} did not write its present content: choose "
            "another name or folder, or replace the file with --force (in Python: force=True)"
        )


def is_replaceable(path: Path) -> bool:
    """Return True if a file is empty, or if this package wrote it."""
    return is_written_by_package(path) or (path.is_file() and not path.stat().st_size)


def is_written_by_package(path: Path) -> bool:
    """Return True if this package wrote a file.

    The file is recognised by its recorded digest, or by a mark that names the package.
    """
    if not path.is_file():
        # The path does not lead to a regular file. It may be a pipe, a device or a link to a missing file.
        return False
    recorded = _recorded(path.parent).get(path.name)
    if recorded and _digest_of(path) in recorded:
        return True
    marked = path.with_suffix(".nl") if path.suffix.lower() in _NAME_LISTS else path
    mark = _MARKS.get(marked.suffix.lower())
    if mark is None:
        return False
    try:
        with marked.open("rb") as stream:
            data = stream.read(_SEARCHED_BYTES)
            size = marked.stat().st_size
            if size > _SEARCHED_BYTES:
                stream.seek(max(_SEARCHED_BYTES, size - _SEARCHED_BYTES))
                data += stream.read()
    except OSError:
        return False
    return re.search(mark.encode(), data, re.DOTALL) is not None


def _recorded(folder: Path) -> dict[str, list[str]]:
    """Read the record of a folder, and return the digests of each file, keyed by the file's name.

    The result is empty if the folder has no valid record.
    """
    try:
        files = json.loads((folder / RECORD).read_bytes())["files"]
        return {str(name): [*map(str, digests)] for name, digests in files.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


def _digest_of(path: Path) -> str:
    """Return the SHA-256 digest of a file, or "" if the file cannot be read."""
    try:
        with path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError:
        return ""


def plain(value: Any) -> Any:
    """Convert a value to plain types, which JSON can represent; NaN and infinity become None."""
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
        return value + 0.0 if math.isfinite(value) else None  # turns −0.0 into 0.0
    return value
