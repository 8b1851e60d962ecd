"""What a comparison leaves: a table on the terminal, summary.csv, pictures, and report.html."""

from __future__ import annotations

import contextlib
from pathlib import Path

import pandas as pd

from masonry_opt.answer.thresholds import APART
from masonry_opt.errors import OptionError, OutputError, counted, printable
from masonry_opt.files import write_whole
from masonry_opt.studies.compare import frames
from masonry_opt.studies.compare.comparison import REPEATED_BELOW, Comparison
from masonry_opt.studies.compare.judge import TARGET
from masonry_opt.studies.compare.known_answers import ASSOCIATIVE, COULOMB
from masonry_opt.studies.compare.text import number
from masonry_opt.studies.writing import csv_text


def write_report(comparison: Comparison, folder: Path) -> list[Path]:
    """Write summary.csv and, where the extra "studies" is installed, charts (PNG and SVG) and report.html;
    returns the paths of all that the folder then holds.

    Raises OutputError if the folder cannot be written.
    """
    files: dict[str, str | bytes] = {"summary.csv": csv_text(comparison.summary)}
    with contextlib.suppress(OptionError):  # the table needs no extra
        from masonry_opt.studies.compare.charts import charts
        from masonry_opt.studies.compare.page import page
        from masonry_opt.studies.drawing import pictures

        drawn = charts(comparison.summary)
        files |= pictures(drawn) | {"report.html": page(comparison, drawn)}
    try:
        for name, content in files.items():
            write_whole(folder / name, content)
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror}") from None
    return [folder / "results.csv", *(folder / name for name in files)]


def summary_text(comparison: Comparison) -> str:
    """The success table, where Coulomb load factors end apart, what is not applicable, and the notes, for a
    terminal."""
    lines = []
    if not comparison.summary.empty:
        table = frames.success(comparison.summary).drop(columns=["pair"])
        for name in ("tolerance", "largest error", "largest violation"):
            table[name] = table[name].map(lambda value: "–" if pd.isna(value) else f"{value:.0e}")
        table = table.drop(columns=["time 25 %", "time 75 %"])
        for name in ("success", "on target"):
            table[name] = table[name].map("{:.0%}".format)
        table["time"] = table["time"].map(lambda value: "–" if pd.isna(value) else f"{value:.3g}")
        table["peak_memory"] = table["peak_memory"].map("{:.0f}".format)
        table = table.rename(columns={"time": "median time (s)", "peak_memory": "peak (MB)"})
        lines.append(table.to_string(index=False))
        lines.append(
            f"\n{counted(len(comparison.scenes), 'scene')}; success: certified or named correctly;\n"
            f"on target: certified, with an error of at most {TARGET[ASSOCIATIVE]:g} (associative), "
            f"{TARGET[COULOMB]:g} (Coulomb: gap to the best exact state);\n"
            "median time, largest error and violation (1e-10 at least): of the certified answers, each a "
            f"median of {counted(comparison.limits.repeats, 'run')} (of one where a run takes over "
            f"{REPEATED_BELOW:g} s)"
        )
    lines += _spread_lines(comparison)
    if comparison.plan.left_out:
        lines.append("\nnot applicable:")
        lines += [f"  {i.method} · {i.model} · {i.solver}: {i.reason}" for i in comparison.plan.left_out]
    if comparison.notes:
        lines += ["\nnotes:", *(f"  {note}" for note in comparison.notes)]
    return printable("\n".join(lines))


def _spread_lines(comparison: Comparison) -> list[str]:
    """The scenes whose certified Coulomb load factors end apart, widest first; no lines without any."""
    apart = frames.spread(comparison.summary)
    if apart.empty:
        return []
    for name in ("lowest", "highest"):
        apart[name] = apart[name].map(number)
    apart["spread"] = apart["spread"].map("{:.1%}".format)
    return [f"\ncertified Coulomb λ more than {APART:.0%} apart:", apart.to_string(index=False)]
