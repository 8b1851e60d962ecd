"""Write the tables of ``docs/paper.md`` anew (``python tests/report/refresh_tables.py`` in the clone)."""

from __future__ import annotations

import re
from pathlib import Path

from masonry_opt.report.terminal import markdown
from masonry_opt.studies.paper.table1 import table1

#: Times are of one run on one machine: they are printed, not kept.
LEFT_OUT = ["method", "NLPs", "time (s)", "published (s)"]


def refresh(page: Path, cases: Path) -> None:
    """Replace what stands between the markers of each table."""
    tables, text = table1(cases, print).tables, page.read_text("utf-8")
    residuals = tables["table1_residuals"]
    loops = residuals[residuals["method"] == "loop"].drop(columns=LEFT_OUT)
    parts = {"table1": tables["table1"], "residuals": loops}
    for name, frame in parts.items():
        between = re.compile(rf"(<!-- {name} -->\n).*?(<!-- /{name} -->)", re.DOTALL)
        text = between.sub(lambda match, frame=frame: match[1] + markdown(frame) + match[2], text)
    page.write_text(text, "utf-8")


if __name__ == "__main__":
    refresh(Path("docs", "paper.md"), Path("cases"))
