"""Warnings about values that look as if they were in another unit, and displayed forces at their limits."""

from dataclasses import replace

import numpy as np
import pytest
from atlas.small_scenes import rectangle
from scenes import block_on_floor
from unit.reporting.test_sense import row, warned

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.limited_forces import Role
from masonry_opt.reporting.sentences import message, sentences
from masonry_opt.solution.frames import tie_frame
from masonry_opt.solution.reasons import Code, reason
from masonry_opt.solution.sense import warnings_of
from masonry_opt.studies.crossing.units import unusual_axles


#: Build a scene with a fill and its backing, for the unit weights of the fill, the backing and the blocks.
def filled(fill, backing, masonry=22.0, thickness=1.0):
    cubes = [mo.Block(name=f"{n}", vertices=square(n), unit_weight=masonry) for n in range(2)]
    floor = mo.Block(name="floor", vertices=[(-1, -1), (3, -1), (3, 0), (-1, 0)], fixed=True)
    above = mo.Backing(line=[(0, 1.5), (2, 1.5)], unit_weight=backing)
    earth = mo.Fill(road=[(0, 3), (2, 3)], unit_weight=fill, pressure=False, backing=above)
    scene = mo.Scene(joints={"friction": 0.5}, blocks=[*cubes, floor], fills=[earth], thickness=thickness)
    return scene.replace(loads=[mo.Load(block="0", live=(1, 0))])


def square(left):
    return [(left, 0), (left + 1, 0), (left + 1, 1), (left, 1)]


@pytest.mark.parametrize("thickness", [0.5, 7.8])
@pytest.mark.parametrize(
    ("fill", "backing", "masonry", "expected"),
    [
        (18.0, 20.0, 22.0, []),
        (18000.0, 20.0, 22.0, [(False, 18000.0, "blocks", 22.0)]),
        (18.0, 20000.0, 22.0, [(True, 20000.0, "blocks", 22.0)]),
        (18.0, 20.0, 22000.0, [(False, 18.0, "blocks", 22000.0), (True, 20.0, "blocks", 22000.0)]),
        (18.0, 20000.0, 0.0, [(True, 20000.0, "fill", 18.0)]),
        (18.0, 20.0, 0.0, []),
    ],
)
def test_fill_of_another_unit_than_the_blocks(fill, backing, masonry, expected, thickness):
    found = warned(filled(fill, backing, masonry, thickness), Code.FILL_WEIGHT_DIFFERS)
    keys = ("backing", "unit_weight", "beside", "other")
    assert [tuple(values[key] for key in keys) for values in found] == [
        (*values[:3], pytest.approx(values[3])) for values in expected
    ]
    assert all(values["fill"] == 1 for values in found)


def test_a_warning_of_units_names_both_values():
    (sentence,) = sentences(warnings_of(assemble(filled(18000.0, 20.0)), None))
    assert sentence == (
        "the unit weight of fill no. 1 is 18000, but the unit weight of the blocks is 22: "
        "the values seem to be in N/m³ and kN/m³ (1 kN/m³ is 1000 N/m³); use the same units for both weights"
    )
    (sentence,) = sentences(warnings_of(assemble(tied(20.0, 1e8)), None))
    assert sentence == (
        "the strength of tie 'rod' is 20, but the median weight of a block is 1e+08: use the same unit for "
        "forces and weights"
    )


def tied(strength, weight, prestress=0.0):
    rod = mo.Tie(
        between=("0", "ground"), at=[(0, 0.5), (-9, 0.5)], strength=strength, prestress=prestress, name="rod"
    )
    return row(weight, weight, live=(weight, 0.0)).replace(ties=[rod])


@pytest.mark.parametrize(
    ("strength", "prestress", "expected"),
    [
        (1 / 149, 0.0, []),
        (1 / 151, 0.0, [("strength", 1 / 151, 1.0)]),
        (39.0, 0.0, []),
        (41.0, 0.0, [("strength", 41.0, 2.0)]),
        (None, 0.0, []),
        (None, 41.0, [("prestress", 41.0, 2.0)]),
        (1.0, 1 / 999, []),
        (1.0, 1 / 1001, [("prestress", 1 / 1001, 1.0)]),
    ],
)
def test_a_tie_of_another_unit_than_the_weights(strength, prestress, expected):
    """Two blocks weigh 1 each, together 2. A warning appears for a strength below 2/300, for a prestress
    below 1/1000, and for either value above 40."""
    found = warned(tied(strength, 1.0, prestress), Code.STRENGTH_DIFFERS)
    assert [(values["key"], values["value"], values["weight"]) for values in found] == [
        (key, value, pytest.approx(weight)) for key, value, weight in expected
    ]


