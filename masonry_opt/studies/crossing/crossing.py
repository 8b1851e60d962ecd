"""``crossing``: the load factor of a scene as axles move over it, and their worst position."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from masonry_opt.analysis import Session, prepare
from masonry_opt.answer.reasons import Code, Status
from masonry_opt.effort import Effort, Phases
from masonry_opt.errors import CaseError, MasonryError, OptionError
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.problem.assembly import assemble, on_matrices_of
from masonry_opt.problem.fill import Road
from masonry_opt.scene.blocks import Point
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.road import Axles
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.crossing import search
from masonry_opt.studies.crossing.answer import WITHIN, Crossing

_LONGEST = 0.01  #: Longest range between two positions, as a share of the road.
_Asked = str | Axles | Sequence[Axles] | None  #: The axles that are to cross, or their name.


def crossing(
    scene: Scene | str | Path,
    axles: str | Axles | Sequence[Axles] | None = None,
    *,
    method: str = DEFAULT,
    load_case: str | None = None,
    progress: Callable[[float, float], None] = lambda position, load_factor: None,
    phases: Phases = lambda _: None,
    **options: Any,
) -> Crossing:
    """Move axles over a scene in the plane and find where the load factor is least.

    The axles press straight down; the load factor multiplies their loads, and whatever other live loads the
    scene has. Those on the road count: a group may be partly beyond its ends. Over supports, and where the
    road runs over nothing, an axle does nothing. A group that is not the same from behind crosses in both
    directions, unless it says in which it ``travels``.

    With associative flow (methods "static" and "kinematic") the least is proven, also between positions (see
    :func:`~.crossing.search.least_associative`). Other methods are asked where the associative load factor,
    which none of their answers exceeds, says that λ may be least, which proves nothing (see
    :func:`~.crossing.search.least_coulomb`). Interrupted (Ctrl-C), it returns the worst solved by then.

    Of a scene with load cases they cross in each whose ``live`` names "axles", at the same positions, and the
    least governs. The load case that falls under its dead loads, if one does, is the answer.

    Raises CaseError if the case file or scene is wrong, or has no axles, or no road, if the road runs through
    a block, or over none that can move, if load cases leave axles out; OptionError if a method, an option
    or the name of a group is wrong, or the scene's blocks are solids; KeyboardInterrupt if it was interrupted
    before any position was solved.

    Parameters
    ----------
    scene: A scene, or the path of a case file.
    axles: A group, several, or the name of one of the scene's. Default: all of the scene's.
    method, options: As of :func:`~masonry_opt.analysis.solve`, its model, solver, ... too. The
        incremental load factor is that of the worst position alone.
    load_case: Name of the one load case in which they cross, where the scene has any (default: all that name
        "axles", whose factor multiplies them, and what else is live beside them).
    progress: Called with each position solved and its load factor (NaN without one).
    phases: Called with a few words as each phase of the first solve begins, such as "finding joints".
    """
    session = prepare(method, **options)
    many = session.without_incremental()
    scene = as_scene(scene, load_case)
    scene.in_plane()  # which refuses solids
    ways, left_out = _ways(scene, axles)
    told = partial(Crossing, cases=tuple(one.case for one in ways[0] if one.case), left_out=left_out)
    effort, moving = Effort(), dict[str | None, search.SolveLive]()
    for first in ways[0]:
        ends = np.array(first.pieces(_LONGEST * np.ptp(first.road.breaks)))
        start = next(x for x in (*ends.mean(axis=1), *ends.ravel()) if first.carried(x))
        result = session.solve(first.scene(start), lambda _: None, Effort(phases))
        undecided = any(reason.code is Code.DEAD_LOAD_UNDECIDED for reason in result.reasons)
        if undecided or result.status is Status.UNSTABLE:
            return told(worst=result, passages=())
        moving[first.case] = search.moving_load(first.loaded(first.live(start)).problem, effort)
    crossed: list[search.PassageTrials] = []
    interrupted, proves = False, session.method.associative
    own = session.how.model is None and session.how.solver is None
    try:
        for way in ways:
            for passage in way:
                associative = moving[passage.case]
                plain = own and proves and not len(passage.assembly.problem.crushing)
                solve = associative if plain else _solve(many, passage, effort)
                beside = None if proves else search.PassageTrials(passage, associative)
                crossed.append(search.PassageTrials(passage, solve, progress, beside))
                longest = _LONGEST * np.ptp(passage.road.breaks)
                search.least_associative(crossed[-1].associative, longest, WITHIN)
            together = crossed[-len(way) :]
            _at_the_same([one.associative for one in together])
            if not proves:
                for one in together:
                    search.least_coulomb(one, WITHIN)
                _at_the_same(together)
    except KeyboardInterrupt:
        interrupted = True
    crossed = [trials.ended() for trials in crossed if trials.answers]
    if not crossed:
        raise KeyboardInterrupt
    worst = min(crossed, key=lambda one: one.least)
    at_worst = worst.passage.scene(worst.position)
    default, no_default = None, ""
    if proves and not interrupted:
        try:
            default = prepare(DEFAULT).without_incremental().solve(at_worst)
        except (KeyboardInterrupt, MasonryError) as error:
            no_default = str(error) or "interrupted"
    try:
        result = session.solve(at_worst)
    except KeyboardInterrupt:
        interrupted = True
        known = replace(worst.passage.loaded(worst.passage.live(worst.position)), scene=at_worst)
        result = session.result(known, worst.answers[worst.position], effort)
    told = partial(told, default=default, no_default=no_default, interrupted=interrupted)
    return told(worst=result, passages=tuple(crossed))


def _at_the_same(together: list[search.PassageTrials]) -> None:
    """Solve each load case at the positions of all of them."""
    for position in sorted({position for one in together for position in one.answers}):
        for one in together:
            one.at(position)


def _solve(session: Session, passage: search.Passage, effort: Effort) -> search.SolveLive:
    """The method itself, on the scene's own matrices."""
    return lambda live: session.pushed(passage.loaded(live), lambda _: None, effort)


