"""What the index page and the tables say of a published value and ours."""

from __future__ import annotations

import math
import re
import sys

import pandas as pd
import pytest

from masonry_opt.errors import OptionError
from masonry_opt.studies.paper.example import PublishedValue, Report
from masonry_opt.studies.paper.folder import open_folder, write_report

SOURCES = ("1 + (t9 - t1), in closed form", "<Fig. 8>")


def page_of(folder, *values, **tables):
    tables = {stem: pd.DataFrame(columns) for stem, columns in tables.items()}
    captions = dict.fromkeys(tables, "")
    write_report(folder, "fig8", Report([*values], tables=tables, captions=captions), 1.0)
    return (folder / "index.html").read_text()


def cells(page):
    """Of each row of a table's body, the class and the text of each cell."""
    rows = [re.findall(r'<td(?: class="(\w+)")?>(.*?)</td>', row) for row in page.split("<tr>")]
    return [row for row in rows if row]


def test_alignment_is_a_columns_own(tmp_path):
    page = page_of(
        tmp_path,
        *(
            PublishedValue("λ", published, 1e-9, source)
            for published, source in zip((1.8, (0, 1)), SOURCES, strict=True)
        ),
        fig8_wedges={"number or none": [1.5, math.nan], "name or number": ["∞", "9"]},
    )
    *_, first, second, third, fourth = cells(page)
    assert [kind for kind, _ in first] == ["", "number", "number", "number", ""]
    assert [kind for kind, _ in second] == ["", "number", "number", "number", ""]
    assert second[-1][1] == "&lt;Fig. 8&gt;"
    assert [kind for kind, _ in third] == [kind for kind, _ in fourth] == ["number", ""]


def test_missed_values_are_marked(tmp_path):
    values = [PublishedValue("λ", 1.8, computed, "", tolerance=1e-3) for computed in (1.8, 1.9, None)]
    rows = cells(page_of(tmp_path, *values))
    assert [row[-1][0] == "missed" for row in rows[-3:]] == [False, True, True]


def test_difference_from_a_published_zero_is_absolute():
    within, beyond = (PublishedValue("share", 0.0, share, "", tolerance=1e-3) for share in (5e-4, 2e-3))
    assert (within.missed, beyond.missed) == (False, True)
    assert beyond.difference == 2e-3
    assert math.isnan(beyond.as_row()["diff %"])
    assert "%" not in beyond.line


@pytest.mark.parametrize(("computed", "relative"), [(0.09, -0.1), (0.15, 0.0), (0.3, 0.5), (None, math.nan)])
def test_difference_from_an_interval(computed, relative):
    value = PublishedValue("λ", (0.1, 0.2), computed, "")
    assert value.relative_difference == pytest.approx(relative, nan_ok=True)


def test_jinja2_is_missed_before_anything_is_solved(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "jinja2", None)
    with pytest.raises(OptionError, match="Jinja2"):
        open_folder(tmp_path)