def arch_with_a_rod(strength, unit_weight):
    """Return an arch of fourteen stones, 0.4 m by about 0.35 m, with a rod that ties its springings. At 22
    kN/m³, a stone weighs about 3 kN and all stones weigh 43 kN."""
    arch = mo.Arch(span=4.0, rise=2.0, thickness=0.4, voussoirs=14, unit_weight=unit_weight)
    blocks = arch.blocks()
    ends = [blocks[1].name, blocks[-2].name]
    middles = [tuple(np.mean(block.vertices, axis=0)) for block in (blocks[1], blocks[-2])]
    rod = mo.Tie(between=ends, at=middles, strength=strength)
    live = [mo.Load(block=blocks[5].name, live=(0, -1))]
    return mo.Scene(joints={"friction": 0.6}, blocks=blocks, ties=[rod], loads=live)


@pytest.mark.parametrize(
    ("strength", "unit_weight", "is_warned"),
    [(30.0, 22.0, False), (30e3, 22.0, True), (30.0, 22e3, True), (30e3, 22e3, False), (3e3, 2.2e3, False)],
)
def test_a_rod_of_30_kn_in_newtons_or_kilonewtons(strength, unit_weight, is_warned):
    """A rod of 30 kN causes a warning only if its unit differs from that of the weights. The last row is in
    kg."""
    assert bool(warned(arch_with_a_rod(strength, unit_weight), Code.STRENGTH_DIFFERS)) is is_warned


#: Unit weights of one block and of all others, and the units that the warning names (None: no warning).
BESIDE = [
    (2200.0, 22.0, "kg/m³ and kN/m³"),
    (22000.0, 22.0, "N/m³ and kN/m³"),
    (2.2, 22.0, "t/m³ and kN/m³"),
    (22.0, 2200.0, "kN/m³ and kg/m³"),
    (22.0, 22000.0, "kN/m³ and N/m³"),
    (2200.0, 22000.0, "kg/m³ and N/m³"),
    (1800.0, 25.0, "kg/m³ and kN/m³"),
    (2500.0, 16.0, "kg/m³ and kN/m³"),
    (18.0, 22.0, None),
    (5.0, 27.0, None),  # timber
    (78.5, 22.0, None),  # steel
    (0.2, 22.0, None),  # expanded polystyrene
    (140.0, 160.0, None),  # pounds per cubic foot
    (1.6, 2.2, None),  # tonnes per cubic metre
]


SHAPED = [lambda scene: scene, lambda scene: scene.replace(thickness=0.5), mo.extrude]


@pytest.mark.parametrize(
    ("own", "other", "units", "shaped"),
    [(*beside, SHAPED[number % 3]) for number, beside in enumerate(BESIDE)],
)
def test_unit_weights_beside_each_other(own, other, units, shaped):
    """One of four blocks has another unit weight. The scene is plane, plane with a thickness, or in space."""
    cubes = [mo.Block(name=f"{n}", vertices=square(2 * n), unit_weight=other) for n in range(3)]
    cubes += [mo.Block(name="own", vertices=square(7), unit_weight=own, live=(1, 0))]
    floor = mo.Block(name="floor", vertices=[(-1, -1), (9, -1), (9, 0), (-1, 0)], fixed=True)
    scene = shaped(mo.Scene(joints={"friction": 0.5}, blocks=[*cubes, floor]))
    found = [each for each in warnings_of(assemble(scene), None) if each.code is Code.WEIGHTS_DIFFER]
    assert [each.values["blocks"] for each in found] == ([["own"]] if units else [])
    if units:
        (sentence,) = sentences(found)
        assert f"block 'own' is {own:g}, but the median of all blocks is {other:g}: " in sentence
        assert f"the values seem to be in {units} (1 kN/m³ is " in sentence


@pytest.mark.parametrize(("own", "other", "units"), BESIDE)
@pytest.mark.parametrize("backing", [False, True])
def test_unit_weights_of_fill_beside_blocks(own, other, units, backing):
    zones = (other, own) if backing else (own, other)
    found = warnings_of(assemble(filled(*zones, other)), None)
    assert [(each.code, each.values["backing"]) for each in found] == (
        [(Code.FILL_WEIGHT_DIFFERS, backing)] if units else []
    )
    if units:
        assert f"the values seem to be in {units} " in sentences(found)[0]


