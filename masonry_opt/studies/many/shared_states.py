"""Exact Coulomb states that the runs of a study share.

The runs of a sweep or sample often differ only in limits: the strength of a tie, or the friction of joints.
An exact state found in one run is also a state of every other run whose limits it respects. For example, a
tie that carries 17 kN of its strength of 20 kN can carry 17 kN with a strength of 30 kN too. Each run
searches independently and may miss a state of another run. :func:`shared_answers` therefore certifies lower
states of other runs by the matrices of each run.
"""

import base64
import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import numpy as np

from masonry_opt.problem.assembly import Assembly, assemble, on_matrices_of
from masonry_opt.problem.load_factor_scale import LoadFactorScale
from masonry_opt.problem.problem import Problem
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.acceptance import LIMITS, Kind
from masonry_opt.solution.answer import Answer, certified
from masonry_opt.solution.reasons import Status
from masonry_opt.solution.solution import Solution

#: Exact states of scenes with more joints (in space: contact points) than this number are not recorded for
#: other runs, because each state needs more than 150 kB in the journal and in memory.
RECORDED_UP_TO = 3000

#: The quick test of states of other runs multiplies the limits of residuals by this factor. With a smaller
#: factor, the test may exclude valid states. With a larger factor, more invalid states pass the test, and
#: computing their certificates takes time.
MARGIN = 10.0

Row = Mapping[str, Any]  #: Row of a run by column name, including the columns of :func:`recorded_state`.


class FoundState(NamedTuple):
    """Exact collapse state, and the run in which the state was found."""

    run: int  #: index of the run
    load_factor: float  #: λ
    q: np.ndarray  #: joint forces, shape (3c + t,)
    d: np.ndarray  #: block velocities, shape (3b,)


class SharedAnswer(NamedTuple):
    """Exact collapse state of one run that replaces the answer of another run."""

    run: int  #: index of the run whose answer the state replaces
    found_in: int  #: index of the run that found the state
    answer: Answer  #: the state, certified for the problem of the run with index ``run``
    assembly: Assembly  #: assembly of the scene of ``run``


def recorded_state(problem: Problem, solution: Solution) -> dict[str, str]:
    """Return the exact state of a run as text columns for the journal, so that other runs can use the state.

    - ``balance``: a hash of the equilibrium matrix and the loads. Runs with equal hashes may share states.
      The hash is missing if no state of another run can be the answer, for example because the scene is
      unstable under its dead load or is proven to carry any load.
    - ``forces``, ``velocities``: the exact state that the run found, if it found one.
    """
    may_take_states = solution.load_factor is not None or solution.status in (
        Status.SOLVER_FAILED,
        Status.BELOW_ZERO,
    )
    if not may_take_states or solution.carries_any_load or problem.dilatancy_depends_on_stress:
        return {}
    if problem.joints > RECORDED_UP_TO:
        return {}
    record = {"balance": _balance_hash(problem)}
    if solution.answer is not None and solution.is_exact(problem):
        record |= {"forces": _as_text(solution.answer.q), "velocities": _as_text(solution.answer.d)}
    return record


def shared_answers(rows: Sequence[Row], make: Callable[[int], Scene]) -> Iterator[SharedAnswer]:
    """Generate a new answer for each run whose answer is improved by a state of another run.

    The new answer is a state with a lower load factor or, if the run has no answer, any state. It is
    certified as exact by the matrices and limits of the run whose answer it replaces. If several states are
    certified, the lowest is yielded. The answers do not depend on the order in which runs ended.

    Parameters
    ----------
    rows: One row per run, with its ``load_factor`` and the entries of :func:`recorded_state`.
    make: Function that returns the scene of a run by its index.
    """
    groups: dict[str, list[int]] = {}
    for index, row in enumerate(rows):
        if row.get("balance"):
            groups.setdefault(row["balance"], []).append(index)
    for runs in groups.values():
        states = [_found_state(rows[index], index) for index in runs if rows[index].get("forces")]
        states.sort(key=lambda state: (state.load_factor, state.run))
        last: Assembly | None = None
        screen: Screen | None = None
        for index in runs:
            lower = [state for state in states if _improves(state, rows[index])]
            if not lower:
                continue
            scene = make(index)
            reused = None if last is None else on_matrices_of(last, scene)
            last = reused or assemble(scene)
            screen = screen or Screen.of(last.problem, states)
            for state in screen.possible(last.problem, lower):
                answer = _certified_by(last.problem, state)
                if answer is not None:
                    yield SharedAnswer(index, state.run, answer, last)
                    break


