"""Proofs by products: the bonds that they prove, the forms that they multiply, and corrupted proofs."""

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from atlas.random_scenes import random_scene
from atlas.small_scenes import bonded
from proofs import FOLDER
from pysat.formula import CNF
from pysat.solvers import Minisat22
from scenes import small_wall

import masonry_opt as mo
from masonry_opt.effort import Effort
from masonry_opt.methods.bounds.least import prove_least
from masonry_opt.methods.bounds.products import ProductChain
from masonry_opt.methods.bounds.search import ConflictSearch, NoLoadFactorLeft, bound_below
from masonry_opt.methods.bounds.settings import SETTINGS
from masonry_opt.methods.task import Task
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import Problem
from masonry_opt.proof_check import check
from masonry_opt.solution.product_check import ProductChecker
from masonry_opt.solution.products import KINEMATIC_FACTORS, STATIC_FACTORS, NormalLimit, ProductRelaxation
from masonry_opt.solution.proof import REACH, Proof

#: Friction of the running bonds.
FRICTION = 0.65
#: Least load factor of the tower of running_bond(1, 6). Five courses rotate about the toe of the tower, with
#: the half brick at the toe, and the other half brick stays. Bricks are 4 wide and 1.75 high.
TOWER = (5 * 2.0 + 0.5 * 1.0) / (5 * 6.125 + 0.5 * 0.875)


def running_bond(width: int, height: int) -> mo.Scene:
    """Return a running bond of ``height`` courses, each as long as ``width`` stretchers."""
    full, half = [1.0] * width, [0.5, *[1.0] * (width - 1), 0.5]
    courses = [half if course % 2 == 0 else full for course in range(height)]
    return bonded(courses, (4.0, 1.75), FRICTION)(None)


def proven_by_products(scene: mo.Scene) -> Proof:
    """Return a proof without conflicts that the default's load factor is the least."""
    problem = assemble(scene).problem
    best = mo.solve(scene, incremental=False).required()
    chain = ProductChain(problem, Effort())
    needed = bound_below(best, SETTINGS, problem.load_factor_scale)
    selected = chain.selections[0]
    for _ in range(2):
        if chain.bound < needed:
            chain.raise_bound(best, selected, 60.0)
    return chain.proof(best, needed)


@pytest.fixture(scope="module")
def proven() -> tuple[Problem, Proof]:
    """Return a bond of 16 joints with its proof by the products of one relaxation."""
    scene = running_bond(2, 3)
    return assemble(scene).problem, proven_by_products(scene)


def test_a_bond_that_slides_is_proven(proven):
    """A course slides on the course below at λ = μ, because the live load is equal to the weight."""
    problem, proof = proven
    assert proof.load_factor == pytest.approx(FRICTION, rel=1e-12)
    assert proof.bound == pytest.approx(FRICTION, rel=1e-6)
    found = check(problem, proof)
    assert found.faults == ()
    assert (found.static, found.kinematic) == (0, 0)
    assert found.products == len(proof.relaxations[0].multipliers)
    assert found.reach >= REACH
    assert f"{found.products} products of a static and a kinematic form" in str(found)
    assert f"proof by {found.products:,} products".replace(",", "") in str(proof).replace(",", "")


@pytest.mark.parametrize(("width", "height", "least"), [(2, 3, FRICTION), (1, 6, TOWER)])
@pytest.mark.parametrize("with_known_state", [True, False])
def test_a_proof_of_the_exact_bound_is_confirmed(width, height, least, with_known_state):
    """Products prove exactly the least load factor, which may exceed that of the state by rounding errors."""
    scene = running_bond(width, height)
    problem = assemble(scene).problem
    answer = mo.solve(scene, incremental=False).solution.answer if with_known_state else None
    upper = mo.solve(scene, "static").required()
    outcome = prove_least(Task(problem), answer, 60.0, upper, replace(SETTINGS, first_products=50))
    assert outcome.best.load_factor == pytest.approx(least, rel=1e-9)
    assert outcome.proof.excluded_by_products <= outcome.best.load_factor
    assert outcome.proof.relaxations
    assert check(problem, outcome.proof).faults == ()


