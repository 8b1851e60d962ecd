"""Proofs of the least load factor by conflict learning.

Expected values come from an enumeration that shares no code with the search, from closed forms, and from
case files whose comments say how the values are known.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
from atlas.held_scenes import held
from atlas.random_scenes import random_scene
from highspy import Highs, HighsLp, HighsModelStatus, MatrixFormat
from mappings import mapped, mirrored
from proofs import FOLDER, SECONDS, associative, found_from_above
from scenes import CASES, small_wall, two_blocks
from scenes_in_space import corner_wall

import masonry_opt as mo
from masonry_opt.methods.bounds.least import LeastProof, prove_least
from masonry_opt.methods.bounds.settings import SETTINGS
from masonry_opt.methods.task import Task
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import Problem
from masonry_opt.proof_check import check

#: Scenes and their least load factors. The comment in each file says how the value is known.
LEAST = {"wall_13_joints": 16.4710309, "stones_14_joints": 2.3410936}

#: Relative tolerance of load factors: tolerances of the linear programs (1e-10) times their conditioning.
TOLERANCE = 1e-6


def program(A: np.ndarray, lower: np.ndarray, upper: np.ndarray, low: np.ndarray, cost: np.ndarray) -> Highs:
    """Return a linear program in HiGHS: min cost·x subject to lower ≤ A x ≤ upper and low ≤ x."""
    model = HighsLp()
    model.num_row_, model.num_col_ = A.shape
    model.row_lower_, model.row_upper_ = lower, upper
    model.col_lower_, model.col_upper_, model.col_cost_ = low, np.full(len(cost), np.inf), cost
    columns = sp.csc_array(A)
    model.a_matrix_.format_ = MatrixFormat.kColwise
    model.a_matrix_.start_, model.a_matrix_.index_ = columns.indptr, columns.indices
    model.a_matrix_.value_ = columns.data
    highs = Highs()
    highs.silent()
    highs.passModel(model)
    return highs


def is_feasible(highs: Highs) -> bool:
    """Solve a linear program, starting from its last basis. Return False if it is infeasible."""
    highs.run()
    status = highs.getModelStatus()
    if status == HighsModelStatus.kUnknown:
        highs.clearSolver()  # The last basis may have caused the failure.
        highs.run()
        status = highs.getModelStatus()
    assert status in (HighsModelStatus.kOptimal, HighsModelStatus.kInfeasible), status
    return bool(status == HighsModelStatus.kOptimal)


class Enumeration:
    """Enumeration of the conditions with a positive rate, for the least λ ≥ 0 of all collapse states.

    Every subset of conditions that may have a rate defines a pair of linear programs. The enumeration decides
    one condition after the other. It leaves a branch if a program is infeasible, or if the least λ of statics
    is not below the least known λ, because further decisions only add equations. It needs no multipliers.
    """

    def __init__(self, problem: Problem) -> None:
        faces, (height, width) = problem.faces, problem.B.shape
        self.faces, self.sliders, self.height = faces, len(problem.sliding), height
        self.at_yield = -problem.face_cohesion
        # The unknowns are the forces and λ. A condition with a rate is at yield.
        balance = np.hstack([problem.B.toarray(), problem.live[:, None]])
        law = np.hstack([problem.true_yield.toarray(), np.zeros((faces, 1))])
        self.statics = program(
            np.vstack([balance, law]),
            np.append(-problem.dead, self.at_yield),
            np.append(-problem.dead, np.full(faces, np.inf)),
            np.append(np.full(width, -np.inf), 0.0),
            np.eye(1, width + 1, width)[0],
        )
        # The unknowns are the displacements and the rates. A condition at rest has no rate.
        flow = np.hstack([problem.B.T.toarray(), -problem.D(problem.dilatancy).toarray()])
        work = np.append(np.zeros(width), problem.live_norm)
        self.motion = program(
            np.vstack([flow, np.append(problem.live, np.zeros(faces))]),
            work,
            work,
            np.append(np.full(height, -np.inf), np.zeros(faces)),
            np.zeros(height + faces),
        )

    def least(self) -> float:
        """Return the least load factor, or infinity if there is no state."""
        if not is_feasible(self.statics) or not is_feasible(self.motion):
            return np.inf
        return self._least(0, [], self.statics.getObjectiveValue(), np.inf)

    def _least(self, face: int, moving: list[int], load_factor: float, known: float) -> float:
        """Return the least λ of a branch, or ``known``. The conditions before ``face`` are decided."""
        if load_factor >= known:
            return known
        if face == self.faces:
            return load_factor
        if not (self.sliders <= face < 2 * self.sliders and face - self.sliders in moving):
            known = self._least_with_rate(face, moving, known)
        return self._least_at_rest(face, moving, load_factor, known)

    def _least_with_rate(self, face: int, moving: list[int], known: float) -> float:
        row, at_yield = self.height + face, self.at_yield[face]
        self.statics.changeRowBounds(row, at_yield, at_yield)
        if is_feasible(self.statics):
            load_factor = self.statics.getObjectiveValue()
            known = self._least(face + 1, [*moving, face], load_factor, known)
        self.statics.changeRowBounds(row, at_yield, np.inf)
        return known

    def _least_at_rest(self, face: int, moving: list[int], load_factor: float, known: float) -> float:
        column = self.height + face
        self.motion.changeColBounds(column, 0.0, 0.0)
        if is_feasible(self.motion):
            known = self._least(face + 1, moving, load_factor, known)
        self.motion.changeColBounds(column, 0.0, np.inf)
        return known


@pytest.mark.slow
@pytest.mark.parametrize("name", LEAST)
def test_the_least_load_factor_is_found_and_proven_from_above(name):
    scene = mo.load(FOLDER / f"{name}.toml")
    best, proof = found_from_above(scene)
    assert best.load_factor == pytest.approx(LEAST[name], rel=TOLERANCE)
    assert best.exact
    assert proof.bound == pytest.approx(LEAST[name] * (1 - SETTINGS.gap), rel=TOLERANCE)
    assert mo.check_proof(scene, proof).holds


@pytest.mark.slow
@pytest.mark.parametrize("name", LEAST)
def test_orders_and_mirror_images_lead_to_the_same_least_load_factor(name):
    scene = mo.load(FOLDER / f"{name}.toml")
    orders = [np.random.default_rng(seed).permutation(len(scene.blocks)) for seed in range(2)]
    for other in (mapped(scene, mirrored, mirrored), *(mapped(scene, order=order) for order in orders)):
        best, proof = found_from_above(other)
        assert best.load_factor == pytest.approx(LEAST[name], rel=TOLERANCE)
        assert check(assemble(other).problem, proof).holds


def test_a_closed_form_is_proven():
    """The least load factor of the two blocks of Fig. 6 of the paper is proven: λ = 0.15 by hand."""
    best, proof = found_from_above(two_blocks())
    assert best.load_factor == pytest.approx(0.15, rel=1e-9)
    assert 0.15 * (1 - 2 * SETTINGS.gap) <= proof.bound < 0.15


#: Scenes with 5 and 6 joints, from seeds that were not used to choose settings. From the third scene on, the
#: Coulomb load factor is 2 to 78 % below the associative one.
ENUMERATED = [
    ("stack", 1_590_001),
    ("tessellation", 1_590_909),
    *(("arch", seed) for seed in (1_590_125, 1_590_561, 1_590_875, 1_591_046, 1_591_184)),
    *(("tessellation", seed) for seed in (1_591_012, 1_591_255)),
]


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), ENUMERATED)
def test_enumeration_of_all_choices_agrees(kind, seed):
    scene = random_scene(kind, seed)
    best, _ = found_from_above(scene)
    assert best.load_factor == pytest.approx(Enumeration(assemble(scene).problem).least(), rel=1e-5)


def test_enumeration_agrees_where_the_flow_rule_matters():
    """The enumeration finds 0.15 for the two blocks, whose associative load factor is 0.25, to 1e-6."""
    problem = assemble(two_blocks()).problem
    assert Enumeration(problem).least() == pytest.approx(0.15, rel=1e-6)


def with_joints(scene: mo.Scene, **properties: Any) -> mo.Scene:
    own = scene.joints.model_dump(exclude_unset=True) | properties
    return scene.replace(joints=mo.JointDefaults(**own))


@pytest.mark.parametrize("properties", [{"dilatancy": 0.1}, {"dilatancy": -0.2}, {"cohesion": 0.05}], ids=str)
def test_dilatancy_and_cohesion_are_proven(properties):
    scene = with_joints(two_blocks(friction=0.3), **properties)
    best, proof = found_from_above(scene)
    assert best.exact
    assert best.load_factor <= mo.solve(scene).required() * (1 + TOLERANCE)
    assert check(assemble(scene).problem, proof).holds


@pytest.mark.slow
def test_ties_are_proven():
    """On a wall with a rod and props, the proof's search ends at the default's load factor, to 1e-6."""
    scene = held("wall", 1_480_103, space=False)
    best, proof = found_from_above(scene)
    assert best.load_factor == pytest.approx(mo.solve(scene).required(), rel=TOLERANCE)
    assert check(assemble(scene).problem, proof).holds


@pytest.mark.slow
def test_limited_strength_is_proven():
    scene = with_joints(two_blocks(), strength=50.0)
    best, proof = found_from_above(scene)
    assert best.load_factor <= mo.solve(scene).required() * (1 + TOLERANCE)
    assert check(assemble(scene).problem, proof).holds


def test_components_that_carry_no_live_load_change_nothing():
    scene = two_blocks()
    far = mo.Block(name="far", vertices=[(20, 0), (21, 0), (21, 1), (20, 1)], weight=3)
    ground = mo.Block(name="far ground", vertices=[(19, -1), (22, -1), (22, 0), (19, 0)], fixed=True)
    best, _ = found_from_above(scene.replace(blocks=[*scene.blocks, far, ground]))
    assert best.load_factor == pytest.approx(0.15, rel=1e-9)


def test_scenes_in_space_are_refused_by_name():
    search = prove_least(Task(assemble(corner_wall(2, 2, 2)).problem), None, SECONDS, 1.0)
    assert search.proof is None
    assert "space" in search.why


def test_time_that_is_over_leaves_no_proof():
    scene = mo.load(FOLDER / "stones_14_joints.toml")
    search = prove_least(Task(assemble(scene).problem), None, 1e-9, associative(scene))
    assert search.proof is None
    assert "did not end within" in search.why


def test_a_number_of_programs_ends_a_search():
    scene = mo.load(FOLDER / "stones_14_joints.toml")
    few = replace(SETTINGS, most_programs=50)
    search = prove_least(Task(assemble(scene).problem), None, SECONDS, associative(scene), few)
    assert search.proof is None
    assert "50 linear programs" in search.why
    assert search.programs == 50


@pytest.mark.parametrize("most", [0, 3, 51, 52, 53, 200])
def test_the_limit_of_programs_is_exact(most):
    """Energy bounds, shorter clauses and attempts to find a state are within the limit too.

    The search can be continued afterwards.
    """
    scene = mo.load(FOLDER / "stones_14_joints.toml")
    search = LeastProof(Task(assemble(scene).problem), None, associative(scene))
    assert not search.run(SECONDS, most)
    assert search.programs == most
    assert not search.run(SECONDS, 10)
    assert search.programs == most + 10


def test_joints_that_create_energy_are_refused_by_name():
    problem = assemble(two_blocks()).problem
    law = replace(problem.law, dilatancy=problem.friction + 0.1)
    search = prove_least(Task(replace(problem, law=law)), None, SECONDS, 1.0)
    assert search.proof is None
    assert "create energy" in search.why


def test_dilatancy_that_depends_on_stress_is_refused_by_name():
    scene = with_joints(two_blocks(), dilatancy=0.1, dilatancy_stress=(0.1, 1.0))
    search = prove_least(Task(assemble(scene).problem), None, SECONDS, 1.0)
    assert search.proof is None
    assert "depends on stress" in search.why


def test_load_factors_of_zero_and_below_are_refused_by_name():
    search = prove_least(Task(assemble(two_blocks()).problem), None, SECONDS, -0.5)
    assert search.proof is None
    assert "zero or less" in search.why
    nothing = prove_least(Task(assemble(two_blocks()).problem), None, SECONDS)
    assert "neither an exact state nor an upper bound" in nothing.why


def test_an_interrupt_ends_the_search(monkeypatch):
    scene = mo.load(FOLDER / "wall_13_joints.toml")

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("masonry_opt.methods.bounds.search.ConflictSearch._refuted", interrupted)
    with pytest.raises(KeyboardInterrupt):
        prove_least(Task(assemble(scene).problem), None, SECONDS, associative(scene))


def test_the_search_lowers_a_known_state_and_proves_the_lower_one():
    scene = mo.load(FOLDER / "wall_13_joints.toml")
    high = mo.solve(scene, incremental=False, descent=False)
    assert high.required() == pytest.approx(32.02475, rel=1e-5)
    found = prove_least(Task(assemble(scene).problem), high.solution.answer, SECONDS)
    assert found.proof is not None
    assert found.best is not None
    assert found.proof.load_factor == found.best.load_factor
    assert found.best.load_factor == pytest.approx(LEAST["wall_13_joints"], rel=TOLERANCE)
    assert found.programs > 0


def test_a_scene_is_proven_for_users():
    found = mo.prove_least(FOLDER / "wall_13_joints.toml")
    assert found.load_factor == pytest.approx(LEAST["wall_13_joints"], rel=TOLERANCE)
    assert found.proof is not None
    assert "is the least load factor, proven by" in str(found)
    assert mo.check_proof(FOLDER / "wall_13_joints.toml", found.proof).holds
    with pytest.raises(mo.OptionError, match="seconds must be a positive number"):
        mo.prove_least(FOLDER / "wall_13_joints.toml", seconds=0)


@pytest.mark.slow
def test_users_read_why_there_is_no_proof(no_proof):
    found = mo.prove_least(corner_wall(2, 2, 2))
    assert found.proof is None
    assert "not proven to be the least: proofs exist only for scenes in the plane" in str(found)
    late = mo.prove_least(FOLDER / "stones_14_joints.toml", seconds=1e-9)
    assert late.proof is None
    assert "did not end within" in str(late)


@pytest.mark.slow
@pytest.mark.parametrize(("courses", "least"), [(4, 0.479263), (6, 0.338028)])
def test_running_bonds_are_proven_where_global_closes_under_assumed_rates(courses, least):
    """The least load factors of two running bonds are those of method "global" in benchmarks/README.md."""
    best, proof = found_from_above(small_wall(courses, 1))
    assert best.load_factor == pytest.approx(least, abs=1e-6)
    assert proof.bound == pytest.approx(least, rel=2e-5)


@pytest.mark.parametrize("case", ["gilbert/two_blocks.toml", "livesley/wedges.toml"])
def test_method_global_proves_the_same_load_factors(case):
    best, proof = found_from_above(mo.load(CASES / case))
    bracket = mo.solve(CASES / case, "global", incremental=False)
    assert bracket.status is mo.Status.OPTIMAL
    assert best.load_factor == pytest.approx(bracket.required(), rel=TOLERANCE)
    assert proof.bound == pytest.approx(bracket.bound, rel=2 * SETTINGS.gap)


@pytest.mark.parametrize(
    "seed",
    [1_590_085, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1_590_068, 1_590_072))],
)
def test_no_proof_excludes_the_lowest_state_of_the_default(seed):
    """The default tries no proof on these walls of 16, 18 and 26 joints, so its state is independent of one.

    On the wall of 16 joints, the Coulomb load factor is 18 % below the associative one.
    """
    scene = random_scene("wall", seed)
    _, proof = found_from_above(scene)
    result = mo.solve(scene, incremental=False)
    assert "proof of the least" not in [entry.step for entry in result.solution.log]
    assert result.proof is None
    assert proof.bound < result.required()
