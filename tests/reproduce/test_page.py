"""What the index page and the tables say of a published value and ours."""

from __future__ import annotations

import math
import re
import sys

import pandas as pd
import pytest
from scenes import CASES

import masonry_opt as mo
from masonry_opt.errors import OptionError
from masonry_opt.studies.paper.example import Basis, PublishedValue, Report, published_value
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


def test_only_what_was_published_stands_under_published(tmp_path):
    """Each value in the column of its basis, a dash in the others, no column that none needs."""
    values = [
        PublishedValue("λ", 1.5, 1.5, "Fig. 8"),
        PublishedValue("λ", 1.8, 1.8, "by hand: 1 + 0.8", basis=Basis.BY_HAND),
    ]
    frame = Report(values).published_table
    assert [*frame] == ["what", "published", "derived by hand", "ours", "diff %", "source"]
    assert frame["published"].tolist() == ["1.5", "–"]
    assert frame["derived by hand"].tolist() == ["–", "1.8"]
    assert "derived by hand" not in Report(values[:1]).published_table
    assert '<td class="number">1.8</td>' in page_of(tmp_path, *values)


@pytest.mark.parametrize(
    ("case", "reference", "basis"),
    [
        ("livesley/wedges.toml", "associative", Basis.BY_HAND),
        ("livesley/wedges.toml", "nonassociative", Basis.PUBLISHED),
        ("gilbert/wedge_blocks.toml", "coulomb", Basis.BY_HAND),
        ("casapulla_lauro/arch.toml", "least_thickness_sector", Basis.COMPUTED),
        ("casapulla_lauro/arch.toml", "least_thickness", Basis.PUBLISHED),
        ("ferris_tinloi/wall_5.toml", "refined", Basis.COMPUTED),
        ("ferris_tinloi/wall_5.toml", "mcp", Basis.PUBLISHED),
    ],
)
def test_the_source_of_a_case_file_tells_the_basis(case, reference, basis):
    assert published_value(mo.load(CASES / case), reference, 1.0, "").basis is basis


def test_a_published_zero_has_no_percentage(tmp_path):
    row = cells(page_of(tmp_path, PublishedValue("share", 0.0, 2e-3, "footnote 4")))[-1]
    assert [text for _, text in row] == ["share", "0", "0.002", "–", "footnote 4"]


def test_missed_values_are_marked(tmp_path):
    values = [PublishedValue("λ", 1.8, computed, "", tolerance=1e-3) for computed in (1.8, 1.9, None)]
    rows = cells(page_of(tmp_path, *values))
    assert [row[-1][0] == "missed" for row in rows[-3:]] == [False, True, True]
    assert len({len(row) for row in rows[-3:]}) == 1


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