def test_unit_weights_of_fills_beside_each_other():
    """If all blocks are weightless, fills are compared with each other. The second of three fills is in
    kg/m³."""
    blocks = [mo.Block(name=f"{n}", vertices=square(2 * n), weight=0) for n in range(3)]
    floor = mo.Block(name="floor", vertices=[(-1, -1), (7, -1), (7, 0), (-1, 0)], fixed=True)
    fills = [
        mo.Fill(road=[(2 * n, 3), (2 * n + 1, 3)], unit_weight=weight, pressure=False)
        for n, weight in enumerate([18.0, 1800.0, 19.0])
    ]
    scene = mo.Scene(joints={"friction": 0.5}, blocks=[*blocks, floor], fills=fills)
    found = warned(scene.replace(loads=[mo.Load(block="0", live=(1, 0))]), Code.FILL_WEIGHT_DIFFERS)
    assert [(values["fill"], values["beside"], values["other"]) for values in found] == [(2, "fill", 19.0)]


def test_weights_in_the_plane_may_differ_by_thicknesses():
    """Weights per area of 2 and 22 are plausible for walls 0.1 and 1 thick. A weight of 2200 is a mistake in
    either case. If the scene has a thickness, a weight of 2 is a mistake too."""
    assert warned(row(22, 22, 2, live=(1, 0)), Code.WEIGHTS_DIFFER) == []
    assert [values["blocks"] for values in warned(row(22, 22, 2200, live=(1, 0)), Code.WEIGHTS_DIFFER)] == [
        ["2"]
    ]
    given = row(22, 22, 2, live=(1, 0)).replace(thickness=1.0)
    assert [values["blocks"] for values in warned(given, Code.WEIGHTS_DIFFER)] == [["2"]]


@pytest.mark.parametrize("method", ["static", "coulomb"])
@pytest.mark.parametrize("weight", [1.0, 1e4, 1e8])
def test_no_force_is_shown_beyond_its_limit(method, weight):
    """The displayed force of a tie that yields is its strength, 20. The error of a solver grows with the
    largest force of the scene: for this tie, a solver returned 20.023."""
    result = mo.solve(tied(20.0, weight), method)
    assert result.ties["force"].tolist() == [20.0]
    assert "forces in the force unit of the case: " in str(result)
    assert "yields at 20" in str(result)
    assert "yields at 20.0" not in str(result)


def test_a_force_that_violates_its_limit_is_shown_as_it_is():
    result = mo.solve(tied(20.0, 10.0), "static")
    q = result.solution.q.copy()
    q[-1] *= 1.01  # the last entry is the force of the tie
    found = replace(result.solution.state, q=q)
    frame = tie_frame(result.assembly, replace(result.solution, state=found), Role.TIE)
    assert frame["force"].tolist() == pytest.approx([20.2])


@pytest.mark.parametrize(
    ("key", "value", "is_unusual"),
    [("strength", value, value in (11, 4.1e5)) for value in (11, 13, 3.9e5, 4.1e5)]
    + [("cohesion", value, value in (0.11, 25_000)) for value in (0.11, 0.13, 23_000, 25_000)],
)
def test_stresses_in_another_unit_than_the_weights(key, value, is_unusual):
    """A block 2 high of 20 kN/m³ presses with 40 kN/m². A warning appears for a strength outside of 0.3 to
    10,000 times this stress, and for a cohesion outside of 0.003 to 600 times this stress."""
    scene = block_on_floor(weight=40).replace(**{key: value})
    found = warned(scene, Code.STRESS_DIFFERS)
    assert found == ([{"key": key, "value": value, "weight": pytest.approx(40)}] if is_unusual else [])


def test_a_low_scene_is_compared_with_a_column_as_high_as_the_scene_is_long():
    """A block 4 long and 2 high weighs 20 kN/m³. A column as high as the length of 4 presses with 80
    kN/m²."""
    scene = block_on_floor(width=4, weight=160).replace(strength=5)
    (values,) = warned(scene, Code.STRESS_DIFFERS)
    assert values == {"key": "strength", "value": 5, "weight": pytest.approx(80)}
    assert "a column as high as the largest dimension of the scene presses with 80" in message(
        [reason(Code.STRESS_DIFFERS, **values)]
    )


