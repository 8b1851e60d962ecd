"""The load that a scene bears as it is pushed from rest: it settles, then a live load grows with its
displacement until forces no longer change, on a ray.

On a ray blocks move on for ever: that is a collapse mechanism, and the state is exact.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np

from masonry_opt.answer.solution import GivingState
from masonry_opt.methods.push.blocks import Blocks
from masonry_opt.methods.push.laws import Law, compliance
from masonry_opt.methods.push.path import End, Event, Path
from masonry_opt.methods.push.settling import settling
from masonry_opt.problem.problem import Problem

#: Events of settling and of the push, each, at most.
EVENTS = 40_000

#: By how much limits are looser at random, over the largest dead load of a block, so that no two events
#: coincide. It is taken off at the end; the second where that leaves forces beyond limits.
NOISE = 1e-7, 1e-9

#: Forces beyond limits, over the same, that a state may have.
EXACT = 1e-9

#: Share by which λ falls and rises again above which it is told: of 51 random scenes where it does, contact
#: dynamics bring four down more than a tenth below the highest λ, three if lightly damped; of 58 others none.
#: And the share of the highest λ that it is to fall from, at least.
_DEEP, _TRIFLE = 0.1, 1e-2


class Ended(StrEnum):
    """How a push ends: on a ray on which the scene collapses, or friction jams, or the live load is drawn
    back; without a state under the dead load; before an end is found; in rounding."""

    RAY = "ray"
    JAM = "jam"
    BACK = "back"
    NOT_SETTLED = "not settled"
    BUDGET = "budget"
    LOST = "lost"


@dataclass(frozen=True)
class Pushed:
    """A push from rest.

    Attributes
    ----------
    ended: how.
    load_factor: λ at the ray; None where there is none.
    peak: largest λ on the way, to which a load comes that grows.
    q, d: forces, shape (3c + t,), and mechanism, shape (3b,), scaled so that f_L·d = Σ|f_L|, at the ray.
    settled: forces under the dead load, shape (3c + t,).
    beyond: largest force beyond a limit, in these and in q.
    settling, events: what was met, the first at tensions of bonds, the second at displacements.
    begun: u that the path was followed from, 0 at rest.
    """

    ended: Ended
    load_factor: float | None = None
    peak: float | None = None
    q: np.ndarray | None = None
    d: np.ndarray | None = None
    settled: np.ndarray | None = None
    beyond: float = 0.0
    settling: tuple[Event, ...] = ()
    events: tuple[Event, ...] = ()
    begun: float = 0.0

    @property
    def folds(self) -> int:
        """How often the displacement turned: at the last event too, from where on it grows on a ray."""
        ahead = [np.inf] if self.ended in (Ended.RAY, Ended.JAM) else []
        moves = np.diff([self.begun, *(event.at for event in self.events), *ahead])
        way = np.sign(moves[moves != 0])
        return int((way[1:] != way[:-1]).sum())

    @property
    def deep_fall(self) -> tuple[float, float] | None:
        """λ from which it first falls deep, to come higher later, and the largest share by which it does."""
        path = np.array([0.0, *(event.load_factor for event in self.events)])
        path = path[: path.argmax() + 1]
        path = path[np.maximum.accumulate(path) > _TRIFLE * path[-1]]
        highest = np.maximum.accumulate(path)
        deep = 1 - path / highest > _DEEP
        return (float(highest[deep.argmax()]), float((1 - path / highest).max())) if deep.any() else None


def push(problem: Problem, events: int = EVENTS, seed: int = 0) -> Pushed:
    """Settle and push a problem that the laws take, for so many events at most."""
    law = Law.of(problem, compliance(problem))
    noise = _noise(problem, law, seed)
    for share in NOISE:
        found = _pushed(problem, law, share * noise, events)
        if found.beyond <= EXACT * _unit(problem):
            return found
    return replace(found, ended=Ended.LOST)


def _pushed(problem: Problem, law: Law, noise: np.ndarray, most: int) -> Pushed:
    loose = law.loosened(noise)
    told: dict[str, Any] = {"settled": np.zeros(problem.B.shape[1])}
    if problem.settled is not None:
        told["settled"] = problem.settled
    elif problem.dead.any():
        path = settling(problem, loose)
        end = path.follow(-1, most)
        told["settling"] = tuple(path.events)
        if end is not End.FREE:
            ended = Ended.BUDGET if end is End.BUDGET else Ended.NOT_SETTLED
            return Pushed(ended, **told | {"settled": None})
        told["settled"] = law.of_problem(path.by(law).forces)
    rest, live = law.of_sliders(told["settled"]), problem.live / problem.live_norm
    still = np.zeros(problem.dead.size)
    path = Path(loose, Blocks(problem, law, live), rest, problem.dead, live, law.inside, still)
    return _ended(problem, law, path, path.follow(1, most), told)


def push_on(problem: Problem, state: GivingState, most: int) -> Pushed:
    """Go on from a state of contacts that give, at u = 1 / give, for so many events at most."""
    answer, giving, live = state.answer, state.problem, problem.live / problem.live_norm
    assert giving.compliance is not None
    law = Law.of(problem, giving.compliance / state.give)
    unit = _unit(problem)
    loose = law.loosened(NOISE[0] * _noise(problem, law))
    settled = np.zeros_like(answer.q) if giving.settled is None else giving.settled
    rest, d = law.of_sliders(settled), answer.d / state.give
    load = answer.load_factor * problem.live_norm
    path = Path(loose, Blocks(problem, law, live), rest, problem.dead, live, None, d, load, 1 / state.give)
    if not path.comes_into_its_cell():
        return Pushed(Ended.LOST)
    told = {"settled": settled, "begun": path.drive}
    found = _ended(problem, law, path, path.follow(1, most), told)
    return found if found.beyond <= EXACT * unit else replace(found, ended=Ended.LOST)


def _ended(problem: Problem, law: Law, path: Path, end: End, told: dict[str, Any]) -> Pushed:
    """What a path that has ended tells, beside what is told of how it began."""
    unit = problem.live_norm
    events = tuple(replace(event, load_factor=event.load_factor / unit) for event in path.events)
    told |= {"events": events, "beyond": _beyond(problem, told["settled"])}
    if path.highest is not None:
        told["peak"] = path.by(law, *path.highest[1:]).load_factor / unit
    if path.ahead is None:
        return Pushed(Ended.BUDGET, **told)
    along, drive = path.ahead
    if end is End.JAM:
        return Pushed(Ended.JAM if drive > 0 else Ended.BACK, **told)
    ray = path.by(law)
    told |= {"load_factor": ray.load_factor / unit, "q": law.of_problem(ray.forces)}
    told |= {"d": along / drive, "beyond": max(told["beyond"], _beyond(problem, told["q"]))}
    return Pushed(Ended.RAY if drive > 0 else Ended.BACK, **told)


def _unit(problem: Problem) -> float:
    """Largest load of a block."""
    return float(problem.force_sizes(problem.dead).max() or np.abs(problem.live).max())


def _noise(problem: Problem, law: Law, seed: int = 0) -> np.ndarray:
    """Random forces of half that size to all of it, shape (3, m)."""
    random: np.ndarray = np.random.default_rng(seed).uniform(0.5, 1, law.stiffness.shape)
    return _unit(problem) * random


def _beyond(problem: Problem, q: np.ndarray) -> float:
    """Largest force beyond a limit."""
    return max(0.0, -float((problem.slacks(q) / problem.steep).min()))
