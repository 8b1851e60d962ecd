"""What studies keep and write: a journal of finished runs, from which they continue; the machine, the
versions and the command that made them; and answers, printed as facts, and written as JSON, as tables, and as
HTML pages from the templates of this folder."""

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

from masonry_opt.answer.frames import unsigned
from masonry_opt.errors import OptionError, printable
from masonry_opt.files import WRITER, write_whole, writing
from masonry_opt.studies.warning_codes import StudyCode, study_warning
from masonry_opt.words.names import labelled, some, warning_lines

#: Message where a library for charts or pages is missing.
NEEDED = "charts and pages need Altair, vl-convert and Jinja2; install them with: pip install '.[studies]'"

JOURNAL = "journal.jsonl"
_SHOWN = 30  #: Rows of a table that a notebook shows.
#: Packages whose versions decide times and answers.
_PACKAGES = "masonry_opt cvxpy pyomo clarabel highspy osqp scs casadi scipy numpy"


class Journal:
    """The finished runs of one study in a folder, one line a run after a first line, the head.

    The head has hashes of all that decides the rows, by name. An incomplete last line is removed when the
    file is opened. A damaged line before it stays in the file, and ``warnings`` names its number. The runs of
    both are missing, and so are made again.

    Raises OptionError if the folder holds runs of another head, OutputError if it cannot be read or written.
    """

    def __init__(self, folder: Path, head: Mapping[str, str]) -> None:
        self.path = folder / JOURNAL
        #: Folders that are made for the journal, the innermost first.
        self._folders_made = [path for path in (folder, *folder.parents) if not path.exists()]
        with writing(self.path):
            folder.mkdir(parents=True, exist_ok=True)
            data = self.path.read_bytes() if self.path.exists() else b""
            whole = data[: data.rfind(b"\n") + 1]
            if data and not whole:  # a journal is begun with a whole line
                raise OptionError(f"{self.path}: is no journal of runs: choose another folder")
            whole = whole or _line(head)
            if whole != data:
                write_whole(self.path, whole)
        self._length_before = len(whole) if data else 0  #: in bytes; 0 if the journal is begun here
        first, *lines = whole.splitlines()
        self._refuse_others(first, head)
        self._rows: dict[str, dict[str, Any]] = {}
        self.warnings: list[dict[str, Any]] = []  #: one record a damaged line
        for number, line in enumerate(lines, start=2):
            try:
                self._keep(json.loads(line))
            except (ValueError, KeyError, TypeError):
                remedy = "its run is repeated; delete the line to stop this warning"
                sentence = f"{self.path}: line {number} is damaged: {remedy}"
                where = {"path": str(self.path), "line": number}
                self.warnings.append(study_warning(StudyCode.DAMAGED_JOURNAL, sentence, **where))

    def _refuse_others(self, first: bytes, head: Mapping[str, str]) -> None:
        """Raise OptionError if the first line is no head, or that of other runs."""
        try:
            found = json.loads(first)
            changed = [what for what in head if found.get(what) != head[what]]
        except (ValueError, AttributeError):
            raise OptionError(f"{self.path}: is no journal of runs: choose another folder") from None
        if changed:
            others, anew = f"runs with other {', '.join(changed)}", f"remove {self.path} to begin anew"
            raise OptionError(f"{self.path.parent}: holds {others}: choose another folder, or {anew}")

    def _keep(self, line: Mapping[str, Any]) -> None:
        """Keep the run of a line. Raises KeyError or TypeError if the line is damaged."""
        self._rows[str(line["key"])] = {**line["row"]}

    def find(self, key: str) -> dict[str, Any] | None:
        return self._rows.get(key)

    def add(self, key: str, row: Mapping[str, Any]) -> None:
        """Keep a row; it is on disk when this returns."""
        kept = "; the runs before are kept, and the same command goes on from there"
        with writing(self.path, kept), self.path.open("ab") as stream:
            stream.write(_line({"key": key, "row": row}))
            stream.flush()
            os.fsync(stream.fileno())
        self._rows[key] = dict(row)

    def discard(self) -> None:
        """Remove the rows that were added here.

        A journal that was begun here is removed, with the folders that were made for it.
        """
        self._rows = {}
        with suppress(OSError):  # a folder that another program has used since stays
            if self._length_before:
                os.truncate(self.path, self._length_before)
                return
            self.path.unlink()
            for folder in self._folders_made:
                folder.rmdir()


def digest(content: object) -> str:
    """Short hash of what decides a row."""
    return hashlib.sha256(repr(content).encode()).hexdigest()[:16]


def _line(content: Mapping[str, Any]) -> bytes:
    return json.dumps(content, ensure_ascii=False).encode() + b"\n"


def versions() -> dict[str, str]:
    """Python's and the packages' versions; "not installed" where there is none."""
    found = {"python": platform.python_version()}
    for name in _PACKAGES.split():
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


class StudyAnswer(ABC):
    """The answer of a study."""

    def facts(self) -> dict[str, str]:
        """What it found, in words by name."""
        return {}

    @abstractmethod
    def as_dict(self) -> dict[str, Any]:
        """Everything as plain numbers, strings, lists and dictionaries (not finite: None)."""

    @property
    def warning_records(self) -> list[dict[str, Any]]:
        """Warnings as JSON output has them: ``sentence``, ``code`` and the values of the code.

        They name what looks unintended in the scene, or makes the answer doubtful.
        """
        return []

    @property
    def warning_sentences(self) -> tuple[str, ...]:
        """Warnings in words, each once."""
        return tuple(dict.fromkeys(record["sentence"] for record in self.warning_records))

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
        """Return the lines above its tables: facts, then warnings."""
        return printable("\n".join([labelled(self.facts()), *warning_lines(self.warning_sentences)]))

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


def chart_files(names: Iterable[str]) -> list[str]:
    """Return the names of the files of some charts: PNG and SVG of each, and the page of all."""
    return [*(f"{name}.{kind}" for name in names for kind in ("png", "svg")), "charts.html"]


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
    """A page from a template in ``templates/`` and the values it names, which are escaped. Raises OptionError
    if Jinja2, of the extra "studies", is not installed."""
    try:
        import jinja2
    except ImportError:
        raise OptionError(NEEDED) from None
    loader, strict = jinja2.PackageLoader("masonry_opt.studies"), jinja2.StrictUndefined
    trimmed: dict[str, Any] = {"trim_blocks": True, "lstrip_blocks": True}
    environment = jinja2.Environment(loader=loader, autoescape=True, undefined=strict, **trimmed)
    return environment.get_template(template).render(writer=WRITER, **values)
