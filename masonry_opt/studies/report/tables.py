"""Tables of a report: a scene's records key by key, and forces and motion of its joints."""

import re
from collections.abc import Mapping, Sequence
from itertools import compress
from typing import Any

import pandas as pd

from masonry_opt.answer.motion import joint_motion
from masonry_opt.answer.thresholds import IDLE
from masonry_opt.errors import printable
from masonry_opt.result import Result
from masonry_opt.scene.blocks import Record
from masonry_opt.scene.case_file import toml_text
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.writing import frame_table, table

_ROWS, _LINES = 150, 600  #: Rows of a table, and lines of a case, that are printed at most.

#: Lists of a scene's records, by what their tables are headed.
_RECORDS = {"Joints that differ": "exceptions", "Fill": "fills", "Loads on blocks": "loads"}
_RECORDS |= {"Loads along edges": "edge_loads", "Ties": "ties", "Props": "props", "Load cases": "load_cases"}

#: Columns of the table of joints, in the plane and in space.
_JOINTS = ("first", "second", "x", "y", "z", "length", "area", "n", "s", "m", "e", "torsion", "utilisation")

_DOES = ("slides", "hinges", "separates", "crushes")  #: What joints do.
_LIST = re.compile(r"\[\n\s*([^][{}]*?),?\n\s*\]")  #: An innermost list of TOML, written over several lines.


def given(scene: Scene, axles: Sequence[Record]) -> dict[str, dict[str, Any]]:
    """Records of a scene, and axles, key by key, as tables of a page by their headings."""
    records = {heading: getattr(scene, name) for heading, name in _RECORDS.items()} | {"Axles": axles}
    return {_counted(heading, of): _of_records(of[:_ROWS]) for heading, of in records.items() if of}


def _counted(heading: str, rows: Sequence[object] | pd.DataFrame) -> str:
    count = len(rows)
    return f"{heading} ({count if count <= _ROWS else f'{_ROWS} of {count}'})"


def _of_records(records: Sequence[Record]) -> dict[str, Any]:
    rows = [one.model_dump(exclude_defaults=True) for one in records]
    keys = list(dict.fromkeys(key for row in rows for key in row))
    return table(keys, ([_said(row.get(key, "")) for key in keys] for row in rows))


def _said(value: object) -> str:
    """A value of a record as a cell."""
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_said(one)}" for key, one in value.items())
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_said, value))}]"
    return f"{value:.6g}" if isinstance(value, float) else printable(str(value))


def case_text(scene: Scene) -> str:
    """Content of the scene's case file, generators not expanded; "" where that is too long to print."""
    text = toml_text(scene.case or scene)
    while (joined := _LIST.sub(lambda found: f"[{' '.join(found[1].split())}]", text)) != text:
        text = joined
    return text if text.count("\n") <= _LINES else ""


def of_result(result: Result) -> dict[str, dict[str, Any]]:
    """Joints, ties and pressures of fill as tables of a page by their headings."""
    pressures = result.pressures.drop(columns=["kind", "second"])
    frames = {"Joints": _joints(result), "Ties and props": result.ties, "Pressure of fill": pressures}
    kept = {_counted(name, frame): frame.head(_ROWS) for name, frame in frames.items() if len(frame)}
    for name, frame in kept.items():
        if "yields" in frame:
            told = frame.assign(yields=frame["yields"].map({True: "yes", False: "no"}))
            kept[name] = told.drop(columns="lengthens").dropna(axis=1, how="all")
    return {name: frame_table(frame) for name, frame in kept.items()}


def _joints(result: Result) -> pd.DataFrame:
    """Forces on joints, and how these move, the most used first where not all are printed."""
    frame = result.joints.copy()
    if "m" in frame:
        pressed = frame["n"] > IDLE * frame["n"].abs().max()
        frame["e"] = (frame["m"] / frame["n"]).where(pressed)
    frame = frame[[name for name in _JOINTS if name in frame and frame[name].notna().any()]]
    numbers = frame.select_dtypes("number")
    frame = frame.assign(**numbers.mask(numbers.abs() <= IDLE * numbers.abs().max(), 0.0))
    if result.solution.d is not None:
        motion = joint_motion(result.assembly, result.solution)
        does = zip(*(getattr(motion, word) for word in _DOES), strict=True)
        frame["moves"] = [", ".join(compress(_DOES, which)) for which in does]
    if len(frame) > _ROWS and "utilisation" in frame:
        frame = frame.sort_values("utilisation", ascending=False, kind="stable")
    return frame
