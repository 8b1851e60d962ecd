"""Read the CSV files in which benchmarks store one row per scene, to continue an interrupted run."""

import csv
from collections.abc import Sequence
from pathlib import Path


def read_rows(path: Path) -> list[dict[str, str]]:
    """Return the rows of a CSV file, or an empty list if the file does not exist."""
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def rows_to_continue(path: Path, columns: Sequence[str]) -> list[dict[str, str]]:
    """Return the rows of a CSV file to which rows with the given columns will be appended.

    The script ends with a message if the header of the file differs, as in files of earlier versions.
    """
    if path.exists():
        with path.open(newline="") as file:
            header = next(csv.reader(file), None)
        if header is not None and header != list(columns):
            raise SystemExit(
                f"{path} cannot be continued, because its columns are {', '.join(header)} instead of "
                f"{', '.join(columns)}: choose another file with --out"
            )
    return read_rows(path)
