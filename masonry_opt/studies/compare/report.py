"""The report of a comparison: results.csv, summary.csv, pictures, report.html; text for a terminal."""

from __future__ import annotations

import contextlib
from pathlib import Path

from masonry_opt.answer.thresholds import APART
from masonry_opt.errors import OptionError, counted, printable
from masonry_opt.studies.compare import frames
from masonry_opt.studies.compare.answer import REPEATED_BELOW, Comparison
from masonry_opt.studies.compare.judge import ASSOCIATIVE, COULOMB, TARGET
from masonry_opt.studies.writing import csv_text, write_files


def write_report(comparison: Comparison, folder: Path) -> list[Path]:
    """Write results.csv, summary.csv and, where the extra "studies" is installed, charts (PNG and SVG) and
    report.html; returns their paths.

    Raises OutputError if the folder cannot be written.
    """
    files: dict[str, str | bytes] = {
        "results.csv": csv_text(comparison.results),
        "summary.csv": csv_text(comparison.summary),
    }
    with contextlib.suppress(OptionError):  # the tables need no extra
        from masonry_opt.studies.charts import pictures
        from masonry_opt.studies.compare.charts import charts
        from masonry_opt.studies.compare.page import page

        drawn = charts(comparison.summary)
        files |= pictures(drawn) | {"report.html": page(comparison, drawn)}
    return write_files(folder, files)


def summary_text(comparison: Comparison) -> str:
    """Text for a terminal: the success table, scenes whose Coulomb load factors differ, combinations left
    out, notes."""
    lines = []
    summary = comparison.summary
    if len(summary):
        named = {name: name for name in ("method", "model", "solver", "tolerance", "scenes")}
        lines.append(frames.in_words(frames.success(summary), named | frames.SUCCESS).to_string(index=False))
        lines.append(
            f"\n{counted(len(comparison.scenes), 'scene')}; success: certified or named correctly;\n"
            f"on target: certified, with an error of at most {TARGET[ASSOCIATIVE]:g} (associative), "
            f"{TARGET[COULOMB]:g} (Coulomb: gap to the best exact state);\n"
            "median time, largest error and violation (1e-10 at least): of the certified answers, each a "
            f"median of {counted(comparison.limits.repeats, 'run')} (of one where a run takes over "
            f"{REPEATED_BELOW:g} s)"
        )
    if len(apart := frames.spread(summary)):
        lines.append(f"\ncertified Coulomb λ more than {APART:.0%} apart:")
        lines.append(frames.in_words(apart, {str(name): str(name) for name in apart}).to_string(index=False))
    if comparison.plan.left_out:
        lines.append("\nnot applicable:")
        lines += [f"  {' · '.join(names)}: {reason}" for *names, reason in comparison.plan.left_out]
    if comparison.notes:
        lines += ["\nnotes:", *(f"  {note}" for note in comparison.notes)]
    return printable("\n".join(lines))
