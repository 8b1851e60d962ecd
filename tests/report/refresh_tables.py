"""Write Table 1 in ``docs/paper.md`` and its residuals in ``benchmarks/README.md``.

Run ``python tests/report/refresh_tables.py`` after ``make table1``, which writes the values to results/.
"""

import re
from pathlib import Path

import pandas as pd

from masonry_opt.reporting.sentences import numeral

#: Columns that the page omits. The times are measured in one run on one machine.
LEFT_OUT = ["method", "NLPs", "time (s)", "published (s)"]

#: Sentences above the tables into which Table 1 is divided so that each fits on the page, and the columns of
#: each table.
GROUPS = {
    "The first table compares the associative load factors with the paper.": [
        "b × c",
        "assoc. paper",
        "CVXPY",
        "Pyomo",
    ],
    "The second table compares the loop with the paper, and adds the incremental load factors.": [
        *("loop paper", "loop", "loop diff %", "incremental")
    ],
    "The third table compares `coulomb` and `mpec` with published load factors of the MCP and MPEC.": [
        *("MCP publ.", "coulomb", "coulomb diff %", "MPEC publ.", "mpec")
    ],
    "The last table compares the load factors that the search finds with the lowest known load factors.": [
        *("lowest known", "search", "search diff %")
    ],
}


def markdown(frame: pd.DataFrame) -> str:
    """Return a frame as a Markdown table, with load factors in the paper's five digits."""
    rows = [[str(column) for column in frame.columns], ["---"] * len(frame.columns)]
    for record in frame.to_dict("records"):
        rows.append([_cell(str(column), value) for column, value in record.items()])
    return "".join(f"| {' | '.join(cells)} |\n" for cells in rows).replace(" --- ", "---")


def _cell(column: str, value: object) -> str:
    if not isinstance(value, float):
        return str(value).replace(" × ", "\u00a0×\u00a0")  # a size stays on one line
    digits = ".5f" if value > 1e-2 else ".1e"
    return numeral(value, "+.3f" if "%" in column else digits)


def tables(folder: Path) -> dict[str, str]:
    residuals = pd.read_csv(folder / "table1_residuals.csv")
    loops = residuals[residuals["method"] == "loop"].drop(columns=LEFT_OUT)
    walls = pd.read_csv(folder / "table1.csv")
    parts = [f"{sentence}\n\n{markdown(walls[['wall', *names]])}" for sentence, names in GROUPS.items()]
    return {"table1": "\n".join(parts), "residuals": markdown(loops)}


def refresh(page: Path, folder: Path) -> None:
    text = page.read_text("utf-8")
    for name, table in tables(folder).items():
        between = re.compile(rf"(<!-- {name} -->\n).*?(<!-- /{name} -->)", re.DOTALL)
        text = between.sub(lambda match, table=table: match[1] + table + match[2], text)
    page.write_text(text, "utf-8")


if __name__ == "__main__":
    for page in Path("docs", "paper.md"), Path("benchmarks", "README.md"):
        refresh(page, Path("results"))
