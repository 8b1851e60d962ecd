"""``solve``: a scene, a method and a solver to a result."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from masonry_opt.effort import Effort, Phases
from masonry_opt.errors import OptionError
from masonry_opt.methods.registry import DEFAULT, HowToSolve
from masonry_opt.methods.task import Progress
from masonry_opt.result import Result
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.session import Session
from masonry_opt.solvers.driver import Kept


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
    scene: A scene, or the path of a case file.
    method: "mcp" (the default: an exact state of Coulomb friction next to the load to expect, on small scenes
        the lowest of a few; where dilatancy falls with stress the loop's), "compliant" (the load to expect of
        a scene that stands and is then pushed: contacts give a little), "nonassociative" (Coulomb: the loop
        of linear programs), "static" or "kinematic" (associative: one linear program), "mpec" (the least load
        factor near the loop's, by IPOPT), "refined" (an exact state of Coulomb friction, by linear programs
        from a push's state down, and by search if asked), or "global" (proven bounds of the least one, on
        small scenes).
    model: Modelling language: "cvxpy" (the default where a method is declared in it) or "pyomo"; both are
        there for "static", "kinematic" and "nonassociative". "mcp" and "compliant", which declare nothing,
        take "matrices".
    solver: For these three "clarabel" (CVXPY's default), "highs" (simplex; Pyomo's default), "highs-ipm"
        (Pyomo's default for the loop), or any solver that CVXPY finds. The others bring their own.
    tolerance: Feasibility and gap tolerance asked of the solver, for the same three (default 1e-9). With
        cones of friction in space the associative answer may be a state short of it: the reasons then say so.
    expected: Whether Coulomb methods also tell the load to expect, by method "compliant" (up to 3000 joints,
        in space contact points).
    load_case: Name of a load case of the scene, which is needed where it has any; :func:`solve_cases` solves
        all.
    progress:
        Called with every step of the method: :class:`~.push.push.PushStep`,
        :class:`~.loop.run.Iteration` of the loop, :class:`~.mpec.RelaxationStep`,
        :class:`~.refined.Refinement`, :class:`~.bracket.relaxation.BoundStep` of "global".
    phases: Called with a few words as each phase begins, such as "finding joints" or "sub-problem 3".
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
    return Session(HowToSolve(method, model, solver, tolerance, expected, options), Kept(keeps))
