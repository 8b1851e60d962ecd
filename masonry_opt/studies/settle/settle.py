"""``settle``: the least and the greatest reaction of supports with which a scene stands."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from masonry_opt.analysis import prepare
from masonry_opt.answer.thresholds import ZERO
from masonry_opt.effort import Effort, Phases
from masonry_opt.errors import OptionError
from masonry_opt.methods.associative import associative
from masonry_opt.methods.mcp.passes import PASSES_UP_TO, Passes
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.methods.task import Task
from masonry_opt.problem.assembly import Assembly, assemble
from masonry_opt.problem.problem import Problem
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.standing.diagnosis import carries
from masonry_opt.studies.settle.freed import freed
from masonry_opt.studies.settle.settlement import Bound, Settlement


def settle(
    scene: Scene | str | Path,
    support: str | Sequence[str],
    direction: Sequence[float],
    *,
    turns: bool = False,
    load_case: str | None = None,
    method: str = DEFAULT,
    model: str | None = None,
    solver: str | None = None,
    tolerance: float | None = None,
    expected: bool = True,
    phases: Phases = lambda _: None,
    **options: Any,
) -> Settlement:
    """Find the reactions of a support, or of several, with which a scene stands under its dead load.

    The support gives way in one direction, or is pushed back, and neither moves otherwise nor turns. Its
    reaction is the force of the ground on it against that direction: > 0 presses the support against the
    scene. As it settles its reaction falls, to the least at which the scene stands; below, the scene follows.
    As it is pushed against the direction its reaction grows, to the greatest. Either may be below zero (the
    ground must pull), or unlimited.

    Live loads of the scene are left out. Weights and loads of the supports themselves are left to the ground.

    Parameters
    ----------
    scene: a scene, or the path of a case file.
    support: name of a fixed block; of several, these move at a common rate, and the reaction is their sum.
    direction: in which it settles, ``(x, y)``, in space ``(x, y, z)``; only the direction counts.
    turns: whether each support may turn too, also at rest; its reaction passes its centroid.
    load_case: name of one of the scene's, whose dead loads act.
    method, model, solver, tolerance, expected, phases, **options: as of :func:`~masonry_opt.solve`.

    Returns
    -------
    Settlement
        Whose ``status`` says whether any reaction holds the scene.

    Raises
    ------
    CaseError
        If the case file or scene is wrong.
    OptionError
        If there is no such support, it can move already, or touches nothing that can; if the direction is
        none of the scene's; or what :func:`~masonry_opt.solve` refuses.
    """
    session = prepare(method, model=model, solver=solver, tolerance=tolerance, expected=expected, **options)
    scene, effort = as_scene(scene, load_case), Effort(phases)
    scene.refuse_without_case()
    supports = _supports(scene, support)
    along = _unit(scene, direction)
    effort.begins("finding joints")
    assembly = assemble(scene)
    problem = assembly.problem
    unit = problem.force_unit * (float(problem.force_sizes(problem.dead).sum()) or 1.0)
    settling, pushed_back = (freed(assembly, supports, along, push, turns) for push in (unit, -unit))
    _refuse_idle(assembly, settling, supports)
    told = partial(
        Settlement,
        case=scene.called,
        supports=tuple(scene.blocks[number].name for number in supports),
        direction=tuple(along.tolist()),
        turns=turns,
        method=method,
    )
    held = freed(assembly, supports, along, None, turns) if turns else assembly
    if fallen := session.falls(held, effort):
        return told(fallen=fallen)
    effort.begins("reaction at rest")
    rest = _at_rest(held.problem, settling.problem, problem.B.shape[1])
    if rest is None:
        session = session.without_expected()
        begins = _ends_by_statics(settling.problem, pushed_back.problem)[::-1]
    else:
        begins = [(_reaction(settling.problem, rest), rest)] * 2
    sessions = [session] if session.method.associative else [session, prepare("static")]

    def bound(moved: Assembly, sign: float, start: float, settled: np.ndarray | None) -> Bound:
        """The end that a push leads to, from a reaction and the forces there, if known."""
        dead = moved.problem.dead - sign * start * moved.problem.live
        begun = replace(moved, problem=replace(moved.problem, dead=dead, settled=settled))
        results = [each.push(begun, lambda _: None, Effort(phases)) for each in sessions]
        return Bound(results[0], results[-1], start=unit * start, per_load_factor=-sign * unit)

    return told(
        at_rest=None if rest is None else unit * begins[0][0],
        least=bound(settling, 1.0, *begins[0]),
        greatest=bound(pushed_back, -1.0, *begins[1]),
    )


def _supports(scene: Scene, support: str | Sequence[str]) -> np.ndarray:
    """Indices of the supports. Raises OptionError if one is none, or is named twice."""
    names: list[Any] = list(support) if isinstance(support, list | tuple) else [support]
    known = {block.name: number for number, block in enumerate(scene.blocks)}
    fixed = [block.name for block in scene.blocks if block.fixed]
    if not names or not all(isinstance(name, str) for name in names) or len(set(names)) < len(names):
        raise OptionError(f"{scene.origin}: support: name each support once (found {support!r})")
    for name in names:
        if name not in known:
            close = difflib.get_close_matches(name, fixed, n=1)
            instead = f"did you mean '{close[0]}'?" if close else f"supports: {', '.join(fixed)}"
            raise OptionError(f"{scene.origin}: support: no block '{name}'; {instead}")
        if name not in fixed:
            raise OptionError(
                f"{scene.origin}: support '{name}' can move already: name a block with 'fixed = true': "
                f"{', '.join(fixed)}"
            )
    return np.array([known[name] for name in names])


def _unit(scene: Scene, direction: Sequence[float]) -> np.ndarray:
    """Unit vector of a direction. Raises OptionError if it is none of the scene's."""
    needed = "three numbers, x, y, z" if scene.dimension == 3 else "two numbers, x, y"
    try:
        vector = np.array(direction, dtype=float)
    except (TypeError, ValueError):
        vector = np.empty(0)
    if vector.shape != (scene.dimension,) or not np.isfinite(vector).all() or not vector.any():
        raise OptionError(
            f"{scene.origin}: direction: needs {needed}, not all of them zero (found {direction!r})"
        )
    vector = vector / np.abs(vector).max()
    return vector / np.linalg.norm(vector)