@pytest.mark.slow
def test_axles_in_another_unit_than_the_weights():
    """The axles of CS 454 are in kN and m, so a unit weight of 22,000 looks like N/m³. No axle has a load of
    more than 1500 kN."""
    deck = rectangle("deck", 0, 0, 4, 1, unit_weight=22)
    piers = [rectangle(f"pier {x}", x, -2, x + 1, 0) for x in (0, 3)]
    road = [(0, 1), (4, 1)]
    scene = mo.Scene(joints={"friction": 0.6}, blocks=[deck, *piers])

    def warned_of(scene, **axles):
        crossed = mo.crossing(scene, mo.Axles(name="lorry", road=road, **axles), method="static")
        return [w["sentence"] for w in crossed.warning_records if w["code"] == "axles differ"]

    common = "CS 454 double 1.3 m"
    heavy = scene.replace(blocks={"deck": {"unit_weight": 22_000}})
    assert warned_of(scene, set=common) == []
    assert (
        "the median unit weight of the blocks, 22000, seems to be in N/m³" in warned_of(heavy, set=common)[0]
    )
    assert warned_of(scene, loads=[1500]) == []
    in_kilonewtons = "is 1510, but the median unit weight of the blocks, 22, seems to be in kN/m³"
    assert in_kilonewtons in warned_of(scene, loads=[1510])[0]
    in_newtons = "is 120, but the median unit weight of the blocks, 22000, seems to be in N/m³"
    assert in_newtons in warned_of(heavy, loads=[120])[0]
    assert warned_of(heavy, loads=[1]) == warned_of(heavy, loads=[120_000]) == []


def test_relative_axle_loads_have_no_unit():
    """The message has the load that is compared, without the share of the width that the scene carries."""
    deck, pier = rectangle("deck", 0, 0, 4, 1, unit_weight=22_000), rectangle("pier", 0, -2, 4, 0)
    assembly = assemble(mo.Scene(joints={"friction": 0.6}, blocks=[deck, pier]))

    def warned_of(*loads, **keys):
        group = mo.Axles(name="lorry", loads=loads, distances=[1.0] * (len(loads) - 1), **keys)
        return [warning["sentence"] for warning in unusual_axles(assembly, [group])]

    assert warned_of(1, factor=1.35) == warned_of(0.5, 0.5) == warned_of(2, 1, 1) == []
    (sentence,) = warned_of(120, 60, width=3.0)
    assert "the largest load of axles 'lorry' is 120, but the median unit weight" in sentence
    assert "is 162, but" in warned_of(120, factor=1.35)[0]


@pytest.mark.parametrize(("length", "warns"), [(999.0, False), (1001.0, True)])
def test_lengths_in_another_unit_than_the_unit_weight(length, warns):
    """A beam of 1000 m is longer than any scene. The value 20 looks like a weight in kN/m³, and the values 1
    and 2e-5 (N/mm³) look like no unit weight in metres. The value 2.2 may be in gf/cm³."""
    ground = rectangle("ground", 0, -1, length, 0)

    def lengths(unit_weight):
        beam = rectangle("beam", 0, 0, length, 1, unit_weight=unit_weight, live=(1, 0))
        return warned(mo.Scene(joints={"friction": 0.5}, blocks=[beam, ground]), Code.LENGTHS_DIFFER)

    expected = {"extent": pytest.approx(length), "unit_weight": pytest.approx(20)}
    assert lengths(20.0) == ([expected] if warns else [])
    assert lengths(1.0) == lengths(2e-5) == lengths(2.2) == []


def test_the_length_of_a_scene_with_weights_of_unknown_thickness_is_not_doubted():
    """A beam of 0.1 m by 20 m in N and cm, 10 m thick, weighs 20 N/cm², a number that is usual in kN/m³."""
    beam, ground = (
        rectangle("beam", 0, 0, 2000, 10, weight=400e3, live=(1, 0)),
        rectangle("g", 0, -1, 2000, 0),
    )
    scene = mo.Scene(joints={"friction": 0.5}, blocks=[beam, ground])
    assert warned(scene, Code.LENGTHS_DIFFER) == []
    assert len(warned(scene.replace(thickness=1.0), Code.LENGTHS_DIFFER)) == 1


