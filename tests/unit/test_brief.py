"""The `repr` of an object has two lines at most, whatever the object contains."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from scenes import CASES, WALLS, axles_on_a_beam, small_wall

import masonry_opt as mo
from masonry_opt.brief import brief
from masonry_opt.effort import Effort
from masonry_opt.methods.task import Task

#: Largest number of lines of the ``repr`` of an object.
MOST_LINES = 2
#: Largest number of characters of the ``repr`` of an object.
MOST_CHARACTERS = 400


def assert_short(thing: object) -> None:
    text = repr(thing)
    assert len(text.splitlines()) <= MOST_LINES, text[:1000]
    assert len(text) <= MOST_CHARACTERS, text[:1000]
    assert type(thing).__name__ in text
    assert "object at 0x" not in text


def ring(count: int) -> list[tuple[float, float]]:
    angles = [2 * math.pi * number / count for number in range(count)]
    return [(math.cos(angle), math.sin(angle)) for angle in angles]


def test_matrices_of_a_large_wall():
    """Wall 6 has 146 blocks; the matrices alone have 3,700 numbers."""
    scene = mo.load(WALLS[5])
    assembly = mo.assemble(scene)
    problem = assembly.problem
    assert repr(problem) == (
        "<Problem of 146 movable blocks, 345 joints, 0 limited forces: B 438 × 1035, C 1380 × 1035>"
    )
    parts = (problem.matrices, problem.law, problem.layout, assembly.geometry, assembly.joints)
    forces = (assembly.block_loads, assembly.block_loads.live)
    for thing in (scene, assembly, problem, assembly.problem_names(), *parts, *forces):
        assert_short(thing)


def test_records_of_many_points():
    """The records are a polygon of 500 corners, solids of many corners and parts, a road of many points, and
    others."""
    shape = mo.load(CASES / "space" / "corner_wall.toml").blocks[0]
    corners = [(x, y, z) for z in (0.0, 1.0) for x, y in ring(200)]
    sides = [[i, (i + 1) % 200, 200 + (i + 1) % 200, 200 + i] for i in range(200)]
    faces = [[*range(199, -1, -1)], [*range(200, 400)], *sides]
    many = [(float(x), 0.0) for x in range(300)]
    records = [
        mo.Block(name="round", vertices=ring(500), weight=1.0),
        mo.Block(name="name " * 30, vertices=ring(3), holes=[ring(9)], weight=1.0),
        mo.Solid(name="drum", vertices=corners, faces=faces, weight=1.0),
        mo.Solid(
            name="parts", parts=[mo.Part(box=((i, i + 1), (0, 1), (0, 1))) for i in range(50)], weight=1
        ),
        mo.Axles(name="train", loads=[1.0] * 40, distances=[1.0] * 39, road=many),
        mo.Fill(road=many, unit_weight=18.0, friction_angle=30.0, mobilised=0.5),
        mo.JointDefaults(friction=0.6),
        mo.Joint(between=("a", "b"), friction=0.1),
        mo.LoadCase(name="wind", live={f"group {number}": 1.0 for number in range(90)}),
        mo.Reference(value=1.0, source="a book " * 20),
        shape,
    ]
    for record in records:
        assert_short(record)
        assert len(str(record).splitlines()) == 1
    assert repr(records[0]) == "Block(name='round', vertices=<list of 500>, weight=1.0)"
    assert repr(records[6]) == "JointDefaults(friction=0.6)"


def test_a_result_and_its_parts():
    result = mo.solve(CASES / "gilbert" / "two_blocks.toml")
    solution, answer, proof = result.solution, result.solution.answer, result.proof
    for thing in (result, solution, answer, result.certificate, result.size, result.at_incremental, proof):
        assert_short(thing)
    for thing in (solution.incremental.load_history, *solution.incremental.history, *proof.conflicts):
        assert_short(thing)
    assert_short(mo.certify(result.assembly, result.load_factor, result.q, result.d))
    assert_short(mo.prove_least(CASES / "gilbert" / "two_blocks.toml"))
    assert_short(mo.check_proof(CASES / "gilbert" / "two_blocks.toml", proof))


def test_a_proof_prints_as_a_sentence():
    proof = mo.solve(CASES / "gilbert" / "two_blocks.toml").proof
    text = str(proof)
    assert text.startswith("no collapse state has a load factor from 0 to 0.149999925: proof by ")
    assert f"{len(proof.conflicts)} conflicts, for {proof.conditions} yield conditions" in text
    assert "\n" not in text


@pytest.mark.slow
def test_answers_of_studies():
    wall = small_wall(2, 2)
    for answer in (
        mo.crossing(axles_on_a_beam(0.5), method="static"),
        mo.sample(wall, {"joints.friction": ("normal", 0.6, 0.05)}, n=2, workers=1, method="static"),
        mo.settle(axles_on_a_beam(0.5).replace(axles=[]), "east", (0, -1)),
        curve := mo.capacity(mo.solve(wall, incremental=False)),
        *(curve.live, curve.steps[0]),
    ):
        assert_short(answer)


@pytest.mark.slow
def test_answers_of_slower_studies():
    wall = small_wall(2, 2)
    groups = [mo.LoadCase(name="push", live={"live": 1.0}), mo.LoadCase(name="both", live={"live": 2.0})]
    for answer in (
        mo.check(wall),
        mo.solve_cases(wall.replace(load_cases=groups), "static"),
        mo.least(lambda friction: wall.replace(friction=friction), 0.1, 0.9, load=0.3, method="static"),
    ):
        assert_short(answer)


@dataclass
class Everything:
    """A class with values of every kind."""

    array: np.ndarray
    nothing: None
    numbers: list[float]
    table: dict[str, float]
    words: str
    last: int = 3
    other: int = 4

    __repr__ = brief


def test_values_of_every_kind():
    thing = Everything(np.zeros((2, 3)), None, [1.0, 2.0], {"a": 1.0}, "x" * 100, other=5)
    assert repr(thing) == (
        "Everything(array=<ndarray of shape (2, 3)>, nothing=None, numbers=[1.0, 2.0], table={'a': 1.0}, "
        f"words='{'x' * 55}...', other=5)"
    )
    long = Everything(np.zeros(2), None, [1.0] * 100, dict.fromkeys("abc", np.zeros(9)), "")
    assert "numbers=<list of 100>, table=<dict of 3>, words=''" in repr(long)
    for letters in (57, 58, 59, 60, 61):
        words = repr(Everything(np.zeros(2), None, [], {}, "x" * letters)).partition("words=")[2]
        assert len(words.rstrip(")")) <= 60


def test_counts_of_an_analysis_and_its_task():
    """Classes that are neither dataclasses nor records show their public values."""
    effort = Effort()
    effort.lp_solves = 3
    assert repr(effort).startswith("Effort(seconds=<dict of 8>, lp_solves=3")
    problem = mo.assemble(CASES / "gilbert" / "two_blocks.toml").problem
    assert "lp_solves=3" in repr(Task(problem, effort=effort))
