"""results.csv: one line a finished run, safe on disk before the next begins."""

from __future__ import annotations

import csv
import io
import os
from pathlib import Path
from typing import Any

from masonry_opt.effort import PARTS
from masonry_opt.errors import OptionError, OutputError
from masonry_opt.files import write_whole
from masonry_opt.studies.compare.case_scenes import CaseScene
from masonry_opt.studies.compare.measure import MEMORY_LIMIT, TIME_LIMIT, Ended
from masonry_opt.studies.compare.plan import Pair, PlannedRun
from masonry_opt.studies.endings import DIED

#: What a run is: a line with the same is not measured again.
_KEY = ("scene", "content", "versions", "method", "model", "solver", "tolerance", "repeat")

_WORDS = ("ended", "status", "kind", "existence", "crushing", "message")
_NUMBERS = (
    "load_factor",
    "bound",
    "equilibrium",
    "yield",
    "flow",
    "complementarity",
    "wall",
    *(f"{part}_seconds" for part in PARTS),
    "peak_memory",
    "lp_solves",
    "nlp_solves",
    "iterations",
    "blocks",
    "joints",
    "rows",
    "columns",
    "nonzeros",
    "time_limit",
    "memory_limit",
)
COLUMNS = (*_KEY, *_WORDS, *_NUMBERS)


def row(
    scene: CaseScene, run: PlannedRun, versions: str, ended: Ended, time_limit: float, memory_limit: float
) -> dict[str, Any]:
    """A run as a line: seconds, memory in MB, λ and its certificate.

    ``wall`` is the solve by the clock; of a run that did not finish, its process's time.
    """
    value = ended.value or {}
    line = dict.fromkeys(COLUMNS) | {
        "scene": scene.name,
        "content": scene.content,
        "versions": versions,
        "method": run.pair.method,
        "model": run.pair.model,
        "solver": run.pair.solver,
        "tolerance": run.pair.tolerance,
        "repeat": run.repeat,
        "ended": ended.how,
        "status": value.get("status", ""),
        "kind": value.get("kind", ""),
        "existence": (value.get("infeasibility") or {}).get("existence", ""),
        "crushing": value.get("crushing", ""),
        "message": _one_line(value.get("message", ended.reason)),
        "wall": value.get("wall", ended.seconds),
        "peak_memory": ended.peak,
        "time_limit": time_limit,
        "memory_limit": memory_limit,
    }
    same = ("load_factor", "bound", "lp_solves", "nlp_solves", "iterations", "blocks", "joints")
    line |= {name: value.get(name) for name in same}
    line |= {name: value.get("size", {}).get(name) for name in ("rows", "columns", "nonzeros")}
    line |= {f"{part}_seconds": value.get("seconds", {}).get(part) for part in PARTS}
    return line | (value.get("certificate") or {})


class Store:
    """The file of a comparison's runs.

    A last line torn by an interruption is dropped when the file is opened, and its run made again.

    Raises
    ------
    OptionError
        If the file has other columns.
    OutputError
        If it cannot be read or written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            data = path.read_bytes() if path.exists() else b""
            whole = data[: data.rfind(b"\n") + 1]
            if not whole:
                whole = _line(COLUMNS)
            if whole != data:
                write_whole(path, whole)
        except OSError as error:
            raise OutputError(f"{path}: cannot be written: {error.strerror}") from None
        lines = list(csv.reader(io.StringIO(whole.decode("utf-8", errors="replace"))))
        if tuple(lines[0]) != COLUMNS:
            raise OptionError(f"{path}: has other columns: of another version; choose another --out")
        fields = (dict(zip(COLUMNS, line, strict=True)) for line in lines[1:] if len(line) == len(COLUMNS))
        self.rows = [_numbers(line) for line in fields]
        self._done = {_identity(line): line for line in self.rows}

    def add(self, line: dict[str, Any]) -> None:
        """Keep a run: on disk when this returns."""
        try:
            with self.path.open("ab") as stream:
                stream.write(_line(["" if line[name] is None else line[name] for name in COLUMNS]))
                stream.flush()
                os.fsync(stream.fileno())
        except OSError as error:
            raise OutputError(f"{self.path}: cannot be written: {error.strerror}") from None
        self.rows.append(line)
        self._done[_identity(line)] = line

    def find(
        self, scene: CaseScene, run: PlannedRun, versions: str, time_limit: float, memory_limit: float
    ) -> dict[str, Any] | None:
        """The line of a run, if it was made; not of one killed at a limit since raised, nor of one that died
        without a word, which something else than the run may have killed."""
        pair = run.pair
        line = self._done.get(
            (
                scene.name,
                scene.content,
                versions,
                pair.method,
                pair.model,
                pair.solver,
                pair.tolerance,
                run.repeat,
            )
        )
        if line is None or line["ended"] == DIED:
            return None
        raised = (line["ended"] == TIME_LIMIT and time_limit > line["time_limit"]) or (
            line["ended"] == MEMORY_LIMIT and memory_limit > line["memory_limit"]
        )
        return None if raised else line


def pair_of(line: dict[str, Any]) -> Pair:
    """The pair that a line is of."""
    return Pair(line["method"], line["model"], line["solver"], line["tolerance"])


def _identity(line: dict[str, Any]) -> tuple[Any, ...]:
    return tuple(line[name] for name in _KEY)


def _one_line(text: str) -> str:
    return " ".join(text.split())


def _line(fields: Any) -> bytes:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(fields)
    return text.getvalue().encode("utf-8")


def _numbers(line: dict[str, str]) -> dict[str, Any]:
    read: dict[str, Any] = dict(line)
    for name in (*_NUMBERS, "tolerance"):
        read[name] = float(line[name]) if line[name] else None
    read["repeat"] = int(line["repeat"])
    return read
