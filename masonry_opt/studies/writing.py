"""Files and output of studies.

- Journal: finished runs, from which an interrupted study continues.
- machine, versions: the computer, the packages and the command of a study.
- StudyAnswer: base class of answers, which are printed as facts or written as JSON.
- in_words, table, render, ...: tables, and HTML pages from the templates of this folder.
"""

import hashlib
import json
import math
import os
import platform
import shlex
import sys
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from contextlib import suppress
from html import escape
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import pandas as pd
import psutil

from masonry_opt.errors import OptionError, printable, remainder
from masonry_opt.files import WRITER, write_whole, writing
from masonry_opt.reporting.names import labelled, some, unbroken_values, warning_lines
from masonry_opt.solution.frames import unsigned
from masonry_opt.studies.warning_codes import StudyCode, study_warning

#: Message of the error that is raised if a library for charts or pages is missing.
MISSING_LIBRARY_MESSAGE = (
    "charts and pages need Altair, vl-convert and Jinja2; install them with: pip install '.[studies]'"
)

JOURNAL = "journal.jsonl"  #: Name of the journal in the folder of a study.
_SHOWN_ROWS = 30  #: Largest number of table rows that a notebook shows; the number of omitted rows is stated.
#: Packages whose versions influence answers and computing times.
_PACKAGES = "masonry_opt cvxpy pyomo clarabel highspy osqp scs casadi scipy numpy"


class Journal:
    """File that records the finished runs of a study, in the folder of the study.

    The first line, the head, has a hash of each input that determines the rows. Every other line is a run,
    with a hash of its content. A line with another hash is damaged. An incomplete last line is removed when
    the file is opened. Any other damaged line remains in the file, and ``warnings`` has a record with its
    number. The runs of damaged and removed lines are made again.

    Raises OptionError if the folder has runs with another head, OutputError if it cannot be read or written.
    """

    def __init__(self, folder: Path, head: Mapping[str, str]) -> None:
        self.path = folder / JOURNAL
        #: Folders that this object creates for the journal, innermost first.
        self._folders_made = [path for path in (folder, *folder.parents) if not path.exists()]
        with writing(self.path):
            folder.mkdir(parents=True, exist_ok=True)
            data = self.path.read_bytes() if self.path.exists() else b""
            complete = data[: data.rfind(b"\n") + 1]
            if data and not complete:  # every journal has a complete first line
                raise OptionError(f"{self.path}: the file is not a journal of runs: choose another folder")
            complete = complete or _line(head)
            if complete != data:
                write_whole(self.path, complete)
        #: Length of the file before rows are added, in bytes; 0 if this object created the file.
        self._length_before = len(complete) if data else 0
        first, *lines = complete.splitlines()
        self._refuse_others(first, head)
        self._rows: dict[str, dict[str, Any]] = {}
        self.warnings: list[dict[str, Any]] = []  #: one record for each damaged line
        for number, line in enumerate(lines, start=2):
            try:
                self._keep(json.loads(line))
            except (ValueError, KeyError, TypeError):
                sentence = (
                    f"{self.path}: line {number} is damaged, so the run of this line is repeated: delete the "
                    "line to stop this warning"
                )
                where = {"path": str(self.path), "line": number}
                self.warnings.append(study_warning(StudyCode.DAMAGED_JOURNAL, sentence, **where))

    def _refuse_others(self, first: bytes, head: Mapping[str, str]) -> None:
        """Raise OptionError if the first line of a journal does not describe the runs of this study."""
        try:
            recorded = json.loads(first)
            changed = [name for name in head if recorded.get(name) != head[name]]
        except (ValueError, AttributeError):
            raise OptionError(
                f"{self.path}: the file is not a journal of runs: choose another folder"
            ) from None
        if changed:
            raise OptionError(
                f"{self.path.parent}: the runs in this folder have other {', '.join(changed)}: choose "
                f"another folder, or remove {self.path} to discard these runs"
            )

    def _keep(self, line: Mapping[str, Any]) -> None:
        """Store the run that a line of the journal describes.

        Raises KeyError, TypeError or ValueError if the line is damaged.
        """
        if line["hash"] != _hash_of_run(line["key"], line["row"]):
            raise ValueError
        self._rows[line["key"]] = line["row"]

    def find(self, key: str) -> dict[str, Any] | None:
        """Return the row of a run by its key, or None if the run is not in the journal."""
        return self._rows.get(key)

    def add(self, key: str, row: Mapping[str, Any]) -> None:
        """Append the row of a run to the file, and wait until the row is on disk."""
        note = "; the finished runs are kept: repeat the command to continue"
        with writing(self.path, note), self.path.open("ab") as stream:
            stream.write(run_line(key, row))
            stream.flush()
            os.fsync(stream.fileno())
        self._rows[key] = dict(row)

    def discard(self) -> None:
        """Remove the rows that this object added to the journal file.

        A journal that did not exist before is removed, together with the folders that were made for it.
        """
        self._rows = {}
        with suppress(OSError):  # rmdir fails if the folder contains other files; the folder then remains
            if self._length_before:
                os.truncate(self.path, self._length_before)
                return
            self.path.unlink()
            for folder in self._folders_made:
                folder.rmdir()


