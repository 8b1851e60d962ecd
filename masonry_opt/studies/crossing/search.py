"""A group of axles on its way over a road, and where the load factor is least: proven, or sought."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
import shapely

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import certified
from masonry_opt.answer.reasons import Code, Status, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.effort import Effort
from masonry_opt.models.cvxpy_static import CvxpyStatic
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.fill import Road
from masonry_opt.problem.problem import Problem, ShearLimits, in_units_of_load
from masonry_opt.scene.loads import Load
from masonry_opt.scene.road import Axles, TravelDirection
from masonry_opt.scene.scene import Scene
from masonry_opt.solvers.highs import HighsSession
from masonry_opt.solvers.registry import Verdict

SolveLive = Callable[[np.ndarray], Solution]  #: The answer under a live load, shape (3b,).
_BESIDE = 1e-9  #: Share of the road beside a break, at which loads may jump, where they are taken instead.
_ROUNDING = 1e-7  #: Share of the loads, by their largest entry, that is nothing.
_FINEST = 1e-4  #: Share of the way to which ranges are halved at most.
_FIRST = 25  #: Positions at which a Coulomb method is asked first.
#: How much less its share of the associative λ may be between two of these, beside half of their difference.
_MARGIN = 0.005
_ROUNDS = 10  #: Of halving beside the least.


@dataclass(frozen=True)
class Passage:
    """A group of axles that travels over a road in one direction. Its position is that of its first axle."""

    axles: Axles
    direction: TravelDirection
    assembly: Assembly
    road: Road

    @property
    def case(self) -> str | None:
        """Name of the load case, of a scene that has any."""
        case = self.assembly.scene.load_case
        return case.name if case else None

    @property
    def across(self) -> float:
        """Share of the loads that the scene carries."""
        return self.assembly.scene.thickness / self.axles.width if self.axles.width else 1.0

    @cached_property
    def offsets(self) -> np.ndarray:
        """Abscissae of the axles from the position, shape (axles,)."""
        behind = np.cumsum([0.0, *self.axles.group.distances])
        return -behind if self.direction == "right" else behind

    def live(self, position: float) -> np.ndarray:
        """Live load f_L of axles, by their load case's factor, and of what else is live, shape (3b,)."""
        problem, movable = self.assembly.problem, self.assembly.movable
        factor = self.assembly.scene.factor_of_axles
        forces = factor * self._on_blocks(position)[movable] / problem.force_unit
        forces[:, 2] /= problem.length_unit
        return problem.live + forces.ravel()

    def loaded(self, live: np.ndarray) -> Assembly:
        """The assembly with that live load."""
        return replace(self.assembly, problem=replace(self.assembly.problem, live=live))

    def scene(self, position: float) -> Scene:
        """The scene with the axles there as loads of its blocks, one a block, and none that move."""
        scene, shapes = self.assembly.scene, self.assembly.geometry
        loads, group = list(scene.loads), None
        changed: dict[str, Any] = {"loads": loads, "axles": []}
        if (case := scene.load_case) is not None:
            group = f"axles '{self.axles.name}'"
            live = {name: factor for name, factor in case.live.items() if name != "axles"}
            case = case.replace(live=live | {group: scene.factor_of_axles})
            changed["load_cases"] = [case if one.name == case.name else one for one in scene.load_cases]
        forces = self._on_blocks(position)
        for block in np.flatnonzero(forces[:, 1]):
            _, down, moment = forces[block]
            x = shapes.centroid[block, 0] + moment / down
            _, low, _, high = shapes.polygons[block].bounds
            line = shapely.linestrings([[x, low - 1.0], [x, high + 1.0]])
            met = shapely.intersection(shapes.polygons[block], line)
            at = np.array([x, high if met.is_empty else met.bounds[3]]) + shapes.origin
            where = {"block": scene.blocks[block].name, "at": tuple(map(float, at))}
            loads.append(Load(**where, live=(0.0, float(down)), group=group))
        return scene.replace(**changed).read_from(scene.called).with_load_case(case)

    def pieces(self, longest: float) -> list[tuple[float, float]]:
        """Ranges in which loads do not jump and some axle is on a movable block, from left to right."""
        beside = _BESIDE * float(np.ptp(self.road.breaks))
        breaks = np.unique(self.road.breaks[:, None] - self.offsets)
        found: list[tuple[float, float]] = []
        for start, end in zip(breaks[:-1] + beside, breaks[1:] - beside, strict=True):
            if end - start > beside:
                found += pairwise(np.linspace(start, end, 1 + int(np.ceil((end - start) / longest))).tolist())
        return [ends for ends in found if any(self.carried(x) for x in (*ends, sum(ends) / 2))]

    def carried(self, position: float) -> bool:
        """Whether any axle there loads a block that can move."""
        return bool(self._on_blocks(position).any())

    def _on_blocks(self, position: float) -> np.ndarray:
        return self.road.on_blocks(position + self.offsets, self.across * np.array(self.axles.group.loads))


