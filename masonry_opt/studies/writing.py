"""The files of a study: tables, and HTML pages from the templates of this folder."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from masonry_opt.answer.frames import unsigned
from masonry_opt.errors import OptionError, OutputError
from masonry_opt.files import WRITER, write_whole

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
