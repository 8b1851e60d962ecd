"""Function ``crossing``: the load factor of a scene by the position of axles, and the worst position."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from masonry_opt.analysis import Session, prepare
from masonry_opt.deadline import TimeLimitReached, limited, unlimited
from masonry_opt.effort import Effort, Phases, ignore_progress, phases_from
from masonry_opt.errors import MasonryError, TimeLimitError, counted
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.problem.settled import Movements
from masonry_opt.reporting.sentences import numeral, sentences
from masonry_opt.result import Result
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.road import Axles
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.reasons import Code, Status
from masonry_opt.solution.sense import warnings_of
from masonry_opt.studies.crossing import search
from masonry_opt.studies.crossing.answer import Crossing
from masonry_opt.studies.crossing.assessment import refuse_required_factor
from masonry_opt.studies.crossing.passages import AxlesArgument, passages_of
from masonry_opt.studies.crossing.text import WITHIN

#: Largest distance between neighbouring solved positions of a crossing, relative to the length of the road.
#: If the distance is larger, positions in between are solved too.
_LONGEST_RANGE = 0.01


def crossing(
    scene: Scene | str | Path,
    axles: str | Axles | Sequence[Axles] | None = None,
    *,
    method: str = DEFAULT,
    load_case: str | None = None,
    settled: Movements | None = None,
    required_factor: float | None = None,
    progress: Callable[[float, float], None] = ignore_progress,
    **options: Any,
) -> Crossing:
    """Move axles over a scene in the plane and find the position with the least load factor.

    The load factor multiplies the vertical loads of the axles, and the other live loads of the scene. Axles
    have no load beyond the ends of the road, over supports and over empty space. A group of axles that is not
    symmetric crosses in both directions, unless its key ``travels`` names one direction.

    With associative flow (methods "static" and "kinematic") the least load factor is proven, also between
    the solved positions. Other methods solve the positions at which the associative load factor, an upper
    bound, suggests the least λ. This search is no proof. After Ctrl-C, or at the time limit, the worst
    position solved so far is returned.

    If the scene has load cases, the axles cross in each load case whose ``live`` names "axles", at equal
    positions, and the least load factor governs. If a load case is unstable under its dead loads, its result
    is returned.

    Parameters
    ----------
    scene: A scene, or the path of a case file.
    axles: A group of axles, a list of groups, or the name of a group of the scene. Default: all groups of
        the scene.
    method, options: As for :func:`~masonry_opt.solve`, including ``model``, ``solver``, ... The
        incremental load factor is computed only at the worst position. The ``time_limit`` applies to the
        whole crossing. The function ``phases`` is called only during the first solve of each load case.
    load_case: Name of the only load case in which the axles cross. Default: all load cases that name
        "axles". The factor of a load case multiplies the axles and the other live loads.
    settled: Movement of supports before the axles cross, by name, as for
        :func:`~masonry_opt.solve`.
    required_factor: Load factor that the scene must reach. The answer then states whether the scene passed,
        and ``passed`` is True or False. An associative method solves more positions until its proven lower
        bound decides.
    progress: Function called with each solved position and its load factor (inf if any load is carried, NaN
        if the load factor is unknown).

    Returns
    -------
    Crossing
        The worst position with its result, and the load factors of all solved positions.

    Raises
    ------
    CaseError
        If the case file or the scene is wrong; if it has no axles or no road; if the road runs through a
        block, or over no block that can move; if no load case has axles.
    OptionError
        If a method, an option, the required load factor or the name of a group is wrong, or if the blocks of
        the scene are solids.
    TimeLimitError
        If the time limit is over before any position is solved. The message states the least associative
        load factor so far, if there is one.
    KeyboardInterrupt
        If the crossing was interrupted before any position was solved. Its text also states the least
        associative load factor so far, if there is one.
    """
    refuse_required_factor(required_factor)
    phases = phases_from(options)
    session = prepare(method, function=crossing, **options)
    scene = as_scene(scene, load_case)
    questions = Questions(required_factor, other_methods=True)
    crossed = cross(
        session, scene, axles, settled=settled, questions=questions, progress=progress, phases=phases
    )
    return replace(crossed, required_factor=required_factor)


class Questions(NamedTuple):
    """Results that a user requests from a crossing in addition to the least load factor."""

    #: Required load factor, or None. An associative method solves more positions until λ and its proven lower
    #: bound decide if the crossing reaches the required load factor.
    required_factor: float | None = None
    #: True if other methods also solve the worst position: see :func:`_other_methods`.
    other_methods: bool = False


_NO_QUESTIONS = Questions()  #: Default: a crossing computes only the least load factor.


def cross(
    session: Session,
    scene: Scene,
    axles: AxlesArgument = None,
    *,
    settled: Movements | None = None,
    questions: Questions = _NO_QUESTIONS,
    progress: Callable[[float, float], None] = ignore_progress,
    phases: Phases = ignore_progress,
) -> Crossing:
    """Move axles over a scene, solve it by the method of a session, and return the answer.

    ``questions`` selects additional results. See :func:`crossing` for the other parameters, the answer and
    the errors.
    """
    scene.in_plane()  # raises OptionError for solids
    with limited(session.how.time_limit):
        try:
            return _crossed(session, scene, axles, settled, questions, progress, phases)
        except TimeLimitReached as stop:
            raise _time_is_over(scene, stop, "no position of the axles was solved") from None


def _crossed(
    session: Session,
    scene: Scene,
    axles: AxlesArgument,
    settled: Movements | None,
    questions: Questions,
    progress: Callable[[float, float], None],
    phases: Phases,
) -> Crossing:
    """Return the answer of :func:`cross`. The caller sets the time limit.

    Raises TimeLimitReached if the time limit is over before the axles move.
    """
    directions, left_out = passages_of(scene, axles, settled)
    cases = tuple(passage.case for passage in directions[0] if passage.case)
    answer = partial(Crossing, cases=cases, left_out=left_out)
    firsts, stop = _solve_first_positions(session, directions[0], phases)
    if firsts and not _carries_dead_load(firsts[-1].result):
        return answer(worst=firsts[-1].result, passages=())
    if stop is not None:
        if all(first.trials.is_undecided for first in firsts):
            raise _without_positions(session, [search.PassageTrials(directions[0][0], None)], stop)
        worst_first = min(firsts, key=lambda first: (first.trials.least, not first.trials.is_undecided))
        passages = tuple(first.trials for first in firsts)
        return answer(worst=worst_first.result, passages=passages, **_ended_by(stop))
    effort = Effort()
    programs: dict[str | None, search.SolveLive] = {}
    for passage, first in zip(directions[0], firsts, strict=True):
        loaded = passage.loaded(passage.live(first.trials.position))
        programs[passage.case] = search.moving_load(loaded.problem, effort)
    all_trials, stop = _cross(session, directions, programs, effort, progress, questions.required_factor)
    # If no passage has a load factor, every passage is either undecided or carries an unlimited load. An
    # undecided passage then counts as the worst.
    worst = min(all_trials, key=lambda trials: (trials.least, not trials.is_undecided))
    result, stop = _worst_result(session, worst, effort, stop)
    results: dict[str, Any] = {}
    if questions.other_methods and stop is None:
        results = _other_methods(session, result, worst)
    return answer(worst=result, passages=tuple(all_trials), **results, **_ended_by(stop))


def _ended_by(stop: KeyboardInterrupt | None) -> dict[str, Any]:
    """Return ``interrupted`` and ``time_limit``, the fields that state if a crossing ended early.

    ``stop`` is the exception by which the user or the time limit ended the crossing, or None.
    """
    seconds = stop.seconds if isinstance(stop, TimeLimitReached) else None
    return {"interrupted": stop is not None, "time_limit": seconds}


class _FirstPosition(NamedTuple):
    """Results for the first axle position that is solved in a load case."""

    trials: search.PassageTrials  #: record of solved positions, with only the first position
    result: Result  #: result at the first position


def _solve_first_positions(
    session: Session, passages: list[search.Passage], phases: Phases
) -> tuple[list[_FirstPosition], KeyboardInterrupt | None]:
    """Solve each load case once, with the axles at a position at which they load a movable block.

    Returns the answers, and the exception that ended the solves.

    After a load case that is not known to carry its dead load, no further load case is solved. The exception
    is None unless the user or the time limit ended the solves. A solve that ended without answer is left out.
    """
    firsts: list[_FirstPosition] = []
    for passage in passages:
        position = _first_loaded(passage)
        try:
            result = session.solve(passage.scene(position), ignore_progress, Effort(phases))
        except TimeLimitError:
            return firsts, _limit_of(session)
        except KeyboardInterrupt as caught:
            return firsts, caught
        # The search with a Coulomb method also needs associative load factors. They are computed later, so
        # their record is still empty here.
        bounds = None if session.method.associative else search.PassageTrials(passage, None)
        answers = {position: result.solution}
        trials = search.PassageTrials(passage, None, associative_trials=bounds, answers=answers)
        stop = _stop_of(session, result)
        if stop is None or not trials.is_undecided:
            firsts.append(_FirstPosition(trials, result))
        if stop is not None or not _carries_dead_load(result):
            return firsts, stop
    return firsts, None


def _carries_dead_load(result: Result) -> bool:
    """Return True if a scene is known to be stable under its dead load."""
    undecided = any(reason.code is Code.DEAD_LOAD_UNDECIDED for reason in result.reasons)
    return not undecided and result.status is not Status.UNSTABLE


def _limit_of(session: Session) -> TimeLimitReached:
    """Return the exception for a session whose time limit has passed."""
    assert session.how.time_limit is not None
    return TimeLimitReached(session.how.time_limit)


def _stop_of(session: Session, result: Result) -> KeyboardInterrupt | None:
    """Return the exception if the user or the session's time limit has stopped a solve, or None.

    A method may have a time limit of its own. This limit does not end a crossing.
    """
    if result.time_limit_reached:
        return None if session.how.time_limit is None else _limit_of(session)
    return KeyboardInterrupt() if result.solution.interrupted else None


def _worst_result(
    session: Session, worst: search.PassageTrials, effort: Effort, stop: KeyboardInterrupt | None
) -> tuple[Result, KeyboardInterrupt | None]:
    """Return the result at the worst position, and the exception that ended the crossing, if any.

    The worst position is solved once more, for the incremental load factor. If the user or the time limit
    ends this solve, or if the time limit has ended the search before, the answer of the search is the result.
    """
    scene = worst.passage.scene(worst.position)
    try:
        if isinstance(stop, TimeLimitReached):
            raise stop
        result = session.solve(scene)
        if session.how.time_limit is None or not result.time_limit_reached:
            return result, stop
        stop = _limit_of(session)
    except TimeLimitError:
        stop = _limit_of(session)
    except KeyboardInterrupt as caught:
        stop = caught
    assembly = replace(worst.passage.loaded(worst.passage.live(worst.position)), scene=scene)
    return session.result(assembly, worst.answers[worst.position], effort), stop


def _time_is_over(
    scene: Scene, stop: TimeLimitReached, known: str, warnings: tuple[str, ...] = ()
) -> TimeLimitError:
    """Return the error to raise if the time limit ends a crossing; ``known`` states the results so far."""
    return TimeLimitError(
        f"{scene.origin}: the {stop} ended the crossing: {known}; raise the time limit", warnings
    )


def _first_loaded(passage: search.Passage) -> float:
    """Return a position at which an axle loads a movable block."""
    ranges = np.array(passage.pieces(_longest_range(passage)))
    return next(x for x in (*ranges.mean(axis=1), *ranges.ravel()) if passage.carried(x))


def _longest_range(passage: search.Passage) -> float:
    """Return the largest permitted distance between neighbouring solved positions of a passage."""
    return float(_LONGEST_RANGE * np.ptp(passage.road.breaks))


def _cross(
    session: Session,
    directions: list[list[search.Passage]],
    programs: dict[str | None, search.SolveLive],
    effort: Effort,
    progress: Callable[[float, float], None],
    required: float | None,
) -> tuple[list[search.PassageTrials], KeyboardInterrupt | None]:
    """Find the least load factor of each passage; return the answers and the exception that ended the search.

    ``programs`` has functions that compute the associative load factor, by load case. ``required`` is the
    required load factor, or None. The exception is None if the search was completed. If no position was
    solved, KeyboardInterrupt is raised after Ctrl-C, and TimeLimitError at the time limit.
    """
    many = session.without_incremental()
    all_trials: list[search.PassageTrials] = []
    stop: KeyboardInterrupt | None = None
    associative = session.method.associative
    default_solver = session.how.model is None and session.how.solver is None
    try:
        for passages in directions:
            for passage in passages:
                program = programs[passage.case]
                # For speed, replace an associative method by a compiled linear program with the same answers.
                # The program cannot be used if joints crush or if the user chose a solver.
                is_program = default_solver and associative and not len(passage.assembly.problem.crushing)
                solve = program if is_program else _solve(many, passage, effort)
                bounds = None if associative else search.PassageTrials(passage, program)
                all_trials.append(search.PassageTrials(passage, solve, progress, bounds))
                longest, decided = _longest_range(passage), required if associative else None
                search.least_associative(all_trials[-1].associative, longest, WITHIN, decided)
            by_case = all_trials[-len(passages) :]
            _solve_equal_positions([trials.associative for trials in by_case])
            if not associative:
                for trials in by_case:
                    search.least_coulomb(trials, WITHIN)
                _solve_equal_positions(by_case)
    except KeyboardInterrupt as caught:
        stop = caught
    solved = [trials.ended() for trials in all_trials if trials.answers]
    if stop is not None and not solved:
        raise _without_positions(session, all_trials, stop) from None
    return solved, stop


def _without_positions(
    session: Session, all_trials: list[search.PassageTrials], stop: KeyboardInterrupt
) -> KeyboardInterrupt | TimeLimitError:
    """Return the error for a crossing that ended before its method solved any position.

    The message states the least associative load factor, if a Coulomb method has computed any so far.
    """
    known = f"method '{session.method.name}' had not yet solved any position of the axles"
    bounds = [trials.associative for trials in all_trials if trials.associative.answers]
    least = min((trials.least for trials in bounds), default=math.inf)
    if math.isfinite(least):
        positions = counted(sum(len(trials.answers) for trials in bounds), "position")
        value = numeral(least, ".6f")
        known = f"{known}; λ is at most {value}, the least of the associative load factors at {positions}"
    if isinstance(stop, TimeLimitReached):
        scene = all_trials[0].passage.assembly.scene
        return _time_is_over(scene, stop, known, _warnings_about(all_trials[0].passage))
    return KeyboardInterrupt(known)


def _warnings_about(passage: search.Passage) -> tuple[str, ...]:
    """Return the warnings about a passage's scene as sentences, even after the time limit."""
    with unlimited():
        loaded = passage.loaded(passage.live(_first_loaded(passage)))
        return sentences(warnings_of(loaded, None))