def digest(content: object) -> str:
    """Return a short hash of the ``repr`` of an object."""
    return hashlib.sha256(repr(content).encode()).hexdigest()[:16]


def run_line(key: str, row: Mapping[str, Any]) -> bytes:
    """Return the line of a journal that records a run, with a hash of its content."""
    return _line({"key": key, "row": row, "hash": _hash_of_run(key, row)})


def _hash_of_run(key: str, row: Mapping[str, Any]) -> str:
    """Return a hash of a run in the journal: equal before the run is written and after it is read."""
    return digest(json.dumps([key, row]))


def _line(content: Mapping[str, Any]) -> bytes:
    """Return a dictionary as one line of JSON for a journal."""
    return json.dumps(content, ensure_ascii=False).encode() + b"\n"


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that influence answers, by name."""
    versions_by_name = {"python": platform.python_version()}
    for name in _PACKAGES.split():
        try:
            versions_by_name[name] = version(name)
        except PackageNotFoundError:
            versions_by_name[name] = "not installed"
    return versions_by_name


def machine() -> dict[str, str]:
    """Return facts about this computer, such as its processor, and the command line of this process."""
    lines: list[str] = []
    with suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    named = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return {
        "processor": named[0] if named else platform.processor() or platform.machine(),
        "cores": str(os.cpu_count()),
        "memory": f"{psutil.virtual_memory().total / 1e9:.0f} GB",
        "system": f"{platform.system()} {platform.release()}",
        "threads": "one per run, on one core",
        "command": shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]]),
    }


class StudyAnswer(ABC):
    """Base class of the answers of studies: printed text, notebook output, pictures and JSON."""

    def facts(self) -> dict[str, str]:
        """Return the printed lines of the answer as a dictionary: the text of each line by its label."""
        return {}

    @abstractmethod
    def as_dict(self) -> dict[str, Any]:
        """Return the answer as plain values, with None for numbers that are not finite.

        Returns
        -------
        dict
            The data by name, as the method ``to_json`` writes them.
        """

    @property
    def warning_records(self) -> list[dict[str, Any]]:
        """Warnings as records for JSON.

        A record contains the ``sentence``, its ``code``, and the values that the sentence contains.
        A warning names an input that looks unintended, or a reason to doubt the answer.
        """
        return []

    @property
    def warning_sentences(self) -> tuple[str, ...]:
        """Warnings as sentences, without repetitions."""
        return tuple(dict.fromkeys(record["sentence"] for record in self.warning_records))

    @property
    @abstractmethod
    def notebook_table(self) -> pd.DataFrame:
        """Table that a notebook displays between the printed text and the picture of the answer."""

    def plot(self) -> Any:
        """Return a picture of the answer.

        Raises
        ------
        OptionError
            If the study has no picture.
        """
        raise OptionError("there is nothing to draw")

    def __str__(self) -> str:
        return self._text()

    def _text(self) -> str:
        """Return the printed text of the answer: labelled lines and warnings, without tables."""
        return printable("\n".join([labelled(self.facts()), *warning_lines(self.warning_sentences)]))

    def _repr_html_(self) -> str:
        """Return the HTML of the answer for a notebook: text, a table and a picture."""
        source = ""
        with suppress(OptionError):  # raised if there is no picture, or a library is missing
            source = self._source()
        return notebook_html(self._text(), self.notebook_table, source)

    def _source(self) -> str:
        """Return the picture as a data URL, for an image in an HTML page."""
        return str(self.plot().source())

    def to_json(self) -> str:
        """Return the dictionary of ``as_dict`` as one JSON object.

        Returns
        -------
        str
            One JSON object on one line.
        """
        return json.dumps(self.as_dict(), allow_nan=False, ensure_ascii=False)


def records(frame: pd.DataFrame) -> list[dict[Any, Any]]:
    """Return the rows of a DataFrame as dictionaries for JSON, with None for missing and infinite values."""
    known = frame.replace([math.inf, -math.inf], math.nan).astype(object)
    return known.where(known.notna(), None).to_dict("records")


def csv_text(frame: pd.DataFrame) -> str:
    """Return a DataFrame as the text of a CSV file."""
    return unsigned(frame).to_csv(index=False, lineterminator="\n")


def chart_files(names: Iterable[str]) -> list[str]:
    """Return the file names of charts: a PNG and an SVG file of each chart, and a page with all charts."""
    return [*(f"{name}.{kind}" for name in names for kind in ("png", "svg")), "charts.html"]


def in_words(
    frame: pd.DataFrame, formats: Mapping[str, str] | None = None, columns: Iterable[str] | None = None
) -> pd.DataFrame:
    """Convert columns of a DataFrame to text, with a dash for missing values.

    Parameters
    ----------
    frame: Table of values.
    formats: Format strings by column. In other columns, whole numbers have no decimals, and all other numbers
        have six significant digits.
    columns: Columns of the result, by default all.
    """
    formats, shown = formats or {}, map(str, frame) if columns is None else columns

    def text(name: str, value: Any) -> str:
        if isinstance(value, list):
            value = some(value)
        elif pd.isna(value):
            return "–"
        default = "{}"
        if isinstance(value, float):
            value += 0.0  # a negative zero becomes zero
            default = "{:.0f}" if value.is_integer() else "{:.6g}"
        return printable(formats.get(name, default).format(value))

    return pd.DataFrame({name: [text(name, value) for value in frame[name]] for name in shown}, dtype=object)


def table(
    columns: Iterable[str], rows: Iterable[Iterable[str]], numbers: Iterable[str] = ()
) -> dict[str, Any]:
    """Return a dictionary with the headings and rows of a table, for the templates of pages.

    The columns in ``numbers`` are right-aligned.
    """
    return {"columns": [*columns], "rows": [[*row] for row in rows], "numbers": [*numbers]}


def frame_table(
    frame: pd.DataFrame,
    formats: Mapping[str, str] | None = None,
    columns: Iterable[str] | None = None,
    **headings: str,
) -> dict[str, Any]:
    """Convert columns of a DataFrame to a table for the template of a page.

    Keyword arguments set the headings of columns. By default the headings are the names of the columns, and
    λ for "load_factor".
    """
    words, headings = in_words(frame, formats, columns), {"load_factor": "λ"} | headings
    numbers = frame.select_dtypes("number").rename(columns=headings)
    return table(map(str, words.rename(columns=headings)), words.to_numpy(), map(str, numbers))


def notebook_html(words: str, frame: pd.DataFrame, source: str = "") -> str:
    """Return HTML for a notebook: a text, the first rows of a table, and the picture at a URL."""
    rows = in_words(frame.head(_SHOWN_ROWS)).to_html(index=False, border=0) if len(frame) else ""
    more_rows = remainder(len(frame), _SHOWN_ROWS, "row")
    below = f"<div>{more_rows}</div>\n" if more_rows else ""
    drawn = f'<img alt="" style="max-width:100%" src="{source}">' if source else ""
    return f'<pre style="white-space:pre-wrap">{escape(words, quote=False)}</pre>\n{rows}\n{below}{drawn}'


def render(template: str, **values: object) -> str:
    """Fill a template in ``templates/`` with the values of its variables, and return the page.

    Raises OptionError if Jinja2, of the extra "studies", is not installed.
    """
    try:
        import jinja2
    except ImportError:
        raise OptionError(MISSING_LIBRARY_MESSAGE) from None
    loader, strict = jinja2.PackageLoader("masonry_opt.studies"), jinja2.StrictUndefined
    trimmed: dict[str, Any] = {"trim_blocks": True, "lstrip_blocks": True}
    environment = jinja2.Environment(loader=loader, autoescape=True, undefined=strict, **trimmed)
    return unbroken_values(environment.get_template(template).render(writer=WRITER, **values))
