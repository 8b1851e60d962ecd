"""The checker accepts a proof of the least load factor, and refuses corrupted proofs and damaged files."""

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from proofs import FOLDER, SECONDS, found_from_above
from pysat.solvers import Minisat22
from scenes import two_blocks

import masonry_opt as mo
from masonry_opt.methods.bounds.least import prove_least
from masonry_opt.methods.task import Task
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import Problem
from masonry_opt.proof_check import check
from masonry_opt.solution.proof import KinematicConflict, Proof, StaticConflict

#: The wall whose proof is corrupted. Its proof has 53 conflicts.
WALL = FOLDER / "wall_13_joints.toml"


@pytest.fixture(scope="module")
def proven() -> tuple[Problem, Proof]:
    scene = mo.load(WALL)
    return assemble(scene).problem, found_from_above(scene)[1]


def first_of(proof: Proof, kind: type) -> int:
    return next(index for index, one in enumerate(proof.conflicts) if isinstance(one, kind))


def with_conflict(proof: Proof, kind: type, change: Callable[[Any], dict[str, Any]]) -> Proof:
    """Return the proof with fields of its first conflict of a kind changed."""
    index, conflicts = first_of(proof, kind), list(proof.conflicts)
    conflicts[index] = replace(conflicts[index], **change(conflicts[index]))
    return replace(proof, conflicts=tuple(conflicts))


def bent(values: np.ndarray) -> np.ndarray:
    """Return the values with the largest one changed by a millionth."""
    changed = values.copy()
    changed[np.abs(values).argmax()] *= 1 + 1e-6
    return changed


CORRUPTIONS: dict[str, tuple[Callable[[Proof], Proof], str]] = {
    "a higher bound": (lambda proof: replace(proof, bound=proof.bound * 1.01), "not between"),
    "a higher bound and load factor": (
        lambda proof: replace(proof, bound=proof.bound * 1.01, load_factor=proof.load_factor * 1.02),
        "conflict no.",
    ),
    "a clause without one of its conditions": (
        lambda proof: with_conflict(proof, StaticConflict, lambda one: {"conditions": one.conditions[1:]}),
        "is negative, although",
    ),
    "a kinematic clause without one of its conditions": (
        lambda proof: with_conflict(proof, KinematicConflict, lambda one: {"conditions": one.conditions[1:]}),
        "too large for a proof",
    ),
    "a motion that is bent": (
        lambda proof: with_conflict(proof, StaticConflict, lambda one: {"d": bent(one.d)}),
        "too large for a proof",
    ),
    "forces that are bent": (
        lambda proof: with_conflict(proof, KinematicConflict, lambda one: {"q": bent(one.q)}),
        "too large for a proof",
    ),
    "multipliers turned around": (
        lambda proof: with_conflict(proof, StaticConflict, lambda one: {"d": -one.d, "p": -one.p}),
        "conflict no.",
    ),
    "a lower load factor among the multipliers": (
        lambda proof: with_conflict(
            proof, KinematicConflict, lambda one: {"load_factor": 0.99 * one.weight * proof.bound}
        ),
        "do not lead to a contradiction",
    ),
    "a negative weight": (
        lambda proof: with_conflict(proof, KinematicConflict, lambda _: {"weight": -1.0}),
        "multiplier of the energy balance is negative",
    ),
    "half of the conflicts": (
        lambda proof: replace(proof, conflicts=proof.conflicts[::2]),
        "satisfies all clauses",
    ),
    "more friction than is proven": (
        lambda proof: replace(
            proof,
            energy_bounds=(replace(proof.energy_bounds[0], value=2 * proof.energy_bounds[0].value + 1),),
        ),
        "energy bound",
    ),
    "senses that are none": (
        lambda proof: replace(proof, senses=np.array([[0, 1]])),
        "do not belong to the two opposite sliding directions of one joint",
    ),
    "multipliers that are no numbers": (
        lambda proof: with_conflict(proof, StaticConflict, lambda one: {"d": one.d * np.nan}),
        "not finite numbers",
    ),
    "a condition that does not exist": (
        lambda proof: with_conflict(proof, StaticConflict, lambda _: {"conditions": np.array([10**6])}),
        "does not have",
    ),
}


@pytest.mark.slow
def test_the_proof_holds_before_it_is_corrupted(proven):
    found = check(*proven)
    assert found.faults == ()
    assert "proven" in str(found)


@pytest.mark.slow
def test_a_proof_reaches_forces_and_rates_far_beyond_any_state():
    scene = mo.load(FOLDER / "stones_14_joints.toml")
    found = mo.check_proof(scene, found_from_above(scene)[1])
    assert found.faults == ()
    assert found.reach >= 1e7


