"""The reference: what Sphinx is given of docstrings."""

import inspect
from pathlib import Path

import pytest

import masonry_opt as mo
from masonry_opt.scene.arch import ArchRing

pytest.importorskip("sphinx")

RECORDS = [
    mo.Scene, mo.Block, mo.Joint, mo.JointDefaults, mo.EdgeLoad, mo.Load, mo.PointLoad, mo.Reference,
    mo.LoadCase, mo.Earthquake,
    mo.Arch, mo.Wall, mo.Facade, mo.Column, mo.Solid, mo.Part,
    mo.Plan, mo.PlanWall, mo.Opening, mo.Barrel, mo.Dome, mo.Groin, mo.Shaft, ArchRing,
]  # fmt: skip


@pytest.fixture
def records(monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "docs" / "_ext"))
    import records

    return records


def documented(records, of):
    """The lines of a docstring as Napoleon gets them."""
    lines = inspect.getdoc(of).splitlines()
    records._process(None, "class", of.__name__, of, None, lines)
    return lines


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: record.__name__)
def test_every_field_of_a_record_is_told_with_its_type_and_nothing_of_pydantic(records, record):
    lines = documented(records, record)
    named = [line.split(" : ")[0].split(", ") for line in lines if " : " in line and not line.startswith(" ")]
    fields = [name for names in named for name in names]
    assert sorted(fields) == sorted(record.model_fields)
    assert not [line for line in lines if "model_" in line]


def test_types_and_defaults_are_those_of_the_class(records):
    text = "\n".join(documented(records, mo.Column))
    assert "drums : int\n    How many." in text
    assert "batter : Literal['both', 'left', 'right'], default 'both'" in text
    assert "width : float or tuple[float, float]\n" in text
    assert (
        "name, at, live_per_weight, live : name: str or None; at: tuple[float, float], default (0, 0); live"
        in text
    )
    signature, _ = records._call(None, "class", "", mo.Column, None, "", "")
    assert signature.startswith(
        "(*, width, height, drums, name=None, at=(0, 0), live_per_weight=(0, 0), live=(0, 0)"
    )
