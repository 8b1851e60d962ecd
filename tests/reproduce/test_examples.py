"""Every example of the paper, end to end: values within tolerance, and a page that shows them."""

from __future__ import annotations

import pytest
from scenes import CASES

from masonry_opt.errors import CaseError
from masonry_opt.studies.paper.folder import write_report
from masonry_opt.studies.paper.registry import EXAMPLES, find_examples

FIGURES = ["fig6", "fig7", "fig8", "fig10", "fig11", "fig12", "fig13", "facades", "variants", "dilatancy"]

#: Those that take more than a few seconds.
SLOW = {"fig6", "fig11", "fig13", "facades", "variants", "dilatancy"}

#: Examples of several figures: the one that stands for them.
SHOWN = {"facades": "fig16"}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] if name in SLOW else []) for name in FIGURES]
)
def test_figure(name, tmp_path):
    said = []
    report = EXAMPLES[name].run(CASES, said.append)
    assert said
    assert report.published_values
    assert any(entry.tolerance is not None for entry in report.published_values)
    assert report.missed == []
    assert all(entry.computed is not None or entry.cause for entry in report.published_values)
    assert any("time" in column for frame in report.tables.values() for column in frame.columns)
    write_report(tmp_path, name, report, 1.0)
    page = (tmp_path / "index.html").read_text()
    for stem in report.figures:
        assert f'src="{stem}.png"' in page
        assert (tmp_path / f"{stem}.png").stat().st_size > 10_000
        assert report.captions[stem]
    for stem, frame in report.tables.items():
        assert f'href="{stem}.csv"' in page
        assert len(frame)
        assert report.captions[stem]
    assert SHOWN.get(name, name) in report.figures


def test_examples_are_in_the_papers_order():
    shown = [name for name in EXAMPLES if name in {*FIGURES, "table1"}]
    assert shown == [*FIGURES[:3], "table1", *FIGURES[3:]]


def test_all_are_those_of_the_paper():
    assert set(EXAMPLES) - set(find_examples("all")) == {"bracket", "stability"}


@pytest.mark.parametrize("name", FIGURES)
def test_missing_case_file_is_named(name, tmp_path):
    with pytest.raises(CaseError, match="no such file"):
        EXAMPLES[name].run(tmp_path, lambda _: None)


@pytest.mark.slow
def test_convergence_study():
    """Section 5.3: β = 1 cycles, β = 0.2 takes many sub-problems, everything else converges."""
    runs = EXAMPLES["fig11"].run(CASES, lambda _: None).tables["fig11_outcomes"].set_index("run")
    assert runs.loc["β = 1", "status"] == "not converged: cycling"
    assert (runs.drop("β = 1")["status"] == "converged").all()
    assert runs.loc["β = 0.2", "sub-problems"] > 3 * runs.loc["β = 0.4", "sub-problems"]


def test_energy_adds_up():
    """Work of the live load = raised weight + friction, at every iteration; no friction at first (all
    dilatancy is associative). To the solver's 1e-9 relative to the whole."""
    table = EXAMPLES["fig12"].run(CASES, lambda _: None).tables["fig12"]
    assert (table["raised weight"] + table["sliding"]).to_numpy() == pytest.approx(
        table["λ"].to_numpy(), rel=1e-6
    )
    assert table["sliding"][0] == 0
