"""Axles that move over a road, and the search for the position with the least load factor.

``least_associative`` proves a lower bound on the associative load factor along the whole road.
``least_coulomb`` searches with Coulomb methods, and proves no lower bound.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
import shapely

from masonry_opt.deadline import SAME_TIME, check_time
from masonry_opt.effort import Effort
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.fill import Road
from masonry_opt.problem.load_factor_scale import LoadFactorScale
from masonry_opt.problem.problem import Problem, ShearLimits, in_units_of_load
from masonry_opt.scene.loads import Load
from masonry_opt.scene.road import Axles, TravelDirection
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.answer import certified
from masonry_opt.solution.reasons import Code, Status, reason
from masonry_opt.solution.solution import Solution
from masonry_opt.solvers.highs import HighsSession
from masonry_opt.solvers.registry import Verdict

#: Function that returns the answer of a scene under a given live load, shape (3b,).
SolveLive = Callable[[np.ndarray], Solution]
#: If the loads on blocks jump at a position of the axles, both sides of the jump are evaluated. Their
#: distance from the jump is this fraction of the length of the road.
_BREAK_DISTANCE = 1e-9
#: The search tests if the loads on blocks are linear or parabolic functions of the position. Deviations up to
#: this fraction of the largest load count as rounding errors.
_LOAD_TOLERANCE = 1e-7
#: The search for the least load factor halves a range of positions only if it is longer than this fraction of
#: the distance from the first to the last position.
_SHORTEST_RANGE = 1e-4
#: Number of positions that a Coulomb method solves before it searches for the least load factor between them.
#: With more positions, fewer minima are missed.
_FIRST_POSITIONS = 25
#: Fraction by which estimates of λ between two solved positions are reduced, so that fewer minima are missed.
#: With a larger fraction, more positions are solved.
_RATIO_MARGIN = 0.005
#: Largest number of steps with which a Coulomb method refines the worst position of the axles, at which λ is
#: least. Each step solves the positions halfway between the worst position and its neighbours.
_MOST_HALVINGS = 10
#: A Coulomb method stops refining the worst position after a step in which the relative decrease of λ is less
#: than this fraction of the relative tolerance of λ.
_PROGRESS_SHARE = 0.1


@dataclass(frozen=True)
class Passage:
    """Passage of a group of axles over a road in one direction.

    The position of the group is the abscissa of its first axle.
    """

    axles: Axles  #: group of axles
    direction: TravelDirection  #: direction in which the axles travel, "left" or "right"
    assembly: Assembly  #: problem of the scene without the loads of the axles
    road: Road  #: road over which the axles travel

    @property
    def case(self) -> str | None:
        """Name of the load case; None if the scene has no load cases."""
        case = self.assembly.scene.load_case
        return case.name if case else None

    @property
    def case_factor(self) -> float:
        """Factor by which the load case multiplies the axle loads; 1 if the scene has no load cases."""
        return self.assembly.scene.factor_of_axles

    @property
    def across(self) -> float:
        """Fraction of the axle loads that the scene carries: thickness of the scene / effective width."""
        return self.assembly.scene.thickness / self.axles.width if self.axles.width else 1.0

    @cached_property
    def offsets(self) -> np.ndarray:
        """Abscissae of the axles relative to the first axle, shape (axles,)."""
        behind = np.cumsum([0.0, *self.axles.group.distances])[: len(self.axles.group.loads)]
        return self._forward * behind

    @cached_property
    def strips(self) -> np.ndarray:
        """Uniform loads, shape (n, 3): load, and abscissae of both ends relative to the first axle."""
        load, start, end = self.axles.strips.T
        ends = np.sort(self._forward * np.array([start, end]), axis=0)
        return np.column_stack([load, *ends])

    @property
    def _forward(self) -> float:
        """Sign of the direction from the first axle to the last: -1 if the axles travel to the right."""
        return -1.0 if self.direction == "right" else 1.0

    def live(self, position: float) -> np.ndarray:
        """Return the live load f_L, shape (3b,), with the axles at a position.

        The loads of the axles are multiplied by the factor of their load case, and added to the other live
        loads of the scene.
        """
        problem, movable = self.assembly.problem, self.assembly.movable
        forces = self.case_factor * self._on_blocks(position)[movable] / problem.force_unit
        forces[:, 2] /= problem.length_unit
        return problem.live + forces.ravel()

    def loaded(self, live: np.ndarray) -> Assembly:
        """Return a copy of the assembly with a given live load, shape (3b,)."""
        return replace(self.assembly, problem=replace(self.assembly.problem, live=live))

    def scene(self, position: float) -> Scene:
        """Return the scene in which the axles at a position are replaced by live loads on blocks."""
        scene, shapes = self.assembly.scene, self.assembly.geometry
        loads, group = list(scene.loads), None
        fields: dict[str, Any] = {"loads": loads, "axles": []}
        case = scene.load_case
        if case is not None:
            group = f"axles '{self.axles.name}'"
            live = {name: factor for name, factor in case.live.items() if name != "axles"}
            case = case.replace(live=live | {group: scene.factor_of_axles})
            fields["load_cases"] = [
                case if listed.name == case.name else listed for listed in scene.load_cases
            ]
        forces = self._on_blocks(position)
        for block in np.flatnonzero(forces[:, 1]):
            _, down, moment = forces[block]
            # The load is applied at the top of the block, on the vertical line of action of the axle forces.
            x = shapes.centroid[block, 0] + moment / down
            _, low, _, high = shapes.polygons[block].bounds
            line = shapely.linestrings([[x, low - 1.0], [x, high + 1.0]])
            section = shapely.intersection(shapes.polygons[block], line)
            point = np.array([x, high if section.is_empty else section.bounds[3]])
            if scene.settled is not None:
                point = scene.settled.at_rest(block, point)
            target = {"block": scene.blocks[block].name, "at": tuple(map(float, point + shapes.origin))}
            loads.append(Load(**target, live=(0.0, float(down)), group=group))
        return scene.replace(**fields).read_from(scene.origin).with_load_case(case)

    def pieces(self, longest: float) -> list[tuple[float, float]]:
        """Return ranges of positions, from left to right, within which the loads on blocks do not jump.

        The ranges are at most ``longest`` long. In each of them an axle loads a block that can move.
        """
        gap = _BREAK_DISTANCE * float(np.ptp(self.road.breaks))
        ends = np.r_[self.offsets, self.strips[:, 1:].ravel()]
        breaks = np.unique(self.road.breaks[:, None] - ends)
        ranges: list[tuple[float, float]] = []
        for start, end in zip(breaks[:-1] + gap, breaks[1:] - gap, strict=True):
            if end - start > gap:
                points = np.linspace(start, end, 1 + int(np.ceil((end - start) / longest)))
                ranges += pairwise(points.tolist())
        return [ends for ends in ranges if any(self.carried(x) for x in (*ends, sum(ends) / 2))]

    def carried(self, position: float) -> bool:
        """Return True if an axle at a position loads a movable block."""
        return bool(self._on_blocks(position).any())

    def _on_blocks(self, position: float) -> np.ndarray:
        """Return the force and moment of the axles on every block, shape (blocks, 3)."""
        across, (load, start, end) = self.across, self.strips.T
        forces = self.road.on_blocks(position + self.offsets, across * np.array(self.axles.group.loads))
        if not len(self.strips):
            return forces
        return forces + self.road.strips_on_blocks(position + start, position + end, across * load)


def load_factor(answer: Solution) -> float:
    """Return λ of an answer; inf if the scene carries any load, NaN if the answer is undecided."""
    if answer.load_factor is not None:
        return answer.load_factor
    return math.inf if answer.carries_any_load else math.nan


def moving_load(problem: Problem, effort: Effort) -> SolveLive:
    """Return a function that solves the static program, eq. (9), of a stable scene for any live load.

    The program is compiled only once, because another live load changes only the column of λ.
    """
    scaled = in_units_of_load(problem)
    # The import is local: all studies import this module, but only crossings with associative flow use CVXPY,
    # whose import takes a second.
    from masonry_opt.models.cvxpy_static import CvxpyStatic

    model = CvxpyStatic(scaled.problem, scaled.limits(ShearLimits.true(problem)))
    statics, program = model.statics, HighsSession(model.program, effort, "associative load factor")

    def solved(live: np.ndarray) -> Solution:
        """Solve the static program, eq. (9), for a live load of shape (3b,). Return the certified answer."""
        loaded = replace(problem, live=live)
        program.set_column(statics.load_factor, statics.equilibrium, live / loaded.live_norm)
        verdict = program.solve()
        solution = Solution(Status.OPTIMAL, Kind.ASSOCIATIVE, size=program.lp.size)
        if verdict is Verdict.OPTIMAL:
            q = scaled.force * program.values(statics.q)
            d = program.duals(statics.equilibrium)
            load_factor = scaled.force * float(program.values(statics.load_factor)[0]) / loaded.live_norm
            answer = certified(loaded, load_factor, q, d * loaded.live_norm / (live @ d), problem.friction)
            return replace(solution, state=answer).accepted()
        if verdict in (Verdict.UNBOUNDED, Verdict.INFEASIBLE_OR_UNBOUNDED):
            # The scene is stable, so λ = 0 is feasible. A program without an optimum is therefore unbounded.
            return solution.ended(Status.UNLIMITED, Code.NO_MECHANISM)
        return solution.ended(Status.SOLVER_FAILED, Code.SOLVER_STOPPED, word=verdict.value)

    return solved


#: Answer for a position at which no axle loads a movable block.
_UNLOADED = Solution(Status.UNLIMITED, Kind.ASSOCIATIVE, (reason(Code.NO_MECHANISM),))


@dataclass(eq=False)
class PassageTrials:
    """Answers of one method at positions of a passage. No position is solved twice.

    If a search is interrupted, the answers that it has found so far are still available.
    """

    passage: Passage  #: group of axles, direction and load case
    #: function that solves the scene under a live load; None after the search
    solve: SolveLive | None = field(repr=False)
    #: function that is called with each solved position and its λ
    progress: Callable[[float, float], None] | None = field(default=None, repr=False)
    #: Answers with associative flow for the same passage; None if the method itself is associative.
    associative_trials: "PassageTrials | None" = field(default=None, repr=False)
    bound: float | None = None  #: proven lower bound on λ at all positions; None if nothing is proven
    answers: dict[float, Solution] = field(default_factory=dict, repr=False)  #: answers by position

    def at(self, position: float) -> float:
        """Return λ with the axles at a position. The scene is solved only if no answer is stored.

        See ``load_factor`` for infinite and NaN values.

        Raises TimeLimitReached at the time limit, and KeyboardInterrupt if the user interrupted the search
        for a lower state at this position. An answer that is known by then is recorded.
        """
        if position not in self.answers:
            check_time()
            live = self.passage.live(position)
            answer = self.of(live) if live.any() else _UNLOADED
            if answer.status is Status.TIME_LIMIT:
                check_time(SAME_TIME)
            self.answers[position] = answer
            if self.progress:
                self.progress(position, load_factor(answer))
            if answer.interrupted and not answer.has(Code.TIME_LIMIT):
                raise KeyboardInterrupt
        return load_factor(self.answers[position])

    def of(self, live: np.ndarray) -> Solution:
        """Solve the scene under a live load, shape (3b,). Return the answer without recording it."""
        assert self.solve is not None
        return self.solve(live)

    def ended(self) -> "PassageTrials":
        """Return a copy without compiled programs, because they cannot be sent to other processes."""
        return replace(
            self,
            solve=None,
            progress=None,
            associative_trials=self.associative_trials and self.associative_trials.ended(),
        )

    @property
    def positions(self) -> np.ndarray:
        """Solved positions from left to right, shape (n,)."""
        return np.array(sorted(self.answers))

    @property
    def load_factors(self) -> np.ndarray:
        """λ at the solved positions, shape (n,).

        The value is inf if the scene carries any load at a position, and NaN if the position is undecided.
        """
        return np.array([self.at(position) for position in self.positions])

    @property
    def associative(self) -> "PassageTrials":
        """Answers with associative flow at the solved positions of the axles."""
        return self.associative_trials or self

    @property
    def resolution(self) -> float:
        """Distance from the worst position to the farther of the two solved positions next to it.

        A position just across a jump of the loads is ignored, because it nearly coincides with the worst
        position.
        """
        distances = self.positions - self.position
        distances = distances[np.abs(distances) > _SHORTEST_RANGE**2 * np.ptp(self.positions)]
        sides = distances[distances < 0], distances[distances > 0]
        return max((float(np.abs(side).min()) for side in sides if len(side)), default=0.0)

    @property
    def least(self) -> float:
        """Least load factor of all positions; inf if no position has a load factor."""
        return float(np.nanmin([*self.load_factors, math.inf]))

    @property
    def is_undecided(self) -> bool:
        """True if a position is undecided: λ is not known, and it is not proven that λ is unlimited."""
        return bool(np.isnan(self.load_factors).any())

    @property
    def position(self) -> float:
        """Position with the least load factor.

        Without a load factor it is the first undecided position. If no position is undecided, it is the first
        position at which an axle is on a block that can move.
        """
        if math.isfinite(self.least):
            return float(self.positions[np.nanargmin(self.load_factors)])
        if self.is_undecided:
            return float(self.positions[np.isnan(self.load_factors)][0])
        return next(filter(self.passage.carried, sorted(self.answers)), min(self.answers))


def least_associative(
    solved: PassageTrials, longest: float, within: float, required: float | None = None
) -> None:
    """Find the least associative load factor of a passage, with a proven lower bound.

    The method is branch and bound over ranges of positions. It relies on convexity: the loads that a stable
    scene carries form a convex set that contains zero. The reciprocal 1/λ is the gauge of this set, and
    therefore a convex function of the load that satisfies 1/λ(a + b) ≤ 1/λ(a) + 1/λ(b). Within a range:

    - If the loads follow a straight line, 1/λ is at most the greater of its values at both ends.
    - If the loads follow a parabola, they are convex combinations of three loads: the loads at both ends, and
      the load at which the tangents of the ends intersect. λ is computed for the third load too.
    - Loads that spread through fill deviate from a parabola. The deviation is a load of its own, and twice
      its 1/λ at a quarter of the range is added.

    A range whose bound is too low is halved. If one of the loads of a range has no answer, the range is not
    halved, because its parts may have no answer either. Then there is no proof.

    Parameters
    ----------
    solved: Answers with associative flow. Its ``bound`` is set, or None if nothing is proven.
    longest: Largest distance between solved positions.
    within: Relative distance of the bound from the least load factor.
    required: Required load factor. If it is between the bound and the least load factor, ranges are halved
        further. None if no load factor is required.
    """
    ranges = [(_needed(solved, *ends), *ends) for ends in solved.passage.pieces(longest)]
    shortest = _SHORTEST_RANGE * (ranges[-1][2] - ranges[0][1]) if ranges else 0.0
    bounds = []
    while ranges:
        greatest = max(map(_inverse, solved.load_factors))
        halves: list[tuple[float, float]] = []
        for inverse, start, end in ranges:
            is_low = inverse > greatest * (1 + within) or _is_between(required, inverse, greatest)
            if is_low and end - start > shortest:
                middle = (start + end) / 2
                halves += [(start, middle), (middle, end)]
            else:
                bounds.append(inverse)
        ranges = [(_needed(solved, *ends), *ends) for ends in halves]
    greatest_inverse = float(np.max(bounds, initial=0.0))  # NaN if any bound is NaN
    solved.bound = 1 / greatest_inverse if 0 < greatest_inverse < math.inf else None


def _is_between(required: float | None, inverse: float, greatest: float) -> bool:
    """Return True if a required load factor is between a lower bound and the least λ found.

    The lower bound is 1/``inverse``; the least λ found is 1/``greatest``. Differences within rounding errors
    do not count.
    """
    if required is None:
        return False
    scale = LoadFactorScale(min(1.0, required))
    if not inverse * required > 1 or scale.equal(1 / inverse, required):
        return False
    return greatest * required <= 1 or scale.equal(1 / greatest, required)


def _needed(solved: PassageTrials, start: float, end: float) -> float:
    """Return an upper bound on 1/λ between two positions; NaN if the bound cannot be computed.

    The formula of the bound is explained in :func:`least_associative`. The bound cannot be computed if a load
    factor in the formula is unknown.
    """
    positions = [start + share * (end - start) for share in (0.0, 0.25, 0.5, 1.0)]
    first, quarter, middle, last = map(solved.passage.live, positions)
    mean = (first + last) / 2
    # If the live load is a quadratic function of the position, its tangents at ``start`` and ``end``
    # intersect at the load ``corner``.
    corner = 2 * middle - mean
    deviation = quarter - (9 * first + 6 * corner + last) / 16
    rounding = _LOAD_TOLERANCE * np.abs(middle).max()
    load_factors = [solved.at(start), solved.at(end)]
    if np.abs(corner - mean).max() > rounding:
        load_factors.append(load_factor(solved.of(corner)))
    of_deviation = load_factor(solved.of(deviation)) if np.abs(deviation).max() > rounding else math.inf
    if any(math.isnan(value) for value in (*load_factors, of_deviation)):
        return math.nan
    return max(map(_inverse, load_factors)) + 2 * _inverse(of_deviation)


def _inverse(load_factor: float) -> float:
    """Return 1/λ, or 0 if λ is unknown or infinite."""
    return 1 / max(load_factor, 1e-300) if math.isfinite(load_factor) else 0.0


def least_coulomb(solved: PassageTrials, within: float) -> None:
    """Search for the position of the axles at which the load factor of a Coulomb method is least.

    The associative load factors of the passage must be known; they are upper bounds. The search proves no
    lower bound: at a position that was not solved, the load factor may be lower. The steps are:

    1. Solve the position with the least associative load factor, and a few evenly spread positions. The
       position with the least associative load factor comes first, because an interrupted search then has a
       low load factor already.
    2. Estimate λ at all other positions from the ratio λ / λ_associative of their solved neighbours. Solve
       the position with the lowest estimate as long as this estimate is below the least λ found.
    3. Solve positions halfway between the worst position and its neighbours, until λ hardly decreases.

    Parameters
    ----------
    solved: Answers of the method, to which the search adds.
    within: Relative tolerance of the least load factor.
    """
    at, associative = solved.associative.positions, solved.associative.load_factors
    spread = np.linspace(0, len(at) - 1, min(_FIRST_POSITIONS, len(at))).round().astype(int)
    least = [int(np.nanargmin(associative))] if np.isfinite(associative).any() else []
    for index in dict.fromkeys([*least, *spread.tolist()]):
        solved.at(float(at[index]))
    while True:
        load_factors = pd.Series({x: solved.at(x) for x in solved.answers}).reindex(at).to_numpy()
        estimates = (1 - _RATIO_MARGIN) * _estimates(associative, load_factors)
        estimates[np.isin(at, [*solved.answers])] = math.inf
        index = int(np.argmin(estimates))
        if estimates[index] >= np.nanmin(load_factors, initial=math.inf):
            break
        solved.at(float(at[index]))
    _halve(solved, at, within)


def _estimates(associative: np.ndarray, load_factors: np.ndarray) -> np.ndarray:
    """Return estimates of λ at all positions that were solved with associative flow, shape (n,).

    Estimates are more often too low than too high, so that few positions with a low λ are missed. An estimate
    is the associative load factor times a ratio: the lesser ratio λ / λ_associative of the two solved
    neighbours, reduced by half of the difference between both ratios. At positions at which the scene carries
    any load with associative flow, the estimate is the lesser λ of the neighbours.

    Parameters
    ----------
    associative: Associative load factors, shape (n,).
    load_factors: Known load factors, shape (n,); NaN at positions that are not solved.
    """
    upper, finite = pd.Series(associative), np.isfinite(associative)
    known = pd.DataFrame({"own": load_factors})
    ratio = (known["own"] / upper).where(finite & (associative > 0), 1.0)
    known["ratio"] = ratio.where(known["own"].notna())
    left, right = known.ffill().bfill(), known.bfill().ffill()
    lesser = np.minimum(left, right)
    ratio = lesser["ratio"] - (left["ratio"] - right["ratio"]).abs() / 2
    estimates = (upper * ratio.clip(upper=1.0)).where(finite, lesser["own"])
    return estimates.fillna(math.inf).to_numpy()


def _halve(solved: PassageTrials, at: np.ndarray, within: float) -> None:
    """Solve positions halfway between the worst position and its neighbours until λ hardly decreases."""
    for _ in range(_MOST_HALVINGS):
        load_factors = {x: solved.at(x) for x in solved.answers}
        decided = {x: value for x, value in load_factors.items() if math.isfinite(value)}
        if not decided:
            return
        worst = min(decided, key=decided.__getitem__)
        positions = np.union1d(at, [*solved.answers])
        index = int(np.searchsorted(positions, worst))
        neighbours = positions[max(index - 1, 0) : index + 2].tolist()
        halfway = [solved.at((worst + x) / 2) for x in neighbours if x != worst]
        if not any(value < decided[worst] * (1 - _PROGRESS_SHARE * within) for value in halfway):
            return
