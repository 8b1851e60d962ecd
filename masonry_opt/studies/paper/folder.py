"""The folder that ``reproduce`` fills: tables, pictures, and a page that shows what is there."""

from __future__ import annotations

import html
import io
import json
import os
import platform
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import matplotlib as mpl

from masonry_opt.errors import OutputError
from masonry_opt.files import write_whole
from masonry_opt.report.terminal import format_cell
from masonry_opt.studies.paper.example import Report
from masonry_opt.studies.paper.registry import EXAMPLES

#: Packages whose versions decide what comes out.
_PACKAGES = ("masonry_opt", "clarabel", "cvxpy", "highspy", "pyomo", "numpy", "scipy")

#: Of the records that the index page is made from.
_FORMAT = "masonry_opt reproduced example, 1"

#: Tables with more rows are folded away.
_LONG = 20

_STYLE = """
body { font: 16px/1.45 sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
table { border-collapse: collapse; margin: .8rem 0; font-size: .86rem; display: block; overflow-x: auto; }
th, td { padding: .2rem .6rem; border-bottom: 1px solid #ddd; text-align: left; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
img { max-width: 100%; height: auto; margin: .8rem 0 0; }
figcaption, .note { color: #555; font-size: .9rem; }
figure { margin: 0 0 1rem; }
.missed { color: #A23B00; font-weight: bold; }
"""


def open_folder(folder: Path) -> None:
    """Make the folder. Raises OutputError if it cannot be made or written to."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
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
            write_whole(written[-1], frame.to_csv(index=False))
        for stem, figure in report.figures.items():
            for kind in ("png", "svg"):
                image = io.BytesIO()
                with mpl.rc_context({"svg.hashsalt": "masonry_opt"}):
                    figure.savefig(image, format=kind, dpi=150, bbox_inches="tight")
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
        "comparisons": [[*_cells(entry.as_row()), entry.missed] for entry in report.comparisons],
        "columns": list(report.comparisons[0].as_row()) if report.comparisons else [],
        "tables": {
            stem: {"columns": [*map(str, frame.columns)], "rows": [*map(_cells, frame.to_dict("records"))]}
            for stem, frame in report.tables.items()
        },
        "figures": list(report.figures),
        "captions": report.captions,
        "remarks": report.remarks,
        "differences": report.all_differences,
        "machine": _machine(),
    }


def _cells(row: dict[Any, Any]) -> list[str]:
    return [format_cell(str(column), value) for column, value in row.items()]


def _machine() -> str:
    packages = ", ".join(f"{package} {version(package)}" for package in _PACKAGES)
    return f"Python {platform.python_version()}, {platform.machine()}, {os.cpu_count()} cores; {packages}"


def _page(folder: Path) -> str:
    records = {name: record for name in EXAMPLES if (record := _read(folder / f"{name}.json"))}
    contents = "".join(
        f'<tr><td><a href="#{name}">{name}</a></td><td>{html.escape(EXAMPLES[name].title)}</td>'
        f'<td class="number">{len(record["comparisons"])}</td>'
        f'<td class="number">{sum(row[-1] for row in record["comparisons"])}</td>'
        f'<td class="number">{record["seconds"]:.1f}</td></tr>'
        for name, record in records.items()
    )
    differences = _list(
        f"<b>{name}</b>: {html.escape(line)}"
        for name, record in records.items()
        for line in record["differences"]
    )
    machines = _list(map(html.escape, dict.fromkeys(record["machine"] for record in records.values())))
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width">'
        f"<title>masonry_opt: reproduced results</title><style>{_STYLE}</style></head><body>\n"
        "<h1>Limit analysis of masonry block structures with non-associative frictional joints</h1>\n"
        "<p>Results of Gilbert, Casapulla &amp; Ahmed (2006), Computers and Structures 84, 873–887, "
        "rebuilt from case files. λ is the load factor, μ = tan φ the friction.</p>\n"
        "<table><tr><th>example</th><th></th><th>published values</th><th>missed</th><th>time (s)</th></tr>"
        f"{contents}</table>\n"
        f"<h2>Differences</h2>\n{differences or '<p>None.</p>'}\n"
        f"{''.join(_section(name, record) for name, record in records.items())}"
        f"<h2>Machine and versions</h2>\n{machines}</body></html>\n"
    )


def _read(path: Path) -> dict[str, Any] | None:
    """An example's record; None if there is none, or one of another version of this program."""
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
        return record if record["format"] == _FORMAT else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _section(name: str, record: dict[str, Any]) -> str:
    parts = [
        f'<h2 id="{name}">{html.escape(EXAMPLES[name].title)}</h2>\n',
        _list(_escaped(record["remarks"])),
    ]
    if record["comparisons"]:
        parts.append(_table([*record["columns"], ""], map(_with_verdict, record["comparisons"])))
    captions = {stem: html.escape(text) for stem, text in record["captions"].items()}
    for stem in _escaped(record["figures"]):
        caption = captions.get(stem, "")
        parts.append(
            f'<figure><img src="{stem}.png" alt="{caption}"><figcaption>{caption} '
            f'(<a href="{stem}.svg">SVG</a>)</figcaption></figure>\n'
        )
    for stem, table in zip(_escaped(record["tables"]), record["tables"].values(), strict=True):
        shown = _table(table["columns"], table["rows"])
        if len(table["rows"]) > _LONG:
            shown = f"<details><summary>{len(table['rows'])} rows</summary>{shown}</details>\n"
        parts.append(f'<p>{captions.get(stem, stem)} (<a href="{stem}.csv">CSV</a>)</p>\n{shown}')
    return "".join(parts)


def _with_verdict(row: list[Any]) -> list[str]:
    return [*row[:-1], "outside tolerance" if row[-1] else ""]


def _escaped(lines: Iterable[str]) -> Iterable[str]:
    return map(html.escape, lines)


def _list(items: Iterable[str]) -> str:
    lines = "".join(f"<li>{item}</li>" for item in items)
    return f"<ul>{lines}</ul>\n" if lines else ""


def _table(columns: list[str], rows: Iterable[list[str]]) -> str:
    head = "".join(f"<th>{html.escape(column)}</th>" for column in columns)
    body = "".join(f"<tr>{''.join(map(_data, row))}</tr>" for row in rows)
    return f"<table><tr>{head}</tr>{body}</table>\n"


def _data(cell: str) -> str:
    kind = ' class="number"' if cell[:1] in "0123456789+-–" else ""
    kind = ' class="missed"' if cell == "outside tolerance" else kind
    return f"<td{kind}>{html.escape(cell)}</td>"
