"""Read and continue the CSV files in which benchmarks store their rows, after an interrupted run too."""

import csv
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any


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


def append_rows(path: Path, columns: Sequence[str], rows: Iterable[Mapping[str, Any]]) -> None:
    """Append rows to a CSV file, each as soon as it is generated. A new file begins with the columns."""
    with path.open("a", newline="") as file:
        writer = csv.DictWriter(file, columns)
        if file.tell() == 0:
            writer.writeheader()
        for row in rows:
            writer.writerow(row)
            file.flush()
