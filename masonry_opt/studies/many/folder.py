"""A sample in a folder: its tables, and a chart of each."""

from __future__ import annotations

import contextlib
from pathlib import Path

from masonry_opt.errors import OptionError
from masonry_opt.studies.many.sample_answer import Sample
from masonry_opt.studies.many.table import write_table
from masonry_opt.studies.writing import csv_text, write_files


def write_sample(sample: Sample, folder: Path, parquet: bool = False) -> None:
    """Write the runs, what they say, and charts (with the extra ``studies``), each file whole or not at all.

    Raises OutputError if a file cannot be written.
    """
    write_table(sample.table, folder, parquet)
    tables = {
        "quantiles": sample.quantiles(),
        "fragility": sample.fragility(),
        "sensitivity": sample.sensitivity(),
    }
    texts = {f"{name}.csv": csv_text(frame) for name, frame in tables.items()}
    write_files(folder, texts)
    with contextlib.suppress(OptionError):  # the tables need no extra
        from masonry_opt.studies.drawing import write_charts
        from masonry_opt.studies.many.sample_charts import KINDS

        write_charts("Sample", [draw(sample) for draw in KINDS.values()], folder)
