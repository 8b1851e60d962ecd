"""The files of a study: tables, and HTML pages from the templates of this folder."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from masonry_opt.answer.frames import unsigned
from masonry_opt.errors import OptionError, OutputError, printable
from masonry_opt.files import WRITER, write_whole
from masonry_opt.words.names import some

#: Message where a library for charts or pages is missing.
NEEDED = "charts and pages need Altair, vl-convert and Jinja2; install them with: pip install '.[studies]'"


def csv_text(frame: pd.DataFrame) -> str:
    """A frame as a CSV file's text."""
    return unsigned(frame).to_csv(index=False, lineterminator="\n")


def write_files(folder: Path, contents: Mapping[str, str | bytes]) -> list[Path]:
    """Write contents by their files' names, each whole or not at all; returns the files.

    Raises OutputError with the name of the first that cannot be written; those before stay.
    """
    for name, content in contents.items():
        try:
            write_whole(folder / name, content)
        except OSError as error:
            raise OutputError(f"{folder / name}: cannot be written: {error.strerror}") from None
    return [folder / name for name in contents]


def in_words(
    frame: pd.DataFrame, formats: Mapping[str, str], columns: Mapping[str, str] | None = None
) -> pd.DataFrame:
    """Some of a frame's columns under their headings, or all as they are, as text; a dash for a missing
    value. ``formats``: of numbers, by column."""

    def text(name: str, value: Any) -> str:
        if isinstance(value, list):
            value = some(value)
        elif pd.isna(value):
            return "–"
        known = value + 0.0 if isinstance(value, float) else value
        return printable(formats.get(name, "{}").format(known))

    shown = columns or {str(name): str(name) for name in frame}
    return pd.DataFrame(
        {heading: [text(name, value) for value in frame[name]] for name, heading in shown.items()},
        dtype=object,
    )


def table(
    columns: Iterable[str], rows: Iterable[Iterable[str]], numbers: Iterable[str] = ()
) -> dict[str, Any]:
    """A table of a page; ``numbers``: columns that are aligned to the right."""
    return {"columns": [*columns], "rows": [[*row] for row in rows], "numbers": [*numbers]}


def frame_table(
    frame: pd.DataFrame, formats: Mapping[str, str], columns: Mapping[str, str]
) -> dict[str, Any]:
    """Some of a frame's columns as a table of a page (see :func:`in_words`)."""
    words = in_words(frame, formats, columns)
    numbers = [heading for name, heading in columns.items() if name in formats]
    return table(map(str, words), words.to_numpy(), numbers)


def study_page(
    title: str,
    facts: Mapping[str, str],
    pictures: Mapping[str, bytes],
    parts: Mapping[str, str],
    tables: Mapping[str, dict[str, Any]],
) -> str:
    """What a study found, its pictures (SVG) by what they show, and parts (HTML) and tables by headings, as
    HTML that stands by itself.

    Raises OptionError if Jinja2, of the extra "studies", is not installed.
    """
    drawn = {shows: b64encode(picture).decode() for shows, picture in pictures.items()}
    return render("study.html", title=title, facts=facts, pictures=drawn, parts=parts, tables=tables)


def render(template: str, **values: object) -> str:
    """A page from a template in ``templates/`` and the values it names, which are escaped.

    Raises OptionError if Jinja2, of the extra "studies", is not installed.
    """
    try:
        import jinja2
    except ImportError:
        raise OptionError(NEEDED) from None
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("masonry_opt.studies"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(writer=WRITER, **values)
