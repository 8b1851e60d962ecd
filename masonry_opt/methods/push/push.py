"""The load that a scene bears as it is pushed from rest: it settles, then a live load grows with its displacement
until forces no longer change, on a ray.

On a ray blocks move on for ever: that is a collapse mechanism, and the state is exact.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from math import inf
from time import perf_counter

import numpy as np

from masonry_opt.methods.push.laws import Law, compliance
from masonry_opt.methods.push.path import Blocks, End, Event, Path
from masonry_opt.methods.push.settling import settling
from masonry_opt.problem.problem import Problem

#: Events of settling and of the push, each, at most.
EVENTS = 40_000

#: Random forces that contacts give from, over the largest dead load of a block: no two events coincide. They are
#: taken off at the end. The next where that leaves a state that is none.
NOISE = 1e-7, 1e-9

#: Violation of yield, over the same, that a state may have.
EXACT = 1e-9


class Ended(StrEnum):
    """How a push ends."""

    RAY = "ray"
    JAM = "jam"
    NOT_SETTLED = "not settled"
    BUDGET = "budget"


@dataclass(frozen=True)
class Pushed:
    """A push from rest.

    Attributes
    ----------
    ended: on a ray on which forces stay (collapse) or grow (friction jams), before it, or before it began.
    load_factor: λ at the ray; None where there is none.
    peak: largest λ on the way.
    q, d: forces, shape (3c + t,), and mechanism, shape (3b,), scaled so that f_L·d = Σ|f_L|.
    settled: forces under the dead load, shape (3c + t,).
    violation: of the laws by these forces.
    settling, events: what was met.
    seconds: taken.
    """

    ended: Ended
    load_factor: float | None = None
    peak: float | None = None
    q: np.ndarray | None = None
    d: np.ndarray | None = None
    settled: np.ndarray | None = None
    violation: float = inf
    settling: tuple[Event, ...] = ()
    events: tuple[Event, ...] = ()
    seconds: float = 0.0

    @property
    def folds(self) -> int:
        """How often u turned."""
        u = np.diff([0.0, *(event.at for event in self.events)])
        way = np.sign(u[u != 0])
        return int((way[1:] != way[:-1]).sum())


def push(problem: Problem, events: int = EVENTS, seconds: float = inf) -> Pushed:
    """Settle and push a problem that the laws take, for so many events or seconds at most."""
    began, law = perf_counter(), Law.of(problem, compliance(problem))
    unit = float(problem.force_sizes(problem.dead).max() or np.abs(problem.live).max())
    rng, until = np.random.default_rng(0), began + seconds
    noise = rng.choice([-1, 1], len(law.stiffness)) * rng.uniform(0.5, 1, len(law.stiffness))
    for share in NOISE:
        found = _pushed(problem, law, share * unit * noise, unit, events, until)
        if found.ended is Ended.BUDGET or found.violation <= EXACT * unit:
            break
    return replace(found, seconds=perf_counter() - began)


def _pushed(
    problem: Problem, law: Law, noise: np.ndarray, unit: float, events: int, until: float
) -> Pushed:
    settled, settling_events, violation = np.zeros(len(noise)), (), 0.0
    if problem.dead.any():
        path = settling(problem, law, noise)
        end = path.follow(-1, 0.0, events, until)
        settling_events = tuple(path.events)
        if end is not End.THERE:
            ended = Ended.BUDGET if end is End.BUDGET else Ended.NOT_SETTLED
            return Pushed(ended, settling=settling_events, violation=0.0)
        settled = path.without(np.zeros(len(noise)), problem.dead)[0]
        violation = violated(problem, settled)
    rest = pressed_a_little(law, settled, noise, unit)
    held = law.response(law.cell(rest), rest, 0.0).q
    live = problem.live / problem.live_norm
    blocks, still = Blocks(problem.matrices, live), np.zeros(problem.dead.size)
    path = Path(law, blocks, rest, -(problem.B @ held), live, law.cell(rest), still, 0.0, 0.0)
    end = path.follow(1, inf, events, until)
    told = {
        "peak": path.peak / problem.live_norm,
        "settled": settled,
        "settling": settling_events,
        "events": tuple(path.events),
    }
    if end is End.BUDGET:
        return Pushed(Ended.BUDGET, **told)
    if end is End.JAM:
        return Pushed(Ended.JAM, violation=violation, **told)
    q, load = path.without(settled, problem.dead)
    along, drive = path.ahead
    d = along[:-1] / (live @ along[:-1])
    return Pushed(
        Ended.RAY,
        load_factor=load / problem.live_norm,
        q=q,
        d=d,
        violation=max(violation, violated(problem, q)),
        **told,
    )


def violated(problem: Problem, q: np.ndarray) -> float:
    """Largest violation of yield, as a force."""
    return max(0.0, -float((problem.slacks(q) / problem.steep).min()))


def pressed_a_little(law: Law, settled: np.ndarray, noise: np.ndarray, unit: float) -> np.ndarray:
    """Forces that contacts give from, a little inside of all limits."""
    normal, shear, T = law.parts(settled)
    more, along, of_limited = law.parts(noise)
    inside = shear * (1 - np.abs(along) / unit) + np.minimum(law.friction, 1) * along / 2
    return np.concatenate([(normal + np.abs(more)).ravel(), inside, T])