def load_factor(answer: Solution) -> float:
    """λ; infinite where any load is carried, NaN where nothing is decided."""
    if answer.load_factor is not None:
        return answer.load_factor
    return math.inf if answer.carries_any_load else math.nan


def moving_load(problem: Problem, effort: Effort) -> SolveLive:
    """Eq. (9) of a scene that stands, compiled once: a new live load changes the column of λ alone."""
    scaled = in_units_of_load(problem)
    model = CvxpyStatic(scaled.problem, scaled.limits(ShearLimits.true(problem)))
    statics, program = model.statics, HighsSession(model.program, effort, "associative load factor")

    def solved(live: np.ndarray) -> Solution:
        """The associative answer under a live load, shape (3b,), certified by itself."""
        loaded = replace(problem, live=live)
        program.set_column(statics.load_factor, statics.equilibrium, live / loaded.live_norm)
        verdict = program.solve()
        solution = Solution(Status.OPTIMAL, Kind.ASSOCIATIVE, size=program.lp.size)
        if verdict is Verdict.OPTIMAL:
            q = scaled.force * program.values(statics.q)
            d = program.duals(statics.equilibrium)
            load_factor = scaled.force * float(program.values(statics.load_factor)[0]) / loaded.live_norm
            found = certified(loaded, load_factor, q, d * loaded.live_norm / (live @ d), problem.friction)
            return replace(solution, found=found).accepted()
        if verdict in (Verdict.UNBOUNDED, Verdict.INFEASIBLE_OR_UNBOUNDED):
            return solution.ended(Status.UNLIMITED, Code.NO_MECHANISM)  # it stands: it has a state, at λ = 0
        return solution.ended(Status.SOLVER_FAILED, Code.SOLVER_STOPPED, word=verdict.value)

    return solved


#: Of a position where no axle loads a block that can move.
_UNLOADED = Solution(Status.UNLIMITED, Kind.ASSOCIATIVE, (reason(Code.NO_MECHANISM),))


@dataclass(eq=False)
class PassageTrials:
    """A passage and its answers, each position solved once; whoever is interrupted finds them here."""

    passage: Passage
    solve: SolveLive | None = field(repr=False)  #: None once all are solved (see :meth:`ended`)
    progress: Callable[[float, float], None] | None = field(default=None, repr=False)  #: called with x and λ
    beside: "PassageTrials | None" = field(default=None, repr=False)  #: of associative flow, if these are not
    bound: float | None = None  #: what λ is nowhere below, proven; or None
    answers: dict[float, Solution] = field(default_factory=dict, repr=False)

    def at(self, position: float) -> float:
        """λ at a position."""
        if position not in self.answers:
            live = self.passage.live(position)
            self.answers[position] = self.of(live) if live.any() else _UNLOADED
            if self.progress:
                self.progress(position, load_factor(self.answers[position]))
        return load_factor(self.answers[position])

    def of(self, live: np.ndarray) -> Solution:
        """The answer under a live load, which is not kept."""
        assert self.solve is not None
        return self.solve(live)

    def ended(self) -> "PassageTrials":
        """The same without programs, which cannot be sent between processes."""
        return replace(self, solve=None, progress=None, beside=self.beside and self.beside.ended())

    @property
    def positions(self) -> np.ndarray:
        """Those solved, from left to right."""
        return np.array(sorted(self.answers))

    @property
    def load_factors(self) -> np.ndarray:
        """λ at these."""
        return np.array([self.at(position) for position in self.positions])

    @property
    def associative(self) -> "PassageTrials":
        return self.beside or self

    @property
    def resolution(self) -> float:
        """The larger distance to the next positions solved on either side, none across a jump."""
        aside = self.positions - self.position
        aside = aside[np.abs(aside) > _FINEST**2 * np.ptp(self.positions)]
        sides = aside[aside < 0], aside[aside > 0]
        return max((float(np.abs(side).min()) for side in sides if len(side)), default=0.0)

    @property
    def least(self) -> float:
        """The least load factor; infinite without one."""
        return float(np.nanmin([*self.load_factors, math.inf]))

    @property
    def position(self) -> float:
        """Where it is least, the first of several with an axle on a block that can move."""
        if math.isfinite(self.least):
            return float(self.positions[np.nanargmin(self.load_factors)])
        return next(filter(self.passage.carried, sorted(self.answers)), min(self.answers))