@dataclass(frozen=True)
class Screen:
    """Quick test that excludes those states of other runs whose certificates would fail.

    A sample of 1000 runs has 500,000 pairs of a state and a run, and a certificate takes about a millisecond.
    The quick test checks necessary conditions of the certificate for all states at once.
    """

    #: Map from the index of the run that found a state to the row of the state in ``n``, ``s``, ``slip`` and
    #: ``limited``.
    row: dict[int, int]
    n: np.ndarray  #: normal force of each joint in each state, shape (states, c)
    s: np.ndarray  #: magnitude of the shear force of each joint in each state, shape (states, c)
    #: Slip rate of each joint in each state, divided by the power of the live load, shape (states, c).
    slip: np.ndarray
    limited: np.ndarray  #: limited forces (of ties, props and earth) in each state, shape (states, t)

    @classmethod
    def of(cls, problem: Problem, states: Sequence[FoundState]) -> Self:
        """Return a quick test that shows which states cannot be exact in another run.

        The problems of all runs have equal matrices and loads, but may have different limits on forces.
        ``problem`` is the problem of any of these runs.
        """
        power = np.array([abs(problem.live @ state.d) for state in states])
        slips = np.array([problem.slip_speed(state.d) for state in states])
        return cls(
            row={state.run: row for row, state in enumerate(states)},
            n=np.array([problem.normal_forces(state.q) for state in states]),
            s=np.array([np.hypot.reduce(problem.shears(state.q), axis=0) for state in states]),
            slip=slips / np.maximum(power, np.finfo(float).tiny)[:, None],
            limited=np.array([problem.of_forces(state.q) for state in states]),
        )

    def possible(self, problem: Problem, states: Sequence[FoundState]) -> list[FoundState]:
        """Return the states that may be exact states of a problem, in their original order.

        States that exceed the limit on a force, or have joints that slide below their shear limit, are
        excluded.
        """
        rows = [self.row[state.run] for state in states]
        most = LIMITS[Kind.EXACT]
        slack = problem.cohesion + problem.friction * self.n[rows][:, problem.sliding]
        slack -= self.s[rows][:, problem.sliding]
        wasted = self.slip[rows][:, problem.sliding] * slack / np.maximum(problem.friction, 1.0)
        load_factors = np.array([state.load_factor for state in states])
        energy = wasted.sum(axis=1) / np.maximum(np.abs(load_factors), problem.load_factor_scale.divisor(0.0))
        within = (slack >= -MARGIN * most.yield_).all(axis=1) & (energy <= MARGIN * most.complementarity)
        within &= (self.limited[rows] <= problem.highest + MARGIN * most.yield_).all(axis=1)
        within &= (self.limited[rows] >= problem.lowest - MARGIN * most.yield_).all(axis=1)
        return [state for state, passes in zip(states, within, strict=True) if passes]


def _improves(state: FoundState, row: Row) -> bool:
    """Return True if a state improves the answer of a run: its λ is lower, or the run has no answer."""
    load_factor = row["load_factor"]
    if load_factor is None:
        return True
    return LoadFactorScale().is_distinctly_lower(state.load_factor, load_factor)


def _certified_by(problem: Problem, state: FoundState) -> Answer | None:
    """Return a state with its certificate for a problem, or None if the state is not exact in the problem."""
    problem = problem.by_cone
    answer = certified(problem, state.load_factor, state.q, state.d, problem.dilatancy)
    return answer if answer.exact else None


def _found_state(row: Row, index: int) -> FoundState:
    """Return the exact state that is recorded in the row of a run."""
    return FoundState(index, row["load_factor"], _as_array(row["forces"]), _as_array(row["velocities"]))


def _balance_hash(problem: Problem) -> str:
    """Return a hash of the equilibrium matrix, the loads and the units of force and length."""
    B = problem.B
    content = hashlib.sha256(repr((B.shape, problem.force_unit, problem.length_unit)).encode())
    for part in (B.indptr, B.indices, B.data, problem.dead, problem.live):
        content.update(np.ascontiguousarray(part).tobytes())
    return content.hexdigest()[:16]


def _as_text(values: np.ndarray) -> str:
    """Return the exact bytes of an array of numbers as text, for a journal."""
    return base64.b64encode(values.astype("<f8").tobytes()).decode("ascii")


def _as_array(text: str) -> np.ndarray:
    """Return the array of numbers that ``_as_text`` wrote."""
    return np.frombuffer(base64.b64decode(text), "<f8").astype(float)