def test_the_search_ends_at_a_state_below_which_products_exclude_all_others():
    problem = assemble(running_bond(1, 6)).problem
    search = ConflictSearch(Task(problem), 0.355, SETTINGS)
    search.raise_to(TOWER * (1 - 1e-8))
    with pytest.raises(NoLoadFactorLeft):
        search.run(np.inf)
    assert search.known == pytest.approx(TOWER, rel=1e-9)
    assert search.best.exact


@pytest.mark.slow
@pytest.mark.parametrize(
    ("width", "height", "least"), [(2, 5, 0.611296), (2, 6, 0.545055), (3, 4, FRICTION), (3, 5, FRICTION)]
)
def test_bonds_of_27_to_41_joints_are_proven(width, height, least):
    """The least load factors are those in benchmarks/README.md; λ = μ if a course slides."""
    scene = running_bond(width, height)
    found = mo.prove_least(scene, seconds=300)
    assert found.load_factor == pytest.approx(least, abs=1e-6)
    assert found.proof is not None
    assert found.proof.relaxations
    assert mo.check_proof(scene, found.proof).holds


@pytest.mark.slow
def test_products_and_conflicts_complete_a_proof_together():
    """ProductRelaxation exclude the states up to a part of λ, and conflicts exclude the states above."""
    scene = random_scene("tessellation", 2750079)
    found = mo.prove_least(scene, seconds=300)
    assert found.proof is not None
    assert found.proof.relaxations
    assert found.proof.conflicts
    assert mo.check_proof(scene, found.proof).holds
    without = replace(found.proof, relaxations=(), excluded_by_products=0.0)
    assert not mo.check_proof(scene, without).holds


@pytest.mark.parametrize("size", [0, *(pytest.param(size, marks=pytest.mark.slow) for size in (1, 2))])
def test_products_do_not_exclude_a_lower_state(size):
    """On a wall with a state at half the load factor of the default's first state, the bound stays below.

    The state at 16.471 is known from an independent program, see ``tests/analysis/low_states``.
    """
    scene = mo.load(FOLDER / "wall_13_joints.toml")
    problem = assemble(scene).problem
    high = mo.solve(scene, incremental=False, descent=False).required()
    assert high == pytest.approx(32.02475, rel=1e-5)
    chain = ProductChain(problem, Effort())
    for _ in range(2):
        chain.raise_bound(high, chain.selections[size], 60.0)
    least = mo.solve(scene).required()
    assert least == pytest.approx(16.47103, rel=1e-6)
    assert 0 < chain.bound <= least


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1_590_085, 8_460_020])
def test_both_kinds_of_proof_agree(seed):
    """The least load factor of a wall by products is that of a proof by conflicts alone."""
    scene = random_scene("wall", seed)
    problem = assemble(scene).problem
    without = replace(SETTINGS, most_products=0)
    by_conflicts = prove_least(Task(problem), None, 300.0, mo.solve(scene, "static").required(), without)
    early = replace(SETTINGS, first_products=1)
    answer = mo.solve(scene, incremental=False).solution.answer
    by_products = prove_least(Task(problem), answer, 300.0, settings=early)
    assert by_conflicts.proof is not None
    assert not by_conflicts.proof.relaxations
    assert by_products.proof is not None
    assert by_products.proof.relaxations
    assert by_products.best.load_factor == pytest.approx(by_conflicts.best.load_factor, rel=1e-6)