def _refuse_idle(assembly: Assembly, freed_of: Assembly, supports: np.ndarray) -> None:
    """Raise OptionError if nothing that can move presses or pulls a support."""
    forces = assembly.problem.B.shape[1]
    touched = np.abs(freed_of.problem.B[:, :forces]).sum(axis=1)
    rows = freed_of.problem.by_block(touched).sum(axis=1)
    for support in supports:
        if not rows[freed_of.movable == support].any():
            raise OptionError(
                f"{assembly.scene.origin}: support '{assembly.scene.blocks[support].name}' touches no block "
                "that can move: nothing changes where it settles"
            )


def _at_rest(held: Problem, settling: Problem, own: int) -> np.ndarray | None:
    """Forces under the dead load of contacts that give while the supports are held, as those of supports that
    settle, shape (3c + t,); None if no pass tells them, or these do not carry the dead load.

    Parameters
    ----------
    own: number of forces that are the scene's own, the first of either problem; the others hold supports.
    """
    if held.joints > PASSES_UP_TO or held.dilatancy_depends_on_stress:
        return None
    passes = Passes(held)
    q = passes.settled_forces()
    if q is None or not carries(held, q, ZERO) or not passes.carry_dead_load():
        return None
    return np.append(q[:own], np.zeros(settling.B.shape[1] - own))


def _reaction(settling: Problem, q: np.ndarray) -> float:
    """What forces press on the supports, over the live load."""
    reaction = float(settling.B @ q @ settling.live / (settling.live @ settling.live))
    # What is rounding counts as zero: solvers would measure loads by it.
    return reaction if abs(reaction) > ZERO else 0.0


def _ends_by_statics(settling: Problem, pushed_back: Problem) -> list[tuple[float, np.ndarray | None]]:
    """Least and greatest reaction with associative flow, over the live load, and the forces there; for one
    without limit a reaction beyond the other."""
    least, greatest = (associative(Task(problem)) for problem in (settling, pushed_back))
    low = None if least.load_factor is None else -least.load_factor
    high = greatest.load_factor
    if low is None:
        low = 0.0 if high is None else high - 1.0
    return [(low, least.q), (low + 1.0 if high is None else high, greatest.q)]
