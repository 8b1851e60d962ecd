"""Read case files as plain tables, in bounded time and memory, whatever a file contains."""

import importlib
import json
import math
import re
import stat
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from masonry_opt.errors import CaseError, MasonryError, OptionError
from masonry_opt.files import JSON_KEY, write_whole
from masonry_opt.scene.mistakes import did_you_mean, repeated
from masonry_opt.scene.syntax_advice import advice_on_line, other_content

#: Largest size of a case file, in bytes. Larger files are refused, because reading a file needs about 80
#: times its size in memory, and up to 400 times for a malicious file. A file of this size has about 90,000
#: blocks, more than can be solved.
LARGEST_FILE = 10_000_000

#: Largest number of entries in one list of tables. Longer lists are refused, because the error message of
#: each invalid entry needs memory and time.
_MOST_ENTRIES = 200_000

#: Largest number of parts of a dotted key; longer keys are refused. Case files need three parts. The memory
#: for parsing a key grows with the square of its number of parts.
_MOST_KEY_PARTS = 9

#: Regular expression for one part of a dotted key.
_PART = r"""(?:"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+'|(?<![\w-])[\w-]++)"""

#: Regular expression for a dotted key with too many parts.
_LONG_KEY = re.compile(rf"{_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{_MOST_KEY_PARTS}}}")


def as_path(path: str | Path, description: str, *ends: str) -> Path:
    """Convert the path of a file to a ``Path`` object, and check its ending.

    ``description`` names the file in error messages. Raises CaseError if ``path`` is neither a text nor a
    path, or if it does not have one of the endings ``ends``.
    """
    try:
        path = Path(path)
    except TypeError:
        raise CaseError(
            f"the path of {description} must be text or a pathlib.Path (found {type(path).__name__})"
        ) from None
    if ends and path.suffix.lower() not in ends:
        raise CaseError(f"{path}: the name of {description} must end in {' or '.join(ends)}")
    return path


