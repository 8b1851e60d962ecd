"""Settings classes check their values when they are created."""

import inspect
import math
from dataclasses import fields, replace

import pytest
from scenes import CASES, two_blocks

import masonry_opt as mo
from masonry_opt.methods.bounds.settings import ProofSettings
from masonry_opt.methods.settings import Settings

CLASSES = [mo.IncrementalSettings, mo.SearchSettings, mo.ProofBudget, ProofSettings]

#: Settings class, field, wrong value, and the words of the message that state the needed value.
WRONG = [
    *((mo.IncrementalSettings, "increment", value, "a finite number above 0")
      for value in (-1, 0, "a", None, True, math.nan, math.inf, [0.1])),
    (mo.IncrementalSettings, "increments", 2.5, "a whole number above 0"),
    (mo.IncrementalSettings, "increments", 0, "a whole number above 0"),
    (mo.IncrementalSettings, "halvings", -1, "a whole number of 0 or more"),
    (mo.IncrementalSettings, "acceleration", 1.0, "a finite number above 1"),
    (mo.SearchSettings, "load_shares", (1.0, 0.5), "a tuple of two finite numbers above 0, the smaller"),
    (mo.SearchSettings, "load_shares", (0.5, 0.7, 1.0), "a tuple of two finite numbers above 0, the smaller"),
    (mo.SearchSettings, "tolerances", [1e-11], "a tuple of finite numbers above 0"),
    (mo.SearchSettings, "tolerances", (), "a tuple of finite numbers above 0"),
    (mo.SearchSettings, "steps_in_space", (0.5, math.nan), "a tuple of finite numbers of 0 or more"),
    (mo.SearchSettings, "weight_series_in_space", (1e3, 1e4), "a tuple of tuples of finite numbers above 0"),
    (mo.ProofBudget, "programs", -1, "a whole number of 0 or more"),
    (mo.ProofBudget, "seconds", 0, "a finite number above 0"),
    (ProofSettings, "decide_every", 0, "a whole number above 0"),
]  # fmt: skip

#: Settings class, field, and a value that switches a part of the algorithm off.
OFF = [
    (mo.IncrementalSettings, "halvings", 0),
    (mo.SearchSettings, "steps_in_space", ()),
    (mo.SearchSettings, "repairs", 0),
    (mo.ProofBudget, "most_joints", 0),
    (ProofSettings, "most_products", 0),
    (ProofSettings, "least_share", 0),
]


@pytest.mark.parametrize(("settings", "name", "value", "needed"), WRONG)
def test_a_wrong_value_is_refused_with_the_needed_value(settings, name, value, needed):
    with pytest.raises(mo.OptionError) as refused:
        settings(**{name: value})
    assert str(refused.value).startswith(f"{settings.__name__}: '{name}' must be {needed}")
    with pytest.raises(mo.OptionError, match=f"'{name}'"):
        replace(settings(), **{name: value})


@pytest.mark.parametrize("settings", CLASSES)
def test_every_field_is_checked(settings):
    assert issubclass(settings, Settings)
    for field in fields(settings):
        for value in (-1, math.nan, "a", (-1.0, -1.0)):
            with pytest.raises(mo.OptionError, match=f"{settings.__name__}: '{field.name}' must be "):
                settings(**{field.name: value})


@pytest.mark.parametrize(("settings", "name", "value"), OFF)
def test_zero_is_accepted_where_it_switches_a_part_off(settings, name, value):
    assert getattr(settings(**{name: value}), name) == value


def test_settings_change_the_analysis():
    """With a range wider than the smallest increment, the analysis misses the exact state of two blocks."""
    scene = two_blocks()
    narrow = mo.solve(scene, "incremental")
    wide = mo.solve(scene, "incremental", settings=mo.IncrementalSettings(tolerance=0.02))
    assert narrow.incremental_reasons[0].code == "collapse"
    assert wide.incremental_reasons[0].code == "range"
    assert wide.incremental == pytest.approx(narrow.incremental, rel=0.02)
    assert wide.load_factor == wide.end < wide.incremental


def test_further_starts_are_omitted_above_the_limit_of_the_simplex_method():
    scene, unproven = two_blocks(), mo.ProofBudget(most_joints=0)
    settings = mo.SearchSettings(simplex_up_to=2)
    assert len(mo.assemble(scene).joints.first) > settings.simplex_up_to
    result = mo.solve(scene, settings=settings, budget=unproven)
    assert result.load_factor is not None
    assert "further starts" not in [entry.step for entry in result.solution.log]


#: Settings class, and the file and the title of the page of the guide that explains its fields.
EXPLAINED = [
    (mo.IncrementalSettings, "incremental.md", "The incremental analysis", "Settings"),
    (mo.SearchSettings, "method.md", "The method", "Settings of the default method"),
    (mo.ProofBudget, "method.md", "The method", "Settings of the default method"),
]


@pytest.mark.parametrize(("settings", "file", "page", "section"), EXPLAINED)
def test_help_names_the_section_of_the_guide_that_explains_every_field(settings, file, page, section):
    """The section that the docstring names prints the comments of the class, and each field has a comment."""
    assert f'page "{page}", section "{section}"' in " ".join(settings.__doc__.split())
    guide = (CASES.parent / "docs" / file).read_text(encoding="utf-8")
    assert f"\n# {page}\n" in f"\n{guide}"
    printed = guide.partition(f"## {section}\n")[2].partition("\n## ")[0]
    assert f"autoclass:: {settings.__module__}.{settings.__name__}\n" in printed
    lines = [line.strip() for line in inspect.getsource(settings).splitlines()]
    for field in fields(settings):
        number = next(number for number, line in enumerate(lines) if line.startswith(f"{field.name}:"))
        assert lines[number - 1].startswith("#:")