def least_associative(solved: PassageTrials, longest: float, within: float) -> None:
    """Look for the least associative load factor of a passage, and a bound no farther below it than
    ``within`` (relative), where there is one; positions solved are no farther apart than ``longest``.

    Loads that a standing scene carries are a convex set with zero in it: 1/λ, by which a load must shrink to
    lie in it, is a convex function of the load. Between two positions where loads follow a line, λ is
    therefore nowhere less than at the lesser end. Where they follow a parabola, they are means of the loads
    at both ends and of a third, where the tangents of the ends meet; λ of that is solved for too. What loads
    that spread leave of a parabola is a load itself: of sums of loads 1/λ is at most the sum, and it is taken
    as twice what it is at a quarter of the range. Ranges whose least may be too low are halved; not those of
    which a load has no answer, next to which there may be none either: then nothing is proven.
    """
    ranges = [(_needed(solved, *ends), *ends) for ends in solved.passage.pieces(longest)]
    finest = _FINEST * (ranges[-1][2] - ranges[0][1]) if ranges else 0.0
    done = []
    while ranges:
        greatest = max(map(_inverse, solved.load_factors))
        open_ = [one for one in ranges if one[0] > greatest * (1 + within) and one[2] - one[1] > finest]
        done += [one[0] for one in ranges if one not in open_]
        halves = [(start, (start + end) / 2, end) for _, start, end in open_]
        ranges = [(_needed(solved, *ends), *ends) for three in halves for ends in pairwise(three)]
    most = float(np.max(done, initial=0.0))  # NaN where any is
    solved.bound = 1 / most if 0 < most < math.inf else None


def _needed(solved: PassageTrials, start: float, end: float) -> float:
    """What 1/λ does not exceed between two positions; NaN where a load that says so has no answer."""
    positions = [start + share * (end - start) for share in (0.0, 0.25, 0.5, 1.0)]
    first, quarter, middle, last = map(solved.passage.live, positions)
    corner, mean = 2 * middle - (first + last) / 2, (first + last) / 2
    off = quarter - (9 * first + 6 * corner + last) / 16
    scale = _ROUNDING * np.abs(middle).max()
    found = [solved.at(start), solved.at(end)]
    if np.abs(corner - mean).max() > scale:
        found.append(load_factor(solved.of(corner)))
    beside = load_factor(solved.of(off)) if np.abs(off).max() > scale else math.inf
    if any(math.isnan(one) for one in (*found, beside)):
        return math.nan
    return max(_inverse(one) for one in found) + 2 * _inverse(beside)


def _inverse(known: float) -> float:
    """1/λ; 0 where λ is unknown or infinite."""
    return 1 / max(known, 1e-300) if math.isfinite(known) else 0.0


def least_coulomb(solved: PassageTrials, within: float) -> None:
    """Look for the least load factor of a method that nothing bounds from below. It is asked at a few
    positions, then wherever it could be least if its share of the associative load factor, known at all, were
    between two of them little less than at both; last beside the least. That is no proof."""
    at, most = solved.associative.positions, solved.associative.load_factors
    first = {*np.linspace(0, len(at) - 1, min(_FIRST, len(at))).round().astype(int).tolist()}
    if np.isfinite(most).any():
        first.add(int(np.nanargmin(most)))
    for index in sorted(first):
        solved.at(float(at[index]))
    while True:
        found = pd.Series({x: solved.at(x) for x in solved.answers}).reindex(at).to_numpy()
        may_be = (1 - _MARGIN) * _estimates(most, found)
        may_be[np.isin(at, [*solved.answers])] = math.inf
        index = int(np.argmin(may_be))
        if may_be[index] >= np.nanmin(found, initial=math.inf):
            break
        solved.at(float(at[index]))
    _halve(solved, at, within)


def _estimates(most: np.ndarray, found: np.ndarray) -> np.ndarray:
    """λ at each position if it has the lesser share of the associative one, ``most``, that its neighbours of
    known λ, ``found``, have, less half of what theirs differ."""
    of, finite = pd.Series(most), np.isfinite(most)
    known = pd.DataFrame({"own": found})
    known["share"] = (known["own"] / of).where(finite & (most > 0), 1.0).where(known["own"].notna())
    left, right = known.ffill().bfill(), known.bfill().ffill()
    lesser = np.minimum(left, right)
    share = lesser["share"] - (left["share"] - right["share"]).abs() / 2
    # Where associative flow carries any load, the neighbours' own.
    may_be = (of * share.clip(upper=1.0)).where(finite, lesser["own"])
    return may_be.fillna(math.inf).to_numpy()


def _halve(solved: PassageTrials, at: np.ndarray, within: float) -> None:
    """Ask between the least and the positions beside it, while that finds less."""
    for _ in range(_ROUNDS):
        decided = {x: found for x in solved.answers if math.isfinite(found := solved.at(x))}
        if not decided:
            return
        best = min(decided, key=decided.__getitem__)
        beside = np.union1d(at, [*solved.answers])
        index = int(np.searchsorted(beside, best))
        near = beside[max(index - 1, 0) : index + 2].tolist()
        lower = [solved.at((best + x) / 2) for x in near if x != best]
        if not any(value < decided[best] * (1 - within / 10) for value in lower):
            return
