"""The files of a study."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from masonry_opt.answer.frames import unsigned
from masonry_opt.errors import OutputError
from masonry_opt.files import write_whole


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
