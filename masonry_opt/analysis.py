"""``solve``: a scene, a method and a solver to a result; what may be asked for is checked here."""

from __future__ import annotations

import difflib
import reprlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from masonry_opt.effort import Effort, Phases
from masonry_opt.errors import OptionError
from masonry_opt.methods.registry import DEFAULT, METHODS
from masonry_opt.methods.task import Method, Progress
from masonry_opt.problem.kept import Kept
from masonry_opt.result import Result
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.session import Session
from masonry_opt.solvers.registry import MODELS, SOLVERS, TOLERANCE, Solver, find_entry, find_solver

#: Arguments of :func:`solve` that are no options of a method.
_ARGUMENTS = (
    "scene",
    "method",
    "model",
    "solver",
    "tolerance",
    "expected",
    "load_case",
    "progress",
    "phases",
)


def solve(
    scene: Scene | str | Path,
    method: str = DEFAULT,
    *,
    model: str | None = None,
    solver: str | None = None,
    tolerance: float | None = None,
    expected: bool = True,
    load_case: str | None = None,
    progress: Progress = lambda _: None,
    phases: Phases = lambda _: None,
    **options: Any,
) -> Result:
    """Find the load factor at which a scene collapses.

    Parameters
    ----------
    scene:
        A scene, or the path of a case file.
    method:
        "mcp" (the default: an exact state of Coulomb friction next to the load to expect, on small scenes the
        lowest of a few; where dilatancy falls with stress the loop's), "compliant" (the load to expect of a
        scene that stands and is then pushed: contacts give a little),
        "nonassociative" (Coulomb: the loop of linear programs), "static" or "kinematic" (associative: one
        linear program), "mpec" (the least load factor near the loop's, by IPOPT), "refined" (an exact state
        of Coulomb friction, by linear programs from passes' states down, and by search if asked), or "global"
        (proven bounds of the least one, on small scenes).
    model:
        Modelling language: "cvxpy" (the default where a method is declared in it) or "pyomo"; both are
        there for "static", "kinematic" and "nonassociative". "mcp" and "compliant", which declare nothing,
        take "matrices".
    solver:
        For these three "clarabel" (CVXPY's default), "highs" (simplex; Pyomo's default), "highs-ipm"
        (Pyomo's default for the loop), or any solver that CVXPY finds. The others bring their own.
    tolerance:
        Feasibility and gap tolerance asked of the solver, for the same three (default 1e-9). With cones of
        friction in space the associative answer may be a state short of it: the reasons then say so.
    expected:
        Whether Coulomb methods also tell the load to expect, by method "compliant" (up to 8000
        joints, in space contact points).
    load_case:
        Name of a load case of the scene, which is needed where it has any; :func:`solve_cases` solves all.
    progress:
        Called with every step of the method: :class:`~.mcp.schedule.NewtonStep`,
        :class:`~.loop.run.Iteration` of the loop, :class:`~.mpec.RelaxationStep`,
        :class:`~.refined.Refinement`, :class:`~.bracket.relaxation.BoundStep` of "global".
    phases:
        Called with a few words as each phase begins, such as "finding joints" or "sub-problem 3".
    **options:
        The method's own: :class:`~.mcp.method.McpOptions`, :class:`~.loop.options.LoopOptions`,
        :class:`~.mpec.MpecOptions`, :class:`~.refined.RefinedOptions`,
        :class:`~.bracket.bracket.GlobalOptions`.

    Returns
    -------
    Result
        Whose ``status`` says whether there is a load factor.

    Raises
    ------
    CaseError
        If the case file or scene is wrong, or nothing carries a live load.
    OptionError
        If a method, model, solver, option or load case is unknown or not available, or the method does not
        know dilatancy that falls with stress, or no limited strength, or no solids.
    """
    for name, given in (("progress", progress), ("phases", phases)):
        if not callable(given):
            raise OptionError(f"{name} must be a function (found {given!r})")
    session = prepare(method, model=model, solver=solver, tolerance=tolerance, expected=expected, **options)
    effort = Effort(phases)
    effort.begins("reading blocks")
    with effort.measure("scene"):
        scene = as_scene(scene, load_case)
    return session.solve(scene, progress, effort)


def prepare(
    method: str = DEFAULT,
    *,
    model: str | None = None,
    solver: str | None = None,
    tolerance: float | None = None,
    expected: bool = True,
    keeps: bool = False,
    **options: Any,
) -> Session:
    """A session that solves scenes as :func:`solve` would.

    Parameters
    ----------
    keeps: whether it keeps geometry and compiled programs for scenes that differ in joint properties alone.
    method, model, solver, tolerance, expected, options: as of :func:`solve`.

    Raises
    ------
    OptionError
        If one of these is unknown or not available, whatever the scene.
    """
    if not isinstance(expected, bool):
        raise OptionError(f"expected must be True or False (found {expected!r})")
    chosen, own_options = _choose(method, options)
    named = _solver(chosen, model, solver, tolerance)
    # Where the method brings its own solver, a quick one decides whether the scene stands.
    dead_load = find_solver("cvxpy", None) if solver is None and chosen.own_tolerances else named
    return Session(chosen, named, own_options, dead_load, expected, Kept(keeps))