@pytest.mark.parametrize("name", CORRUPTIONS)
def test_a_corrupted_proof_is_refused(proven, name):
    problem, proof = proven
    corrupt, word = CORRUPTIONS[name]
    found = check(problem, corrupt(proof))
    assert not found.holds
    assert word in found.faults[0]
    assert "does NOT hold" in str(found)


def test_a_result_without_a_proof():
    with pytest.raises(mo.OptionError, match=r"there is no proof to check: .*mo\.prove_least"):
        mo.check_proof(two_blocks(), mo.solve(two_blocks(), "static").proof)


def test_a_proof_of_another_scene_is_refused(proven):
    _, proof = proven
    heavier = mo.load(WALL).replace(blocks={"b0": {"weight": 3.4}})
    assert not check(assemble(heavier).problem, proof).holds
    assert not check(assemble(two_blocks()).problem, proof).holds


def test_a_file_holds_the_proof_digit_by_digit(proven, tmp_path):
    problem, proof = proven
    proof.save(tmp_path / "proof.json")
    again = Proof.load(tmp_path / "proof.json")
    assert again.to_json() == Proof.load(tmp_path / "proof.json").to_json()
    assert check(problem, again).holds
    assert len(again.conflicts) == len(proof.conflicts)
    assert again.bound == proof.bound
    table = json.loads((tmp_path / "proof.json").read_text())
    (tmp_path / "other.json").write_text(json.dumps(table | {"format": 0}))
    with pytest.raises(mo.CaseError, match="not a proof of format"):
        Proof.load(tmp_path / "other.json")


def test_a_file_of_the_user_is_not_replaced_by_a_proof(proven, tmp_path):
    _, proof = proven
    path = tmp_path / "mine.json"
    path.write_text('{"my": "data"}')
    with pytest.raises(mo.OptionError, match="exists already"):
        proof.save(path)
    assert path.read_text() == '{"my": "data"}'
    proof.save(path, force=True)
    proof.save(path)  # a file that this package wrote


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda table: table.pop("bound"), "key 'bound' is missing"),
        (lambda table: table.update(bound="x"), "a value is wrong"),
        (lambda table: table["static"][0].pop("p"), "a value is wrong"),
        (lambda table: table.update(senses=[[1]]), "a value is wrong"),
    ],
    ids=["no bound", "text as bound", "no multipliers", "half a pair"],
)
def test_a_damaged_file_is_an_error_that_names_it(proven, tmp_path, damage, message):
    table = json.loads(proven[1].to_json())
    damage(table)
    path = tmp_path / "damaged.json"
    path.write_text(json.dumps(table))
    with pytest.raises(
        mo.CaseError,
        match=rf"damaged\.json: the file is not a complete proof \({message}.*write the proof again",
    ):
        Proof.load(path)


def test_what_is_no_file_of_a_proof_is_an_error_that_names_it(tmp_path):
    (tmp_path / "text.json").write_text("proof")
    for name in ("text.json", "missing.json", "."):
        with pytest.raises(mo.CaseError, match=str(tmp_path / name)):
            Proof.load(tmp_path / name)


def test_another_solver_finds_the_exported_clauses_unsatisfiable(proven):
    """MiniSat, an independent solver, finds the exported clauses in DIMACS format unsatisfiable."""
    _, proof = proven
    lines = [line for line in proof.to_dimacs().splitlines() if not line.startswith("c")]
    kind, form, variables, count = lines[0].split()
    clauses = [[int(literal) for literal in line.split()] for line in lines[1:]]
    assert (kind, form, int(variables), int(count)) == ("p", "cnf", proof.conditions, len(clauses))
    assert all(clause[-1] == 0 and 0 not in clause[:-1] for clause in clauses)
    with Minisat22(bootstrap_with=[clause[:-1] for clause in clauses]) as solver:
        assert solver.solve() is False


@pytest.mark.slow
def test_the_least_state_violates_only_clauses_that_need_the_bound(proven):
    """Each clause that the least state violates is no contradiction at the load factor of this state.

    The least state is above the proven bound, so that it violates some clauses.
    """
    problem, proof = proven
    assert proof.bound < proof.load_factor
    known = prove_least(Task(problem), None, SECONDS, 1.5 * proof.load_factor).best
    assert known is not None
    moving = problem.rates(known.d, problem.dilatancy) > 1e-9
    violated = [
        one
        for one in proof.conflicts
        if not any(moving[abs(literal) - 1] == (literal > 0) for literal in one.clause)
    ]
    assert violated
    for one in violated:
        if isinstance(one, StaticConflict):
            # A negative gain contradicts no state.
            gain = problem.dead @ one.d - problem.face_cohesion @ one.p
            assert gain + min(0.0, known.load_factor * problem.live @ one.d) <= 1e-9
        else:
            assert one.load_factor <= one.weight * known.load_factor * (1 + 1e-9)
