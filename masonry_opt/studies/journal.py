"""What a study keeps: journal.jsonl, its finished runs, one line each, from which it continues; and the
machine, the versions and the command that made them."""

import hashlib
import json
import os
import platform
import shlex
import sys
from collections.abc import Mapping
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import psutil

from masonry_opt.errors import OptionError, OutputError
from masonry_opt.files import write_whole

NAME = "journal.jsonl"

#: Packages whose versions decide times and answers.
_PACKAGES = (
    *("masonry_opt", "cvxpy", "pyomo", "clarabel", "highspy", "osqp", "scs", "casadi", "scipy", "numpy"),
)


class Journal:
    """The finished runs of one study in a folder; the first line, its head, has hashes of all that decides
    the rows, by name.

    An incomplete last line is dropped when the file is opened, and its run made again. If the disk is full,
    earlier rows stay.

    Raises OptionError if the folder holds runs of another head, OutputError if it cannot be read or written.
    """

    def __init__(self, folder: Path, head: Mapping[str, str]) -> None:
        self.path = folder / NAME
        try:
            folder.mkdir(parents=True, exist_ok=True)
            data = self.path.read_bytes() if self.path.exists() else b""
            whole = data[: data.rfind(b"\n") + 1] or _line(head)
            if whole != data:
                write_whole(self.path, whole)
        except OSError as error:
            raise OutputError(f"{self.path}: cannot be written: {error.strerror}") from None
        try:
            first, *lines = [json.loads(line) for line in whole.splitlines()]
            changed = [what for what in head if first.get(what) != head[what]]
            self._rows: dict[str, dict[str, Any]] = {line["key"]: line["row"] for line in lines}
        except (ValueError, KeyError, TypeError, AttributeError):
            raise OptionError(f"{self.path}: is no journal of runs: choose another folder") from None
        if changed:
            raise OptionError(
                f"{folder}: holds runs with other {', '.join(changed)}: choose another folder, or remove "
                f"{self.path} to begin anew"
            )

    def find(self, key: str) -> dict[str, Any] | None:
        return self._rows.get(key)

    def add(self, key: str, row: Mapping[str, Any]) -> None:
        """Keep a row; it is on disk when this returns."""
        try:
            with self.path.open("ab") as stream:
                stream.write(_line({"key": key, "row": row}))
                stream.flush()
                os.fsync(stream.fileno())
        except OSError as error:
            raise OutputError(
                f"{self.path}: cannot be written: {error.strerror}; the runs before are kept, and the same "
                "command goes on from there"
            ) from None
        self._rows[key] = dict(row)


def digest(content: object) -> str:
    """Short hash of what decides a row."""
    return hashlib.sha256(repr(content).encode()).hexdigest()[:16]


def _line(content: Mapping[str, Any]) -> bytes:
    return json.dumps(content, ensure_ascii=False).encode() + b"\n"


def versions() -> dict[str, str]:
    """Python's and the packages' versions; "not installed" where there is none."""
    found = {"python": platform.python_version()}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found


def machine() -> dict[str, str]:
    """Processor, cores, memory and system."""
    lines: list[str] = []
    with suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    named = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return {
        "processor": named[0] if named else platform.processor() or platform.machine(),
        "cores": str(os.cpu_count()),
        "memory": f"{psutil.virtual_memory().total / 1e9:.0f} GB",
        "system": f"{platform.system()} {platform.release()}",
        "threads": "one a run, on one core",
        "command": shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]]),
    }
