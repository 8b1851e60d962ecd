"""Tests of parameter names: an entry has the same name alone and among others, and items of lists have
numbers."""

import pytest

import masonry_opt as mo
from masonry_opt.studies.many.parameters import Parameters

BLOCKS = [
    mo.Block(name="A", vertices=[(0, 0), (1, 0), (1, 1), (0, 1)], weight=10, live=(1, 0)),
    mo.Block(name="B", vertices=[(-2, -1), (5, -1), (5, 0), (-2, 0)], fixed=True),
    mo.Block(name="C", vertices=[(3, 0), (4, 0), (4, 1), (3, 1)], weight=10),
]


def tie(name=None, height=0.5):
    return mo.Tie(name=name, between=("A", "C"), at=((0.5, height), (3.5, height)), strength=3)


def prop(name=None, height=0.3):
    return mo.Prop(name=name, between=("A", "C"), at=((1, height), (3, height)), strength=4)


def fill(left):
    backing = mo.Backing(line=[(left, 1.5), (left + 1, 1.5)], unit_weight=20)
    road = [(left, 2), (left + 1, 2)]
    return mo.Fill(road=road, unit_weight=18, friction_angle=30, mobilised=0.5, backing=backing)


def group(name):
    return mo.Axles(
        name=name, loads=[3, 4], distances=[1.0], uniform=[mo.UniformLoad(load=2, start=2, end=4)]
    )


def scene(**records):
    return mo.Scene(joints=mo.JointDefaults(friction=0.5), blocks=BLOCKS, **records)


ONE = scene(ties=[tie("rod")], props=[prop("strut")], fills=[fill(0)], axles=[group("bogie")])
TWO = scene(
    ties=[tie("rod"), tie("other", 0.7)],
    props=[prop("strut"), prop("other", 0.2)],
    fills=[fill(0), fill(3)],
    axles=[group("bogie"), group("other")],
)
NAMES = {
    "tie.rod.strength": lambda scene: scene.ties[0].strength,
    "tie.rod.prestress": lambda scene: scene.ties[0].prestress,
    "prop.strut.strength": lambda scene: scene.props[0].strength,
    "fill.1.mobilised": lambda scene: scene.fills[0].mobilised,
    "fill.1.backing.unit_weight": lambda scene: scene.fills[0].backing.unit_weight,
    "axles.bogie.factor": lambda scene: scene.axles[0].factor,
    "axles.bogie.loads.2": lambda scene: scene.axles[0].loads[1],
    "axles.bogie.distances.1": lambda scene: scene.axles[0].distances[0],
}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("from_file", [False, True])
@pytest.mark.parametrize("of", [ONE, TWO], ids=["one", "two"])
def test_an_entry_has_its_name_whether_or_not_it_is_alone(tmp_path, of, name, from_file):
    if from_file:
        mo.save(of, tmp_path / "case.toml")
        of = mo.load(tmp_path / "case.toml")
    changed = Parameters(of).at({name: 0.75})
    assert NAMES[name](changed) == 0.75
    assert [NAMES[other](changed) for other in NAMES if other != name] == [
        NAMES[other](of) for other in NAMES if other != name
    ]


def test_short_names_are_those_of_a_single_entry():
    one = Parameters(ONE)
    for name in ("tie.strength", "prop.strength", "fill.mobilised", "axles.loads.1", "axles.uniform.load"):
        one.check_names({name: 1.0})
        with pytest.raises(mo.OptionError, match="no parameter is called"):
            Parameters(TWO).check_names({name: 1.0})
    with pytest.raises(mo.OptionError, match="are the same parameter"):
        one.check_names({"tie.strength": 1.0, "tie.rod.strength": 1.0})
    Parameters(scene(ties=[tie()])).check_names({"tie.A/C.strength": 1.0})
    Parameters(scene(ties=[tie(), tie("x", 0.7)])).check_names({"tie.A/C.strength": 1.0})


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("tie.rood.strength", "tie.rod.strength"),
        ("ties.rod.strength", "tie.rod.strength"),
        ("axles.bogie.load.1", "axles.bogie.loads.1"),
        ("Fill.1.mobilised", "fill.1.mobilised"),
        ("prop.strut.strenght", "prop.strut.strength"),
    ],
)
def test_a_misspelt_name_has_a_suggestion(name, near):
    with pytest.raises(mo.OptionError, match=f"no parameter is called '{name}'; did you mean '{near}'"):
        Parameters(ONE).check_names({name: 1.0})


def test_a_name_that_resembles_no_other_is_answered_with_a_short_list():
    with pytest.raises(mo.OptionError, match=r"; there are: gravity\.x, .* and \d+ more$") as refusal:
        Parameters(ONE).check_names({"zzz": 1.0})
    listed, others = str(refusal.value).partition("there are: ")[2].split(" and ")
    assert len(listed.split(", ")) + int(others.split()[0]) == len(Parameters(ONE).names)
