"""journal.jsonl: one line a finished run, in the file before the next row is taken."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from masonry_opt.errors import OptionError, OutputError
from masonry_opt.files import write_whole
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.endings import CRASHED, DIED
from masonry_opt.studies.machine import versions
from masonry_opt.studies.many.runs import Study, Task

#: Its name in a study's folder.
NAME = "journal.jsonl"


class Journal:
    """The finished runs of one study in a folder.

    A last line torn by an interruption is dropped when the file is opened, and its run made again. A row may
    be added as long as the disk has room; where it has none, those before stay.

    Raises
    ------
    OptionError
        If the folder holds runs of another scene, method, options or versions.
    OutputError
        If it cannot be read or written.
    """

    def __init__(self, folder: Path, study: Study) -> None:
        self.path = folder / NAME
        head = _identity(study)
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

    def find(self, task: Task) -> dict[str, Any] | None:
        """The row of a task, if it was made; not of one that crashed or whose worker died, which something
        else than the run (want of memory) may have ended."""
        row = self._rows.get(_key(task))
        return None if row is None or row["status"] in (CRASHED, DIED) else dict(row)

    def add(self, task: Task, row: dict[str, Any]) -> None:
        """Keep a row: in the file when this returns."""
        key = _key(task)
        try:
            with self.path.open("ab") as stream:
                stream.write(_line({"key": key, "row": row}))
        except OSError as error:
            raise OutputError(
                f"{self.path}: cannot be written: {error.strerror}; the runs before are kept, and the same "
                "command goes on from there"
            ) from None


def _identity(study: Study) -> dict[str, str]:
    """Hashes of what decides a study's rows, by what they are of."""
    scene = study.scene
    options = {name: repr(value) for name, value in sorted(study.options.items())}
    return {
        "scene": "" if scene is None else _of_scene(scene),
        "method": _hash((study.method, study.model, study.solver, study.tolerance)),
        "options": _hash(options),
        "versions": _hash(versions()),
    }


def _key(task: Task) -> str:
    values = {name: float(value) for name, value in task.values.items()}
    return _hash((values, None if task.scene is None else _of_scene(task.scene)))


def _of_scene(scene: Scene) -> str:
    # Of generators too: two files may say the same blocks, and vary otherwise.
    case = None if scene.case is None else scene.case.model_dump_json()
    return _hash((scene.model_dump_json(), case))


def _hash(content: object) -> str:
    return hashlib.sha256(repr(content).encode()).hexdigest()[:16]


def _line(content: Mapping[str, Any]) -> bytes:
    return json.dumps(content, ensure_ascii=False).encode() + b"\n"