def test_a_warning_of_lengths_names_the_unit_weight():
    values = {"extent": 5000.0, "unit_weight": 2200.0}
    sentence = message([reason(Code.LENGTHS_DIFFER, **values)])
    assert sentence.startswith(
        "the blocks extend over 5000, but their median unit weight, 2200, looks like kg/m³: use metres for"
    )


def test_common_axles_in_a_scene_in_millimetres():
    """A set of axles is in kN and m. The unit weight of 2.2e-5 N/mm³ is not recognized, but 4000 m is longer
    than any scene."""
    deck, pier = rectangle("deck", 0, 0, 4e3, 1e3, unit_weight=2.2e-5), rectangle("pier", 0, -2e3, 4e3, 0)
    scene = mo.Scene(joints={"friction": 0.6}, blocks=[deck, pier], thickness=1e3)
    (warning,) = unusual_axles(assemble(scene), [mo.Axles(name="lorry", set="CS 454 single")])
    assert warning["extent"] == pytest.approx(4e3)
    assert "the set of axles 'lorry' is in kN and m, but the blocks extend over 4000" in warning["sentence"]


def test_an_angle_in_radians_given_in_degrees():
    """The angle may be computed from the tangent 0.6 or from 31°. The warning converts it to degrees."""
    for angle, degrees in ((np.arctan(0.6), "31.0"), (np.radians(31), "31.0"), (0.5, "28.6")):
        scene = block_on_floor().replace(joints={"friction_angle": float(angle)})
        (values,) = warned(scene, Code.FRICTION_LOW)
        sentence = message([reason(Code.FRICTION_LOW, **values)])
        assert f"set 'friction_angle' to {degrees}" in sentence
    # A small coefficient that was computed is intended.
    assert warned(block_on_floor(friction=0.01234567890123), Code.FRICTION_LOW) == []


def test_a_tangent_given_as_an_angle():
    scene = block_on_floor().replace(joints={"friction_angle": 0.6})
    (values,) = warned(scene, Code.FRICTION_LOW)
    assert values["friction"] == pytest.approx(np.tan(np.radians(0.6)))
    assert "if tan φ = 0.6 is meant, use 'friction'" in message([reason(Code.FRICTION_LOW, **values)])
    assert warned(block_on_floor().replace(joints={"friction_angle": 1.7}), Code.FRICTION_LOW) == []


@pytest.mark.parametrize("friction", [0.001, 0.01, 0.015, 0.0123456])
def test_a_small_friction_that_is_no_angle_is_intended(friction):
    """Nobody who wrote 'friction' is advised to write it instead of 'friction_angle'."""
    assert warned(block_on_floor(friction=friction), Code.FRICTION_LOW) == []


def test_a_friction_angle_of_a_fill_that_looks_like_a_tangent():
    """A friction angle below 1.5° is permitted, as that of undrained clay. The warning names the angles that
    belong to the tangent 0.6 and to 0.6 rad."""

    def angles(fill, backing=None, **keys):
        line = [(-3, 1), (3, 1)]
        below = mo.Backing(line=line, unit_weight=22, friction_angle=backing)
        road = [(-3, 4), (3, 4)]
        made = mo.Fill(road=road, unit_weight=19, friction_angle=fill, mobilised=1, backing=below, **keys)
        return warned(block_on_floor().replace(fills=[made]), Code.FILL_ANGLE_LOW)

    assert angles(0.6) == [{"fill": 1, "backing": False, "friction_angle": 0.6}]
    (backing,) = angles(30, 0.5)
    assert backing == {"fill": 1, "backing": True, "friction_angle": 0.5}
    assert angles(30) == angles(30, 1.5) == angles(0.6, pressure=False) == []
    sentence = message([reason(Code.FILL_ANGLE_LOW, **backing)])
    assert "the 'friction_angle' of the backing of fill no. 1 is 0.5°" in sentence
    assert "set 'friction_angle' to 26.6 or 28.6" in sentence


def test_a_backing_below_all_blocks():
    def backed(height):
        backing = mo.Backing(line=[(-3, height), (3, height)], unit_weight=22)
        fill = mo.Fill(road=[(-3, 4), (3, 4)], unit_weight=19, pressure=False, backing=backing)
        return warned(block_on_floor().replace(fills=[fill]), Code.IDLE_BACKING)

    assert backed(-1.0) == [{"fill": 1}]
    assert backed(1.0) == []