def _ways(scene: Scene, axles: _Asked) -> tuple[list[list[search.Passage]], tuple[str, ...]]:
    """Groups in the directions in which they travel, by load case; names of those that leave axles out."""
    if scene.tilt:
        raise CaseError(f"{scene.origin}: axles do not tilt: take 'tilt' away")
    if scene.earthquake:
        raise CaseError(f"{scene.origin}: axles do not cross in an earthquake: take 'earthquake' away")
    groups = _groups(scene, axles)
    bare = scene.replace(axles=[])
    cases = [scene.load_case] if scene.load_case else scene.load_cases
    scenes = [bare.with_load_case(case) for case in cases] or [bare]
    inside = [one for one in scenes if one.factor_of_axles]
    if not inside:
        named = ", ".join(f"'{case.name}' leaves axles out ({case})" for case in cases)
        raise CaseError(f"{scene.origin}: load case {named}: give one 'live = {{ axles = 1 }}'")
    assembly = assemble(inside[0])
    assemblies = [on_matrices_of(assembly, one) or assemble(one) for one in inside]
    ways = []
    for group in groups:
        road = Road(scene, assembly.geometry, _line(scene, group), f"the road of axles '{group.name}'")
        ways += [[search.Passage(group, way, one, road) for one in assemblies] for way in group.directions]
    return ways, tuple(case.name for case in cases if not case.factor("live", "axles"))


def _groups(scene: Scene, axles: _Asked) -> list[Axles]:
    if isinstance(axles, str):
        named = [group for group in scene.axles if group.name == axles]
        if not named:
            known = ", ".join(repr(group.name) for group in scene.axles) or "none"
            raise OptionError(f"{scene.origin}: no axles '{axles}'; known: {known}")
        return named
    groups = [axles] if isinstance(axles, Axles) else list(scene.axles if axles is None else axles)
    if not groups:
        raise CaseError(f"{scene.origin}: has no axles: give [[axles]], or in Python axles=mo.Axles(...)")
    if not all(isinstance(group, Axles) for group in groups):
        raise OptionError("axles must be an Axles, a list of them, or the name of one of the scene's")
    return groups


def _line(scene: Scene, group: Axles) -> list[Point]:
    """The group's own road, else that of the scene's fills."""
    if group.road is not None:
        return group.road
    points = [point for fill in sorted(scene.fills, key=lambda fill: fill.road[0]) for point in fill.road]
    if not points:
        needed = "'road', the points of a line above the blocks from left to right"
        raise CaseError(f"{scene.origin}: axles '{group.name}': on which road? Give {needed}")
    return [point for point, _ in groupby(points)]