def test_the_forms_vanish_or_are_positive_in_an_exact_state():
    """In an exact state with cohesion and dilatancy, each form has the value that proofs rely on.

    Equations are zero, and edge forces, slacks, rates and openings are not negative.
    """
    wall = small_wall(3, 1)
    scene = wall.replace(joints=wall.joints.replace(cohesion=0.02, dilatancy=0.1))
    result = mo.solve(scene, incremental=False)
    problem, q, d = result.assembly.problem, result.q, result.d
    joints, load_factor = problem.joints, result.required()
    first, second, shear = q.reshape(3, -1)
    friction, cohesion = problem.friction, problem.cohesion
    edge_forces = np.stack([first, second, cohesion + friction * (first + second) - shear], axis=1)
    p = problem.rates(d, problem.dilatancy)
    rates = np.concatenate([2 * p[problem.table.rocks], p[problem.table.slides]]).reshape(4, -1).T
    statics = np.concatenate([edge_forces.ravel(), [load_factor, 1.0]])
    motion = np.concatenate([rates.ravel(), d, [1.0]])
    nothing = np.zeros((0, 2), dtype=int)
    limits = tuple(NormalLimit(j, 100.0, np.zeros(0), np.zeros(0)) for j in range(joints))
    empty = ProductRelaxation(0.0, 2 * load_factor, limits, nothing, nothing, np.zeros(0), np.zeros(0))
    checker = ProductChecker(problem, empty)

    def value(form: Mapping[int, Fraction], unknowns: np.ndarray) -> float:
        return sum(float(a) * unknowns[i] for i, a in form.items())

    for row in range(problem.B.shape[0]):
        assert value(checker._static_form("equilibrium", row), statics) == pytest.approx(0.0, abs=1e-8)
    for row in range(3 * joints):
        assert value(checker._kinematic_form("compatibility", row), motion) == pytest.approx(0.0, abs=1e-8)
    assert value(checker._kinematic_form("live work", 0), motion) == pytest.approx(0.0, abs=1e-8)
    for joint in range(joints):
        slack = value(checker._static_form("other slack", joint), statics)
        assert slack >= -1e-8
        assert slack * rates[joint, 3] == pytest.approx(0.0, abs=1e-8)
        for edge in range(2):
            assert value(checker._kinematic_form("opening", 4 * joint + edge), motion) >= -1e-8
    assert min(edge_forces.min(), rates.min()) >= -1e-8
    assert np.abs(edge_forces * rates[:, :3]).max() < 1e-8


def with_step(proof: Proof, change: Callable[[ProductRelaxation], dict[str, object]]) -> Proof:
    """Return the proof with fields of its first relaxation changed."""
    first, *others = proof.relaxations
    return replace(proof, relaxations=(replace(first, **change(first)), *others))


def with_limit(proof: Proof, value: Callable[[float], float]) -> Proof:
    """Return the proof with another limit on the normal force of the first joint."""
    limit, *others = proof.relaxations[0].limits
    return with_step(proof, lambda _: {"limits": (replace(limit, value=value(limit.value)), *others)})


def bent(values: np.ndarray) -> np.ndarray:
    """Return the values with every second one changed by a millionth."""
    return values * (1 + 1e-6 * (np.arange(len(values)) % 2))


def changed(values: np.ndarray, index: int, value: float) -> np.ndarray:
    """Return a copy of the values with another value at an index."""
    copy = values.copy()
    copy[index] = value
    return copy


def inequality(step: ProductRelaxation) -> int:
    """Return the position of the largest multiplier of a product that need not be zero."""
    rates = np.isin(step.kinematic[:, 0], [KINEMATIC_FACTORS.index(name) for name in ("one", "rate")])
    margins = np.isin(step.static[:, 0], [STATIC_FACTORS.index(name) for name in ("margin", "load margin")])
    return int(np.where(rates & margins, step.multipliers, 0.0).argmax())


#: Position of the kind "opening" among the kinematic forms.
OPENING = KINEMATIC_FACTORS.index("opening")

#: Names of the arrays of a relaxation.
ARRAYS = ("static", "kinematic", "multipliers", "corrections")

