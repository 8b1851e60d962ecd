"""The proof of the least load factor as a step of the default method, and in turns with its search.

The comments in the case files say how the expected load factors are known.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from atlas.random_scenes import random_scene
from mappings import mapped, mirrored
from scenes import CASES, solved, two_blocks

import masonry_opt as mo
from masonry_opt.methods.bounds.least import LeastProof
from masonry_opt.methods.bounds.settings import BUDGET, SETTINGS, ProofBudget
from masonry_opt.methods.coulomb import method
from masonry_opt.methods.coulomb.run import LowestState, with_proof
from masonry_opt.methods.coulomb.steps import ExactFrom, Incremental, LeastProven
from masonry_opt.methods.exact.search import Search
from masonry_opt.methods.incremental.analysis import analysis_of
from masonry_opt.methods.task import Task
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.load_factor_scale import LoadFactorScale
from masonry_opt.solution.reasons import Code

FOLDER = Path(__file__).parent / "low_states"
WALL = FOLDER / "wall_13_joints.toml"
STONES = FOLDER / "stones_14_joints.toml"

#: Least load factors of the scenes. The comment in each file says how the value is known.
LEAST = {WALL: 16.4710309, STONES: 2.3410936}

#: Relative tolerance of load factors: tolerances of the linear programs (1e-10) times their conditioning.
TOLERANCE = 1e-6


def assert_proven(result: mo.Result, least: float) -> None:
    assert result.load_factor == pytest.approx(least, rel=TOLERANCE)
    assert result.exact
    assert result.range == (result.bound, result.load_factor)
    assert result.bound == pytest.approx(least * (1 - SETTINGS.gap), rel=TOLERANCE)
    assert "least, proven" in result.summary


def in_order(path: Path, seed: int) -> mo.Scene:
    """Return a scene with its blocks in a random order."""
    scene = mo.load(path)
    return mapped(scene, order=np.random.default_rng(seed).permutation(len(scene.blocks)))


@pytest.mark.slow
@pytest.mark.parametrize("path", LEAST, ids=lambda path: path.stem)
@pytest.mark.parametrize("seed", range(2))
def test_any_order_of_blocks_ends_at_the_least(path, seed):
    assert_proven(mo.solve(in_order(path, seed), incremental=False), LEAST[path])


@pytest.mark.slow
@pytest.mark.parametrize("path", LEAST, ids=lambda path: path.stem)
def test_a_mirror_image_ends_at_the_least(path):
    image = mapped(mo.load(path), mirrored, mirrored)
    result = mo.solve(image, incremental=False)
    assert_proven(result, LEAST[path])
    assert mo.check_proof(image, result.proof).holds


@pytest.mark.slow
def test_blocks_with_other_names_end_at_the_least(tmp_path):
    text = STONES.read_text()
    for number in range(8):
        text = text.replace(f'"b{number}"', f'"stone {7 - number}"')
    renamed = tmp_path / "renamed.toml"
    renamed.write_text(text)
    assert_proven(mo.solve(renamed, incremental=False), LEAST[STONES])


def test_the_proof_finds_a_state_that_no_start_led_to(monkeypatch):
    """The proof finds the least state of a wall that ends at 32.025 without further starts."""
    monkeypatch.setattr(method, "STEPS", (Incremental(), ExactFrom("incremental"), LeastProven()))
    result = mo.solve(WALL, incremental=False)
    before, after = result.solution.log[-2:]
    assert before.load_factor == pytest.approx(32.02475, rel=1e-5)
    assert after.load_factor == result.load_factor
    assert after.exact_states == before.exact_states + 1
    assert_proven(result, LEAST[WALL])


def test_a_budget_that_is_spent_leaves_the_lowest_found(monkeypatch):
    steps = (Incremental(), ExactFrom("incremental"), LeastProven())
    monkeypatch.setattr(method, "STEPS", steps)
    result = mo.solve(STONES, incremental=False, budget=replace(BUDGET, programs=20))
    assert result.bound is None
    assert "lowest found" in result.summary
    assert not result.solution.has(Code.PROVEN)
    assert "not proven by" in result.solution.log[-1].note


def test_a_proof_is_tried_by_default_on_scenes_with_few_joints():
    problem = assemble(mo.load(STONES)).problem
    budget = ProofBudget(few_joints=problem.joints, few_redundant_forces=0)
    assert budget.tries_by_default(problem)
    assert budget.covers(problem)
    assert not replace(budget, few_joints=problem.joints - 1).tries_by_default(problem)
    assert replace(budget, few_joints=problem.joints - 1).covers(problem)
    assert not replace(budget, most_joints=problem.joints - 1).covers(problem)
    assert not budget.covers(replace(problem, settled=np.zeros(problem.B.shape[1])))


def test_a_proof_is_tried_by_default_on_an_arch_with_any_number_of_joints():
    """A proof is tried on an arch of 28 joints, because only 3 of its 84 forces are redundant.

    It has 81 equations of equilibrium.
    """
    problem = assemble(mo.load(CASES / "casapulla_lauro" / "arch.toml")).problem
    assert problem.joints > BUDGET.few_joints
    assert BUDGET.tries_by_default(problem)
    assert not replace(BUDGET, few_redundant_forces=2).tries_by_default(problem)


@pytest.mark.slow
def test_a_search_takes_turns_with_the_proof(monkeypatch):
    """A search with a limit of ten minutes ends as soon as the least load factor is proven."""
    monkeypatch.setattr(method, "STEPS", (Incremental(), ExactFrom("incremental")))
    budget = replace(BUDGET, first_turn=100)
    result = mo.solve(STONES, incremental=False, search=600.0, budget=budget)
    assert_proven(result, LEAST[STONES])
    assert sum(result.seconds.values()) < 60


def test_a_search_goes_on_from_a_state_of_the_proof(monkeypatch):
    """A search whose starts all lead to 32.025 takes over the lower state that the proof finds."""

    def first_again(starts, best, _):
        while True:
            yield "again", starts.start(best.q)

    monkeypatch.setattr(Search, "endless", first_again)
    monkeypatch.setattr(method, "STEPS", (Incremental(), ExactFrom("incremental")))
    result = mo.solve(WALL, incremental=False, search=600.0, budget=replace(BUDGET, first_turn=50))
    assert set(result.history["origin"]) == {"start", "proof"}
    assert_proven(result, LEAST[WALL])


def test_a_search_after_a_proof_ends_at_once():
    result = mo.solve(two_blocks(), incremental=False, search=600.0)
    assert_proven(result, 0.15)
    assert len(result.history) == 1


@pytest.mark.slow
def test_a_proof_that_is_interrupted_goes_on_with_its_clauses():
    """A proof in turns of 100 programs needs at most twice as many programs as a proof in a single run."""
    problem, known = assemble(mo.load(STONES)).problem, solved(STONES).solution.answer
    at_once, in_turns = (LeastProof(Task(problem), known, None) for _ in range(2))
    assert at_once.run(60.0, 100_000)
    turns = 1
    while not in_turns.run(60.0, 100):
        turns += 1
    assert turns > 2
    assert in_turns.proof is not None
    assert in_turns.programs <= 2 * at_once.programs
    assert mo.check_proof(STONES, in_turns.proof).holds


@pytest.mark.slow
def test_a_proof_for_another_load_factor_is_not_attached():
    """A proof is attached only to the solution from whose load factor its search started."""
    solution = solved(STONES).solution
    own, other = solution.proof, solved(WALL).solution.proof
    assert own is not None
    assert other is not None
    unproven = replace(solution, proof=None, bound=None, reasons=())
    assert with_proof(unproven, own, LoadFactorScale()).has(Code.PROVEN)
    assert with_proof(unproven, other, LoadFactorScale()) == unproven
    assert with_proof(unproven, None, LoadFactorScale()) == unproven


@pytest.mark.slow
def test_a_start_after_the_proof_may_lead_lower():
    """A start after a proof without result may lead to a state below the lowest state so far."""
    high, low = (mo.solve(STONES, **how).solution.answer for how in ({"descent": False}, {}))
    assert high.load_factor > low.load_factor + 0.1
    task = Task(assemble(mo.load(STONES)).problem)
    states = LowestState(task, analysis_of(task))
    states.lower_to(high)
    assert states.answer.load_factor == high.load_factor
    states.near(low)
    assert states.answer.load_factor == pytest.approx(low.load_factor, rel=TOLERANCE)


@pytest.mark.slow
def test_the_budget_does_not_depend_on_runs_before():
    """The programs of earlier runs in a study, which are counted together, do not reduce the budget."""
    problem = assemble(random_scene("wall", 2_830_000)).problem
    ends = []
    for solved_before in (0, 100_000):
        task = Task(problem)
        task.effort.lp_solves = solved_before
        log = method.coulomb(task).log
        ends.append((task.effort.lp_solves - solved_before, [entry.note for entry in log]))
    assert ends[0] == ends[1]