def read_tables(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML or JSON file as a dictionary.

    Raises CaseError if the file cannot be read, is too large or is not valid.
    """
    case = parse_file(path)
    if not isinstance(case, dict):
        raise CaseError(f"{path}: the file must contain a single JSON object with the keys of a case file")
    case.pop(JSON_KEY, None)
    if "dtype" in case and "data" in case:
        raise CaseError(f"{path}: this is COMPAS data: convert it to a case file with the command 'convert'")
    if "certificate" in case and "status" in case:
        raise CaseError(f"{path}: this is the result of an analysis: give the path of the case file instead")
    for key, value in case.items():
        if isinstance(value, list) and len(value) > _MOST_ENTRIES:
            raise CaseError(
                f"{path}: '{key[:60]}' has {len(value)} entries, "
                f"but at most {_MOST_ENTRIES} are allowed: split the scene"
            )
    return case


def parse_file(path: Path) -> Any:
    """Return the parsed content of a ``.toml`` or ``.json`` file; any type of content is valid.

    Raises CaseError as :func:`read_tables` does.
    """
    remedy = "split the scene into smaller scenes, or generate its blocks with [wall]"
    data = read_bytes(path, LARGEST_FILE, remedy)
    if path.suffix.lower() not in _PARSERS:
        raise CaseError(f"{path}: the name of a case file must end in .toml or .json")
    try:
        text = data.decode("utf-8-sig")
        return _PARSERS[path.suffix.lower()](text)
    except UnicodeDecodeError:
        raise CaseError(f"{path}: the file is not UTF-8 text: save it in the encoding UTF-8") from None
    except RecursionError:
        raise CaseError(f"{path}: the lists or tables are nested too deeply for a case file") from None
    except ValueError as error:
        # Python refuses to convert integers with thousands of digits. Replace Python's message, because it
        # does not explain the mistake in the file.
        message = str(error)
        if "integer string conversion" in message:
            message = "a whole number has thousands of digits"
        if len(message) > 300:
            message = message[:297] + "..."
        advice = advice_on_line(text, message, path.suffix.lower())
        reason = f"{message}: {advice}" if advice else message
        raise CaseError(f"{path}: the file is not valid {path.suffix[1:].upper()}: {reason}") from None


def read_bytes(path: Path, largest: int, remedy: str) -> bytes:
    """Return the content of a file.

    Raises CaseError if the file does not exist, is not a regular file, or is larger than ``largest`` bytes.
    The error for a large file ends with ``remedy``. CaseError is also raised if the content is a web page, an
    archive or the like.
    """
    data = b""
    try:
        mode = path.stat().st_mode
        if stat.S_ISREG(mode):  # read only regular files: reading a pipe or a device might never end
            with path.open("rb") as stream:
                data = stream.read(largest + 1)
    except FileNotFoundError:
        raise CaseError(f"{path}: no such file{_similar_file(path)}") from None
    except (OSError, ValueError) as error:  # ValueError means that the path has an invalid character
        raise CaseError(f"{path}: cannot be read: {getattr(error, 'strerror', error)}") from None
    if stat.S_ISDIR(mode):
        raise CaseError(f"{path}: this is a folder: give the path of a file")
    if not stat.S_ISREG(mode):
        raise CaseError(f"{path}: this is a pipe or device: give the path of a regular file")
    description = other_content(data)
    if description:
        raise CaseError(f"{path}: {description}")
    if len(data) > largest:
        raise CaseError(f"{path}: the file is larger than {largest // 1_000_000} MB: {remedy}")
    return data


def _similar_file(path: Path) -> str:
    """Return a clause that suggests a file with a similar name in the same folder, or an empty text."""
    if not path.parent.is_dir():
        return f", because the folder {path.parent} does not exist"
    try:
        names = [entry.name for entry in path.parent.iterdir() if entry.is_file()]
    except OSError:  # the user may not list the folder
        return ""
    # Users often omit the ending of a name. If files with the given name plus ``.toml`` or ``.json`` exist,
    # suggest only these files.
    same_stem = [name for name in names if name in (f"{path.name}.toml", f"{path.name}.json")]
    return did_you_mean(path.name, same_stem or names) or did_you_mean(f"{path.name}.toml", same_stem)


def write_file(path: Path, content: str | bytes, refusal: type[MasonryError]) -> None:
    """Write a file completely or not at all.

    Raises ``refusal`` if the file cannot be written.
    """
    try:
        write_whole(path, content)
    except (OSError, ValueError) as error:
        raise refusal(f"{path}: cannot be written: {getattr(error, 'strerror', error)}") from None


def library(name: str, hint: str) -> Any:
    """Import and return a library that is an optional dependency.

    Raises OptionError with the text ``hint`` if the library is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError:
        raise OptionError(hint) from None


@contextmanager
def broken(refusal: Callable[[str], Exception]) -> Iterator[None]:
    """Replace an exception that a library raises for an invalid file by an error with a one-line message."""
    try:
        yield
    except MemoryError:
        raise
    except Exception as error:
        raise refusal(" ".join(str(error).split())[:200] or type(error).__name__) from None


def _parse_toml(text: str) -> Any:
    """Return the content of a TOML text as a dictionary.

    Raises ValueError if a key has too many parts.
    """
    long_key = _LONG_KEY.search(text)
    if long_key:
        line = text.count("\n", 0, long_key.start()) + 1
        raise ValueError(f"line {line} has a key with more than {_MOST_KEY_PARTS} parts: shorten the key")
    return tomllib.loads(text, parse_float=_parse_number)


def _parse_number(text: str) -> float:
    """Convert a text to a number.

    Raises ValueError if the number is too large for double precision.
    """
    value = float(text)
    if math.isinf(value) and "inf" not in text:
        raise ValueError(f"the number {text[:40]} is too large")
    return value


def _refuse_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Convert the key–value pairs of a JSON object to a dictionary, and refuse repeated keys.

    Raises ValueError if a key occurs twice, because the parser would silently use its last value.
    """
    for key in repeated(key for key, _ in pairs):
        raise ValueError(f"key '{key}' occurs twice in one object")
    return dict(pairs)


_PARSERS: dict[str, Callable[[str], Any]] = {
    ".toml": _parse_toml,
    ".json": partial(json.loads, object_pairs_hook=_refuse_repeats, parse_float=_parse_number),
}
