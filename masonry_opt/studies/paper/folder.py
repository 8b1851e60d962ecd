"""The folder that ``reproduce`` fills: tables, pictures, and a page that shows what is there."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Collection
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pandas as pd

from masonry_opt.errors import OutputError
from masonry_opt.files import picture_metadata, write_whole
from masonry_opt.report.terminal import format_cell
from masonry_opt.studies.machine import machine, versions
from masonry_opt.studies.page import render
from masonry_opt.studies.paper.example import DIFFERENCE_NOTE, Report
from masonry_opt.studies.paper.registry import EXAMPLES
from masonry_opt.studies.writing import csv_text

#: Of the records that the index page is made from.
_FORMAT = "masonry_opt reproduced example, 3"


def open_folder(folder: Path) -> None:
    """Make the folder, before the minutes that filling it takes.

    Raises
    ------
    OutputError
        If it cannot be made or written to.
    OptionError
        If the index page cannot be made, for want of Jinja2.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _page(folder)
        write_whole(folder / ".masonry_opt", "")
        (folder / ".masonry_opt").unlink()
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror}") from None


def write_report(folder: Path, name: str, report: Report, seconds: float) -> list[Path]:
    """Write an example's tables (CSV) and figures (PNG, SVG), then the index page anew.

    Each file is written whole; what other examples left in the folder stays and stays listed.

    Raises
    ------
    OutputError
        If the folder cannot be written.
    """
    try:
        written = []
        for stem, frame in report.tables.items():
            written.append(folder / f"{stem}.csv")
            write_whole(written[-1], csv_text(frame))
        for stem, figure in report.figures.items():
            for kind in ("png", "svg"):
                image = io.BytesIO()
                with mpl.rc_context({"svg.hashsalt": "masonry_opt"}):
                    figure.savefig(
                        image, format=kind, dpi=150, bbox_inches="tight", metadata=picture_metadata(kind)
                    )
                written.append(folder / f"{stem}.{kind}")
                write_whole(written[-1], image.getvalue())
        record = json.dumps(_record(report, seconds), ensure_ascii=False, indent=1)
        written.append(folder / f"{name}.json")
        write_whole(written[-1], record + "\n")
        written.append(folder / "index.html")
        write_whole(written[-1], _page(folder))
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror}") from None
    return written


def _record(report: Report, seconds: float) -> dict[str, Any]:
    return {
        "format": _FORMAT,
        "seconds": round(seconds, 2),
        "published": _table(report.published_table, texts=("what", "source")),
        "missed": [row for row, value in enumerate(report.published_values) if value.missed],
        "tables": {stem: _table(frame) for stem, frame in report.tables.items()},
        "figures": list(report.figures),
        "captions": report.captions,
        "remarks": report.remarks,
        "differences": report.all_differences,
        "machine": ", ".join(f"{name} {value}" for name, value in {**machine(), **versions()}.items()),
    }


def _table(frame: pd.DataFrame, texts: Collection[str] | None = None) -> dict[str, Any]:
    """The columns, and whether they hold numbers, and the rows as shown.

    ``texts``: the columns that hold none; where they are not named the cells tell.
    """
    names = [*map(str, frame.columns)]
    records = frame.to_dict("records")
    rows = [
        [format_cell(name, cell) for name, cell in zip(names, record.values(), strict=True)]
        for record in records
    ]
    columns = [
        {
            "name": name,
            "number": all(_is_number(row[at]) for row in rows) if texts is None else name not in texts,
        }
        for at, name in enumerate(names)
    ]
    return {"columns": columns, "rows": rows}


def _is_number(cell: str) -> bool:
    """Whether a cell holds a number, an interval of numbers, or a dash for none."""
    return all(re.fullmatch(r"–|[+-]?\d[\d.]*(e[+-]\d+)?", end) for end in cell.split(" to "))


def _page(folder: Path) -> str:
    """The index page of the examples whose records lie in the folder."""
    records = {name: record for name in EXAMPLES if (record := _read(folder / f"{name}.json"))}
    return render(
        "reproduced.html",
        title="Reproduced results",
        note=DIFFERENCE_NOTE,
        examples=[
            {"name": name, "title": EXAMPLES[name].title, **record} for name, record in records.items()
        ],
        machines=[*dict.fromkeys(record["machine"] for record in records.values())],
    )


def _read(path: Path) -> dict[str, Any] | None:
    """An example's record; None if there is none, or one of another version of this program."""
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
        return record if record["format"] == _FORMAT else None
    except (OSError, ValueError, KeyError, TypeError):
        return None
