"""Records with other values: what a call with these would make, refuse, or solve."""

import math

import pytest
from scenes import CASES, WALLS, block_on_floor, two_blocks
from scenes_in_space import box_on_floor

import masonry_opt as mo

BLOCK = block_on_floor(friction=0.4)
CASED = BLOCK.replace(load_cases=[mo.LoadCase(name="push", live={"live": 1.0})]).in_case("push")
STORM = [mo.LoadCase(name="push", live={"live": 2.0})]


def changes(**others: object) -> dict[str, object]:
    return {"blocks": {"A": {"weight": 2.0}}} | others


@pytest.mark.parametrize("changed", [mo.Scene.replace, lambda scene, **keys: scene.model_copy(update=keys)])
@pytest.mark.parametrize(
    ("keys", "load_factor"),
    [
        ({"friction": 0.3}, 0.3),
        ({"joints": {"friction": 0.3}}, 0.3),
        ({"joints": mo.JointDefaults(friction=0.3)}, 0.3),
        ({"friction_angle": math.degrees(math.atan(0.3))}, 0.3),
        ({"cohesion": 0.02, "joints": {"friction": 0.3}}, 0.32),
        (changes(), 0.8),
        (changes(friction=0.3), 0.6),
        ({"blocks": {"A": {"unit_weight": 2.0}}}, 1.6),  # in place of the weight
        ({"block": [*BLOCK.replace(blocks={"A": {"live": (2.0, 0.0)}}).blocks]}, 0.2),  # by the alias
        ({"loads": [mo.Load(block="A", dead=(0, -1))]}, 0.8),
        ({"exceptions": [mo.Joint(between=("A", "floor"), friction=0.1)]}, 0.1),
    ],
)
def test_a_scene_with_other_values_is_solved_with_these(changed, keys, load_factor):
    """A block of weight W that slides, λ H = μ W + c L (L = 1), after the same scene has been solved."""
    assert mo.solve(BLOCK, "static").load_factor == pytest.approx(0.4, rel=1e-6)
    other = changed(BLOCK, **keys)
    assert mo.solve(other, "static").load_factor == pytest.approx(load_factor, rel=1e-6)
    assert block_on_floor(friction=0.4) == BLOCK


@pytest.mark.parametrize("changed", [mo.Scene.replace, lambda scene, **keys: scene.model_copy(update=keys)])
@pytest.mark.parametrize(
    ("scene", "keys", "named"),
    [
        (BLOCK, {"frction": 0.3}, "did you mean 'friction'"),
        (BLOCK, {"friction": -1.0}, "joints.friction"),
        (BLOCK, {"joints": {"dilatancy": 0.5}}, "must not exceed"),
        (BLOCK, {"tolerance": -1}, "'tolerance'"),
        (BLOCK, {"joint": [mo.Joint(between=("A", "B"), friction=1)]}, "no block 'B'"),
        (BLOCK, {"load": [mo.Load(block="A", live=(1, 0, 0))]}, "two numbers"),
        (BLOCK, {"blocks": BLOCK.blocks[:1]}, "no block is fixed"),
        (BLOCK, {"blocks": {"A": {"weigth": 3}}}, "Block 'A'.*did you mean 'weight'"),
        (BLOCK, {"blocks": {"flor": {"fixed": False}}}, "did you mean 'floor'"),
        (BLOCK, {"blocks": {"A": {"weight": 1, "unit_weight": 1}}}, "not both"),
        (BLOCK, {"weight": 3}, "'weight' is a key of blocks: change it there"),
        (BLOCK, {"friction": 0.3, "joints": mo.JointDefaults(friction=1)}, "a key of joints"),
        (BLOCK, {"friction": 0.3, "joints": {"friction": 0.2}}, "a key of joints"),
        (two_blocks(), {"friction": 0.3}, "'friction' is a key of joints and exceptions: change it there"),
        (box_on_floor((1, 1, 1)), {"strength": 1.0}, "'strength' is for joints in the plane"),
        (CASED, {"load_cases": []}, "no load case 'push'"),
    ],
)
def test_what_a_call_refuses_is_refused(changed, scene, keys, named):
    with pytest.raises(mo.MasonryError, match=named):
        changed(scene, **keys)


def test_every_record_is_checked():
    assert mo.box("A", (0, 1), (0, 1), (0, 1), weight=1).replace(weight=2).weight == 2
    arch = mo.load(CASES / "casapulla_lauro" / "arch.toml").case.arch[0]
    for record, key in (
        (mo.Solid(name="A", box=((0, 1), (0, 1), (0, 1)), weight=1), "weight"),
        (mo.Tie(between=("A", "ground"), at=((0, 0), (1, 0)), strength=1), "strength"),
        (mo.Earthquake(direction="left"), "coefficient"),
        (arch, "thickness"),
    ):
        with pytest.raises(mo.CaseError, match=f"{type(record).__name__}.*'{key}'"):
            record.replace(**{key: -1.0})


def test_a_scene_stays_where_it_was_read_and_in_its_load_case():
    wall = mo.load(WALLS[0]).replace(title="wall")
    assert (wall.origin, wall.title) == (str(WALLS[0]), "wall")
    assert CASED.replace(friction=0.3).load_case == CASED.load_case
    assert CASED.replace(load_cases=STORM).load_case == STORM[0]


def test_what_is_set_says_what_to_do():
    for record, key in ((BLOCK.blocks[0], "weight"), (BLOCK.joints, "friction"), (BLOCK, "anything")):
        with pytest.raises(mo.CaseError, match=rf"replace\({key}=\.\.\.\)"):
            setattr(record, key, 3.0)
        with pytest.raises(mo.CaseError, match=rf"'{key}' cannot be deleted.*replace\({key}=\.\.\.\)"):
            delattr(record, key)


@pytest.mark.parametrize(
    ("blocks", "written"),
    [
        (mo.load(WALLS[0]).case.wall[0], r"write Wall\(...\).blocks\(\)"),
        ([mo.load(WALLS[0]).case.wall[0], BLOCK.blocks[1]], r"write \*Wall\(...\).blocks\(\)"),
        (BLOCK.blocks[0], "must be a list"),
    ],
)
def test_a_record_that_is_no_list_is_one_mistake(blocks, written):
    with pytest.raises(mo.CaseError, match=written) as refused:
        mo.Scene(joints=BLOCK.joints, blocks=blocks)
    assert len(str(refused.value).splitlines()) == 1
