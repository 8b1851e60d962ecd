"""Reproduced examples as text for a terminal."""

from __future__ import annotations

from masonry_opt.report.terminal import frame_text
from masonry_opt.studies.paper.example import DIFFERENCE_NOTE, Report

#: Tables with more rows are only written to the folder.
_MOST_ROWS = 60


def report_text(title: str, report: Report) -> str:
    """An example's published values, tables, remarks, and what does not come out."""
    parts = [f"{title}\n{'=' * len(title)}"]
    if report.published_values:
        parts.append(
            frame_text(
                report.published_table, f"published and other known values beside ours ({DIFFERENCE_NOTE})"
            )
        )
    for stem, frame in report.tables.items():
        caption = report.captions.get(stem, stem)
        long = len(frame) > _MOST_ROWS
        parts.append(f"{caption}: {len(frame)} rows in {stem}.csv" if long else frame_text(frame, caption))
    parts += report.remarks
    if report.all_differences:
        parts.append("differences:\n  " + "\n  ".join(report.all_differences))
    if report.missed:
        parts.append("outside the tolerance:\n  " + "\n  ".join(report.missed))
    elif any(value.tolerance is not None for value in report.published_values):
        parts.append("every value is within its tolerance")
    return "\n".join(parts)