def refuse_options(
    method: str, model: str | None, solver: str | None, tolerance: float | None, options: Mapping[str, Any]
) -> None:
    """Raise OptionError for what :func:`solve` would refuse whatever the scene, and for functions, which no
    worker can be sent: to be asked before many."""
    for name, value in options.items():
        if callable(value):
            raise OptionError(f"option '{name}': a function is for a single scene, not for many")
    prepare(method, model=model, solver=solver, tolerance=tolerance, **options)


def _choose(name: str, options: Mapping[str, Any]) -> tuple[Method, Any]:
    """A method and its options, checked. Raises OptionError naming what is wrong."""
    if not isinstance(name, str) or name not in METHODS:
        raise OptionError(f"method '{name}' is unknown; choose from: {', '.join(METHODS)}")
    method = METHODS[name]
    known = list(method.options.model_fields) if method.options else []
    for option in options:
        if option not in known:
            raise OptionError(f"method '{name}' has no option '{option}'{_instead(option, known)}")
    given = {
        option: value.solution if isinstance(value, Result) else value for option, value in options.items()
    }
    try:
        return method, method.options(**given) if method.options else None
    except ValidationError as error:
        # Of an option that may be one of several things, what is said of the first will do.
        wrong = {
            ".".join(map(str, item["loc"][:1])): f"{item['msg']} (found {reprlib.repr(item['input'])})"
            for item in reversed(error.errors())
        }
        said = [f"option '{option}': {words}" if option else words for option, words in wrong.items()]
        raise OptionError(f"method '{name}': {'; '.join(said)}") from None


def _instead(option: str, known: list[str]) -> str:
    """What to write in place of an option that a method does not have."""
    if homes := _homes(option):
        return f"; methods that have it: {', '.join(homes)}"
    if close := difflib.get_close_matches(option, [*known, *_ARGUMENTS], n=1):
        return f"; did you mean '{close[0]}'?"
    others = [other for has in METHODS.values() if has.options for other in has.options.model_fields]
    if close := difflib.get_close_matches(option, others, n=1):
        return f"; did you mean '{close[0]}'? Methods that have it: {', '.join(_homes(close[0]))}"
    return f"; it has: {', '.join(known) or 'none'}"


def _homes(option: str) -> list[str]:
    """Methods that have an option."""
    return [name for name, has in METHODS.items() if has.options and option in has.options.model_fields]


def _solver(method: Method, model: str | None, name: str | None, tolerance: float | None) -> Solver:
    for what, given in (("model", model), ("solver", name)):
        if not isinstance(given, str | None):
            raise OptionError(f"{what} must be a name (found {given!r})")
    model = model or next(iter(method.solvers))
    if model in MODELS and model not in method.solvers:
        raise OptionError(
            f"method '{method.name}' takes model: {', '.join(method.solvers)} (found '{model}'); methods "
            f"that take it: {_names(lambda other: model in other.solvers)}"
        )
    allowed = method.solvers.get(model, ())
    name = name.lower() if name else (allowed[0] if allowed else None)
    if allowed and name not in allowed:
        raise OptionError(
            f"method '{method.name}' with model '{model}' takes solver: {', '.join(allowed)} (found '{name}')"
            f"{_takers(name)}"
        )
    if tolerance is not None and method.own_tolerances:
        raise OptionError(
            f"method '{method.name}' has tolerances of its own: leave 'tolerance' out, or name a method "
            f"that takes one: {_names(lambda other: not other.own_tolerances)}"
        )
    others = [entry for entry in SOLVERS.values() if entry.name == name and not entry.linear]
    if others and not allowed:
        takers = _names(lambda other: other.solved_by(others[0]))
        raise OptionError(f"solver '{name}' solves no linear programs, and is for methods: {takers}")
    return find_solver(model, name, TOLERANCE if tolerance is None else tolerance)


def _takers(name: str | None) -> str:
    """Which methods take a solver, in the first language that has it; which take solvers that CVXPY finds."""
    for language in MODELS:
        try:
            entry = find_entry(language, name)
        except OptionError:
            continue
        takers = [name for name, method in METHODS.items() if method.solved_by(entry)]
        return f"; methods that take it, with model '{language}': {', '.join(takers)}"
    return (
        f"; methods of linear programs, which take others: {_names(lambda method: not method.own_tolerances)}"
    )


def _names(of: Callable[[Method], bool]) -> str:
    return ", ".join(name for name, method in METHODS.items() if of(method))
