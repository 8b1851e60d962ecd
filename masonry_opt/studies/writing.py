"""What answers of studies have in common: they are printed as facts, and written as JSON, as tables, and as
HTML pages from the templates of this folder."""

import json
import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from contextlib import suppress
from html import escape
from pathlib import Path
from typing import Any

import pandas as pd

from masonry_opt.answer.frames import unsigned
from masonry_opt.errors import OptionError, OutputError, printable
from masonry_opt.files import WRITER, write_whole
from masonry_opt.words.names import labelled, some

#: Message where a library for charts or pages is missing.
NEEDED = "charts and pages need Altair, vl-convert and Jinja2; install them with: pip install '.[studies]'"

_SHOWN = 30  #: Rows of a table that a notebook shows.


class StudyAnswer(ABC):
    """The answer of a study."""

    def facts(self) -> dict[str, str]:
        """What it found, in words by name."""
        return {}

    @abstractmethod
    def as_dict(self) -> dict[str, Any]:
        """Everything as plain numbers, strings, lists and dictionaries (not finite: None)."""

    @property
    @abstractmethod
    def told(self) -> pd.DataFrame:
        """The table that a notebook shows."""

    def plot(self) -> Any:
        """Draw it. Raises OptionError if there is nothing to draw."""
        raise OptionError("there is nothing to draw")

    def __str__(self) -> str:
        return self._said()

    def _said(self) -> str:
        """What stands above its tables."""
        return printable(labelled(self.facts()))

    def _repr_html_(self) -> str:
        """What a notebook shows: facts, a table, a picture."""
        source = ""
        with suppress(OptionError):  # nothing to draw, or a library for charts is missing
            source = self._source()
        return notebook_html(self._said(), self.told, source)

    def _source(self) -> str:
        """Its picture, as the address of an image."""
        return str(self.plot().source())

    def to_json(self) -> str:
        """``as_dict`` as one JSON object."""
        return json.dumps(self.as_dict(), allow_nan=False, ensure_ascii=False)


def records(frame: pd.DataFrame) -> list[dict[Any, Any]]:
    """Rows of a frame as JSON has them: None for what is missing or not finite."""
    known = frame.replace([math.inf, -math.inf], math.nan).astype(object)
    return known.where(known.notna(), None).to_dict("records")


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
    frame: pd.DataFrame, formats: Mapping[str, str] | None = None, columns: Iterable[str] | None = None
) -> pd.DataFrame:
    """Some of a frame's columns, or all, as text; a dash for a missing value. Numbers are whole, or in six
    digits, or as ``formats`` says of their columns."""
    formats, shown = formats or {}, map(str, frame) if columns is None else columns

    def text(name: str, value: Any) -> str:
        if isinstance(value, list):
            value = some(value)
        elif pd.isna(value):
            return "–"
        digits = "{}"
        if isinstance(value, float):
            value, digits = value + 0.0, "{:.0f}" if value.is_integer() else "{:.6g}"
        return printable(formats.get(name, digits).format(value))

    return pd.DataFrame({name: [text(name, value) for value in frame[name]] for name in shown}, dtype=object)


def table(
    columns: Iterable[str], rows: Iterable[Iterable[str]], numbers: Iterable[str] = ()
) -> dict[str, Any]:
    """A table of a page; ``numbers``: columns that are aligned to the right."""
    return {"columns": [*columns], "rows": [[*row] for row in rows], "numbers": [*numbers]}


def frame_table(
    frame: pd.DataFrame,
    formats: Mapping[str, str] | None = None,
    columns: Iterable[str] | None = None,
    **headings: str,
) -> dict[str, Any]:
    """Some of a frame's columns, or all, as a table of a page (see :func:`in_words`), by their names (λ by
    that letter) or by the headings given."""
    words, headings = in_words(frame, formats, columns), {"load_factor": "λ"} | headings
    numbers = frame.select_dtypes("number").rename(columns=headings)
    return table(map(str, words.rename(columns=headings)), words.to_numpy(), map(str, numbers))


def notebook_html(words: str, frame: pd.DataFrame, source: str = "") -> str:
    """What a notebook shows of a study: words, a table, and a picture by the address of an image."""
    rows = in_words(frame.head(_SHOWN)).to_html(index=False, border=0) if len(frame) else ""
    more = f"<div>and {len(frame) - _SHOWN} more rows</div>\n" if len(frame) > _SHOWN else ""
    drawn = f'<img alt="" style="max-width:100%" src="{source}">' if source else ""
    return f'<pre style="white-space:pre-wrap">{escape(words, quote=False)}</pre>\n{rows}\n{more}{drawn}'


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
