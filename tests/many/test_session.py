"""Tests of parameters by name, and of sessions: each scene is answered as if alone, and programs compile
once."""

import itertools
import math

import pytest
from cvxpy.reductions.dcp2cone.cone_matrix_stuffing import ConeMatrixStuffing
from scenes import CASES, block_on_floor, overhanging, small_wall, two_blocks

import masonry_opt as mo
from masonry_opt.analysis import prepare
from masonry_opt.studies.many.parameters import Parameters

FRICTIONS = (0.5, 0.3, 0.8)

WALL = small_wall(3, 2)
#: Wall for method "coulomb", which solves a hundred programs where other methods solve one.
SMALLER_WALL = small_wall(2, 2)


def wall_for(method):
    """Return the wall that is solved with a method."""
    return SMALLER_WALL if method == "coulomb" else WALL


def with_joints(scene, **joints):
    """Return the scene with other properties of its joints and with the same block objects."""
    return scene.model_copy(update={"joints": mo.JointDefaults(**joints)})


@pytest.mark.slow
@pytest.mark.parametrize("method", ["static", "kinematic", "coulomb", "nonassociative"])
def test_a_scene_is_answered_as_if_alone(method):
    session = prepare(method, keeps=True)
    for friction in FRICTIONS:
        scene = with_joints(wall_for(method), friction=friction)
        result, alone = session.solve(scene), mo.solve(scene, method)
        assert result.load_factor == pytest.approx(alone.load_factor, abs=1e-8)
        assert (result.status, result.exact, result.reasons) == (alone.status, alone.exact, alone.reasons)
        assert max(result.certificate.as_dict().values()) < 2e-3
        assert (result.case, result.size) == (alone.case, alone.size)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "options", "wall"),
    [
        ("static", {"model": "pyomo"}, WALL),
        ("static", {"model": "pyomo"}, SMALLER_WALL),
        ("static", {"solver": "highs"}, WALL),
        ("coulomb", {}, SMALLER_WALL),
    ],
)
def test_what_came_before_changes_no_digit(method, options, wall):
    """The order of the scenes changes no digit of an answer.

    HiGHS starts neither with the basis nor with the scaling of the scene before. The basis could lead to
    another vertex. The scaling would change the last digit of the wall's load factor for a friction of 0.3.
    """
    ends = []
    for order in (FRICTIONS, FRICTIONS[::-1]):
        session = prepare(method, keeps=True, **options)
        ends.append({mu: session.solve(with_joints(wall, friction=mu)) for mu in order})
    for friction in FRICTIONS:
        one, other = (end[friction] for end in ends)
        assert one.load_factor == other.load_factor
        assert one.joints.equals(other.joints)
        assert one.blocks.equals(other.blocks)


@pytest.mark.parametrize("method", ["static", pytest.param("coulomb", marks=pytest.mark.slow)])
def test_every_property_of_joints_may_change(method):
    """All properties of joints may change in a session: values that become zero, joints that cannot slide,
    strength."""
    session = prepare(method, keeps=True)
    laws = [
        *({"friction": 0.5} | more for more in ({}, {"cohesion": 0.05}, {"dilatancy": 0.2})),
        *({"friction": 0.0, "cohesion": 1.0}, {"friction": float("inf")}),
        *({"friction": mu, "strength": strength} for mu, strength in ((0.5, 8.0), (0.6, 8.0), (0.6, 9.0))),
    ]
    for law in laws if method == "static" else laws[:6]:
        scene = with_joints(WALL, **law)
        alone = mo.solve(scene, method)
        assert session.solve(scene).load_factor == pytest.approx(alone.load_factor, abs=1e-8), law


@pytest.mark.slow
def test_other_blocks_and_loads_are_assembled_anew():
    session = prepare("static", keeps=True)
    for width, friction in itertools.product((1.0, 0.6), (0.6, 0.4)):
        scene = block_on_floor(width=width, friction=friction)
        assert session.solve(scene).load_factor == pytest.approx(min(width / 2, friction), abs=1e-8)
    assert session.solve(block_on_floor(live=(2.0, 0.0))).load_factor == pytest.approx(0.25, abs=1e-8)
    assert session.solve(overhanging()).load_factor is None
    session = prepare("coulomb", keeps=True)
    for friction in (0.1, 0.2):  # Exceptions may change too.
        assert session.solve(two_blocks(friction)).load_factor == pytest.approx(1.5 * friction, abs=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "kept", "alone"), [("static", 2, 2), ("kinematic", 2, 2), ("coulomb", 0, 0)]
)
def test_programs_are_compiled_once(watched, method, kept, alone):
    """A session compiles each program once: the check of the dead load, and the associative program.

    Method "coulomb" computes the associative load factor from matrices, and its load history shows that the
    dead load is carried, so it compiles nothing.
    """
    compiled = watched(ConeMatrixStuffing, "apply")
    session = prepare(method, keeps=True)
    for friction in FRICTIONS:
        session.solve(with_joints(wall_for(method), friction=friction))
    assert len(compiled) == kept
    for friction in FRICTIONS:
        mo.solve(with_joints(wall_for(method), friction=friction), method)
    assert len(compiled) == kept + alone * len(FRICTIONS)