CORRUPTIONS: dict[str, tuple[Callable[[Proof], Proof], str]] = {
    "a higher bound": (
        lambda proof: replace(proof, bound=proof.bound * 1.01, load_factor=proof.load_factor * 1.02),
        "must start between",
    ),
    "a bound a little higher": (
        lambda proof: replace(proof, bound=proof.bound * 1.00001, load_factor=proof.load_factor * 1.00002),
        "satisfies all clauses",
    ),
    "a multiplier that is bent": (
        lambda proof: with_step(proof, lambda step: {"multipliers": bent(step.multipliers)}),
        "excludes no load factors beyond",
    ),
    "no corrections, and rounded multipliers": (
        lambda proof: with_step(
            proof,
            lambda step: {
                "multipliers": step.multipliers.astype(np.float32).astype(float),
                "corrections": np.zeros(len(step.multipliers)),
            },
        ),
        "excludes no load factors beyond",
    ),
    "half of the products": (
        lambda proof: with_step(
            proof,
            lambda step: {name: getattr(step, name)[::2] for name in ARRAYS},
        ),
        "excludes no load factors beyond",
    ),
    "a negative multiplier of an inequality": (
        lambda proof: with_step(
            proof, lambda step: {"multipliers": changed(step.multipliers, inequality(step), -1.0)}
        ),
        "can be negative",
    ),
    "a smaller limit of a normal force": (
        lambda proof: with_limit(proof, lambda value: 0.9 * value),
        "limit",
    ),
    "no limit for a joint": (
        lambda proof: with_step(proof, lambda step: {"limits": step.limits[1:]}),
        "are missing",
    ),
    "an unknown factor": (
        lambda proof: with_step(proof, lambda step: {"static": np.full_like(step.static, 99)}),
        "unknown factors",
    ),
    "a form that the scene does not have": (
        lambda proof: with_step(proof, lambda step: {"kinematic": step.kinematic + np.array([0, 10**6])}),
        "relaxation no. 1",
    ),
    "a static form that the scene does not have": (
        lambda proof: with_step(proof, lambda step: {"static": step.static + np.array([0, 10**6])}),
        "relaxation no. 1",
    ),
    "an opening that the scene does not have": (
        lambda proof: with_step(
            proof,
            lambda step: {
                "kinematic": np.full_like(step.kinematic, (KINEMATIC_FACTORS.index("opening"), 10**6))
            },
        ),
        "relaxation no. 1",
    ),
    "an excluded load factor that is no number": (
        lambda proof: replace(proof, excluded_by_products=float("nan")),
        "must be between 0 and the load factor",
    ),
    "an infinite excluded load factor": (
        lambda proof: replace(proof, excluded_by_products=float("inf")),
        "must be between 0 and the load factor",
    ),
    "a further relaxation that excludes nothing": (
        lambda proof: replace(proof, relaxations=(*proof.relaxations, *proof.relaxations)),
        "excludes no load factors beyond",
    ),
    "an interval above zero": (
        lambda proof: with_step(proof, lambda _: {"lowest": 0.1}),
        "must start between",
    ),
    "multipliers that are no numbers": (
        lambda proof: with_step(proof, lambda step: {"multipliers": step.multipliers * np.nan}),
        "not finite numbers",
    ),
    "no products": (
        lambda proof: replace(proof, relaxations=()),
        "the relaxations do not exclude all states up to",
    ),
}


def test_a_bound_at_the_least_load_factor_itself_is_not_proven():
    """A block on a rough base slides at λ = μ, so that a proof up to this load factor is wrong."""
    base = mo.Block(name="base", vertices=[(-2, -1), (3, -1), (3, 0), (-2, 0)], fixed=True)
    block = mo.Block(name="block", vertices=[(0, 0), (1, 0), (1, 1), (0, 1)], weight=1.0, live=(1.0, 0.0))
    problem = assemble(mo.Scene(joints=mo.JointDefaults(friction=0.5), blocks=[base, block])).problem
    chain = ProductChain(problem, Effort())
    chain.raise_bound(1.0, chain.selections[0], 10.0)
    assert chain.bound == pytest.approx(0.5, rel=1e-12)
    proof = chain.proof(1.0, chain.bound)
    assert proof.bound < chain.bound
    assert check(problem, proof).holds
    assert not check(problem, replace(proof, bound=0.5)).holds


