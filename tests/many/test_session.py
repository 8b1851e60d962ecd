"""Many scenes by one session: as if each were solved alone, of one compile while joints alone change."""

import itertools

import pytest
from cvxpy.reductions.dcp2cone.cone_matrix_stuffing import ConeMatrixStuffing
from scenes import block_on_floor, overhanging, small_wall, two_blocks

import masonry_opt as mo
from masonry_opt.analysis import prepare

FRICTIONS = (0.5, 0.3, 0.8)

WALL = small_wall(3, 2)


def with_joints(scene, **joints):
    """The scene with other properties of its joints, its blocks the same objects."""
    return scene.model_copy(update={"joints": mo.JointDefaults(**joints)})


@pytest.mark.parametrize("method", ["static", "kinematic", "mcp", "refined", "nonassociative"])
def test_a_scene_is_answered_as_if_alone(method):
    session = prepare(method, keeps=True)
    for friction in FRICTIONS:
        scene = with_joints(WALL, friction=friction)
        result, alone = session.solve(scene), mo.solve(scene, method)
        assert result.load_factor == pytest.approx(alone.load_factor, abs=1e-8)
        assert (result.status, result.exact, result.reasons) == (alone.status, alone.exact, alone.reasons)
        assert max(result.certificate.as_dict().values()) < 2e-3
        assert (result.case, result.size) == (alone.case, alone.size)


@pytest.mark.parametrize(
    ("method", "options"), [("static", {"model": "pyomo"}), ("static", {"solver": "highs"}), ("mcp", {})]
)
def test_what_came_before_changes_no_digit(method, options):
    """Of simplex too, which could begin at the last basis, and end in another of many vertices."""
    ends = []
    for order in (FRICTIONS, FRICTIONS[::-1]):
        session = prepare(method, keeps=True, **options)
        ends.append({mu: session.solve(with_joints(WALL, friction=mu)) for mu in order})
    for friction in FRICTIONS:
        one, other = (end[friction] for end in ends)
        assert one.load_factor == other.load_factor
        assert one.joints.equals(other.joints)
        assert one.blocks.equals(other.blocks)


@pytest.mark.parametrize("method", ["static", pytest.param("mcp", marks=pytest.mark.slow)])
def test_every_property_of_joints_may_change(method):
    """One after the other in one session: numbers that become zero, joints that cannot slide, strength."""
    session = prepare(method, keeps=True)
    laws = [
        {"friction": 0.5},
        {"friction": 0.5, "cohesion": 0.05},
        {"friction": 0.5, "dilatancy": 0.2},
        {"friction": 0.0, "cohesion": 1.0},
        {"friction": float("inf")},
        {"friction": 0.5, "strength": 8.0},
        {"friction": 0.6, "strength": 8.0},
        {"friction": 0.6, "strength": 9.0},
    ]
    for law in laws if method == "static" else laws[:6]:
        scene = with_joints(WALL, **law)
        alone = mo.solve(scene, method)
        assert session.solve(scene).load_factor == pytest.approx(alone.load_factor, abs=1e-8), law


def test_other_blocks_and_loads_are_assembled_anew():
    session = prepare("static", keeps=True)
    for width, friction in itertools.product((1.0, 0.6), (0.6, 0.4)):
        scene = block_on_floor(width=width, friction=friction)
        assert session.solve(scene).load_factor == pytest.approx(min(width / 2, friction), abs=1e-8)
    assert session.solve(block_on_floor(live=(2.0, 0.0))).load_factor == pytest.approx(0.25, abs=1e-8)
    assert session.solve(overhanging()).load_factor is None


def test_exceptions_may_change():
    session = prepare("mcp", keeps=True)
    for friction in (0.1, 0.2):
        scene = two_blocks(friction)
        assert session.solve(scene).load_factor == pytest.approx(1.5 * friction, abs=1e-8)


@pytest.mark.parametrize(("method", "compiles"), [("static", 2), ("kinematic", 2), ("mcp", 4)])
def test_programs_are_compiled_once(monkeypatch, method, compiles):
    """The check of the dead load, and the associative program; of "mcp" two of the descent beside them."""
    compiled = []
    stuff = ConeMatrixStuffing.apply

    def counted(self, problem):
        compiled.append(problem)
        return stuff(self, problem)

    monkeypatch.setattr(ConeMatrixStuffing, "apply", counted)
    session = prepare(method, keeps=True)
    for friction in FRICTIONS:
        session.solve(with_joints(WALL, friction=friction))
    assert len(compiled) == compiles
    for friction in FRICTIONS:
        mo.solve(with_joints(WALL, friction=friction), method)
    assert len(compiled) == compiles * (1 + len(FRICTIONS))


@pytest.mark.parametrize("order", [(0.8, 0.4, 0.6), (0.6, 0.8, 0.4), (0.4, 0.6, 0.8)])
def test_what_carried_the_scene_before_is_no_proof_for_less_friction(order):
    """A block on a slope of 1 in 2 stands if its friction is above 0.5, whichever stood before."""
    block = mo.Block(name="A", vertices=[(0, 0), (2, 1), (1, 3), (-1, 2)], weight=1, live=(1, 0))
    ground = mo.Block(name="ground", vertices=[(-4, -2), (6, 3), (6, -3)], fixed=True)
    scene = mo.Scene(joints=mo.JointDefaults(friction=order[0]), blocks=[block, ground])
    session = prepare("static", keeps=True)
    for friction in order:
        result = session.solve(with_joints(scene, friction=friction))
        assert (result.status is mo.Status.UNSTABLE) == (friction < 0.5)