@pytest.mark.parametrize("order", [(0.8, 0.4, 0.6), (0.6, 0.8, 0.4), (0.4, 0.6, 0.8)])
def test_what_carried_the_scene_before_is_no_proof_for_less_friction(order):
    """A block on a slope of 1 in 2 is stable if its friction is above 0.5, whatever the scene before."""
    block = mo.Block(name="A", vertices=[(0, 0), (2, 1), (1, 3), (-1, 2)], weight=1, live=(1, 0))
    ground = mo.Block(name="ground", vertices=[(-4, -2), (6, 3), (6, -3)], fixed=True)
    scene = mo.Scene(joints=mo.JointDefaults(friction=order[0]), blocks=[block, ground])
    session = prepare("static", keeps=True)
    for friction in order:
        result = session.solve(with_joints(scene, friction=friction))
        assert (result.status is mo.Status.UNSTABLE) == (friction < 0.5)


ON_PIERS = CASES / "examples" / "arch_on_piers.toml"


@pytest.fixture(scope="module")
def on_piers():
    return Parameters(mo.load(ON_PIERS))


@pytest.mark.parametrize(
    ("name", "written", "instead", "value"),
    [
        ("joints.friction", "friction_angle = 33", "friction = 0.5", 0.5),
        ("joints.friction_angle", "friction_angle = 33", "friction_angle = 20", 20.0),
        ("joints.cohesion", "friction_angle = 33", "friction_angle = 33\ncohesion = 2.0", 2.0),
        ("arch.thickness", "thickness = 0.4", "thickness = 0.3", 0.3),
        ("arch.voussoirs", "voussoirs = 12", "voussoirs = 14", 14.0),
        ("arch.live.y", "live = [1, 0]", "live = [1, 0.5]", 0.5),
        ("column.left buttress.width.2", "width = [1, 0.4]", "width = [1, 0.6]", 0.6),
        ("edge_load.1.force.y", "force = [0, -40]", "force = [0, -10]", -10.0),
        ("thickness", "thickness = 0.6", "thickness = 0.8", 0.8),
    ],
)
def test_a_number_set_is_the_number_written_in_the_file(on_piers, tmp_path, name, written, instead, value):
    text = ON_PIERS.read_text()
    changed = tmp_path / "changed.toml"
    # Only the first occurrence is replaced.
    changed.write_text(text.replace(written, instead, 1))
    expected = mo.load(changed)
    assert on_piers.at({name: value}) == expected
    assert expected != on_piers.scene


def test_values_are_set_together(on_piers):
    scene = on_piers.at({"arch.thickness": 0.3, "joints.friction_angle": 20.0, "joints.cohesion": 1.0})
    assert scene.joints.friction == math.tan(math.radians(20))
    assert scene.joints.cohesion == 1
    assert scene.blocks == on_piers.at({"arch.thickness": 0.3}).blocks
    # If only joint properties change, the block objects stay.
    scene = on_piers.at({"joints.friction": 0.3})
    assert all(one is other for one, other in zip(scene.blocks, on_piers.scene.blocks, strict=True))
    assert scene.origin == str(ON_PIERS)


def test_scenes_made_in_python_have_blocks_and_exceptions():
    parameters = Parameters(two_blocks())
    scene = parameters.at({"block.A.weight": 3.0, "block.A.live.y": 0.5, "joint.B/support.friction": 0.7})
    block = scene.blocks[0]
    assert (block.weight, block.live) == (3, (1, 0.5))
    assert scene.exceptions[0].friction == 0.7
    assert parameters.at({"block.A.unit_weight": 2.0}).blocks[0].weight is None


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("joints.frction", "joints.friction"),
        ("arch.thicknes", "arch.thickness"),
        ("column.left pier.hight", "column.left pier.height"),
        ("block.v1.weight", "arch.thickness"),  # The arch makes this block.
        ("nothing", "joints.friction"),
        ("joints.dilatancy_stress", "joints.dilatancy"),
        ("title", "joints.friction"),
    ],
)
def test_an_unknown_name_is_told_what_there_is(on_piers, name, near):
    with pytest.raises(mo.OptionError, match=near):
        on_piers.at({name: 1.0})


@pytest.mark.parametrize(
    ("name", "value"),
    [("arch.voussoirs", 12.5), ("arch.voussoirs", 13), ("arch.thickness", -1.0), ("joints.dilatancy", 2.0)],
)
def test_values_that_make_no_scene_are_named(on_piers, name, value):
    with pytest.raises(mo.CaseError, match=f"{name} = {value:g}"):
        on_piers.at({name: value})


def test_a_scene_changed_since_it_was_read_is_what_it_is_now(on_piers):
    read = on_piers.scene
    changed = read.replace(blocks=block_on_floor().blocks, edge_loads=[])
    parameters = Parameters(changed)
    assert "arch.thickness" not in parameters.names
    assert parameters.at({"block.A.weight": 2.0}).blocks[0].weight == 2


@pytest.mark.parametrize(
    "names", [("joints.friction", "joints.friction_angle"), ("block.A.unit_weight", "block.A.weight")]
)
def test_two_names_of_one_thing_are_refused(names):
    with pytest.raises(mo.OptionError, match=f"'{names[0]}' and '{names[1]}'|'{names[1]}' and '{names[0]}'"):
        Parameters(two_blocks()).at(dict.fromkeys(names, 0.5))