#: Changes of the parsed contents of a file with a proof, each of which damages the file.
DAMAGES: dict[str, Callable[[dict[str, Any]], None]] = {
    "an excluded load factor that is text": lambda table: table.update(excluded_by_products="0.6 m"),
    "relaxations that are no list": lambda table: table.update(relaxations=3),
    "a relaxation without multipliers": lambda table: table["relaxations"][0].pop("multipliers"),
    "multipliers that are a number": lambda table: table["relaxations"][0].update(multipliers=1.0),
    "a limit that is no table": lambda table: table["relaxations"][0].update(limits=[1.0]),
    "a load factor with 400 digits": lambda table: table["relaxations"][0].update(highest=10**400),
    "factors that are text": lambda table: table["relaxations"][0].update(static="force"),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_a_damaged_file_is_refused(proven, tmp_path, name):
    table = json.loads(proven[1].to_json())
    DAMAGES[name](table)
    path = tmp_path / "proof.json"
    path.write_text(json.dumps(table))
    with pytest.raises(mo.CaseError, match="not a complete proof"):
        Proof.load(path)


@pytest.mark.parametrize("name", CORRUPTIONS)
def test_a_corrupted_proof_is_refused(proven, name):
    problem, proof = proven
    corrupt, word = CORRUPTIONS[name]
    found = check(problem, corrupt(proof))
    assert not found.holds
    assert word in found.faults[0]


def test_a_proof_of_another_scene_is_refused(proven):
    _, proof = proven
    scene = running_bond(2, 3)
    rougher = scene.replace(joints=scene.joints.replace(friction=0.6))
    assert not check(assemble(rougher).problem, proof).holds


def test_a_file_holds_the_products(proven, tmp_path):
    problem, proof = proven
    proof.save(tmp_path / "proof.json")
    again = Proof.load(tmp_path / "proof.json")
    assert again.to_json() == proof.to_json()
    assert check(problem, again).holds


def test_statics_that_do_not_limit_forces_prove_nothing():
    """A block that is clamped between two walls can carry any normal force, so no product is used."""
    blocks = [
        mo.Block(name="left", vertices=[(-1, 0), (0, 0), (0, 1), (-1, 1)], fixed=True),
        mo.Block(name="right", vertices=[(1, 0), (2, 0), (2, 1), (1, 1)], fixed=True),
        mo.Block(name="clamped", vertices=[(0, 0), (1, 0), (1, 1), (0, 1)], weight=1.0, live=(0.0, -1.0)),
    ]
    problem = assemble(mo.Scene(joints=mo.JointDefaults(friction=0.6), blocks=blocks)).problem
    chain = ProductChain(problem, Effort())
    selected = chain.selections[0]
    assert chain.raise_bound(1.0, selected, 60.0) is None
    assert (chain.bound, chain.steps) == (0.0, [])


@pytest.mark.slow
def test_the_clauses_of_a_result_with_products_are_searched_for(tmp_path):
    """A proof by products has no clauses, so that the export looks for a proof by conflicts."""
    result = mo.solve(running_bond(2, 3), "global", incremental=False)
    assert result.proof.relaxations
    assert result.bound == result.proof.bound
    with pytest.raises(mo.OptionError, match=r"mo\.prove_least\(scene, products=False\)"):
        result.proof.to_dimacs()
    mo.export(result, tmp_path / "bond.cnf")
    with Minisat22(bootstrap_with=CNF(str(tmp_path / "bond.cnf"))) as solver:
        assert solver.solve() is False