def _other_methods(session: Session, result: Result, worst: search.PassageTrials) -> dict[str, Any]:
    """Solve the worst position with other methods, and return the results as fields of the crossing.

    An associative method is compared with the default method. Chords inside the crushing parabola are
    compared with the parabola. If a method has no result, one of the fields contains the reason.
    """
    scene, fields = worst.passage.scene(worst.position), dict[str, Any]()
    if session.method.associative:
        fields["default"], fields["no_default"] = _solved_by(DEFAULT, scene)
    if result.crushing == "chords":
        fields["by_parabola"], fields["no_parabola"] = _solved_by_parabola(scene)
    return fields


def _solved_by_parabola(scene: Scene) -> tuple[float | None, str]:
    """Return the associative load factor with the crushing parabola, and the reason if it is None."""
    result, reason = _solved_by("static", scene)
    if result is None:
        return None, reason
    if result.crushing == "chords":
        return None, "method 'static' solved the scene with chords instead of the crushing parabola"
    if result.solution.carries_any_load:
        return None, "any load is carried"
    return result.load_factor, "" if result.load_factor is not None else str(result.status)


def _solved_by(method: str, scene: Scene) -> tuple[Result | None, str]:
    """Return the result of a method, and the reason if the result is None.

    The time limit of the crossing applies to this solve too.
    """
    try:
        result = prepare(method).without_incremental().solve(scene)
    except (KeyboardInterrupt, MasonryError) as error:
        return None, str(error) or "interrupted"
    if result.status is not Status.TIME_LIMIT:
        return result, ""
    seconds = result.solution.values_of(Code.TIME_LIMIT)["seconds"]
    return None, f"the time limit of {seconds:g} s ended the solve"


def _solve_equal_positions(by_case: list[search.PassageTrials]) -> None:
    """Solve each load case at all positions at which any load case was solved."""
    for position in sorted({position for trials in by_case for position in trials.answers}):
        for trials in by_case:
            trials.at(position)


def _solve(session: Session, passage: search.Passage, effort: Effort) -> search.SolveLive:
    """Return a function that solves the scene of a passage under a given live load, by the chosen method."""
    return lambda live: session.pushed(passage.loaded(live), ignore_progress, effort)
