"""The solvers a user can name, and their options. Adding a solver is one entry."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cvxpy as cp

from masonry_opt.errors import OptionError

#: Feasibility and gap tolerance asked of every solver; looser values cost digits of λ.
TOLERANCE = 1e-9


@dataclass(frozen=True)
class Solver:
    """A solver and how it is asked.

    Attributes
    ----------
    name: what a user calls it.
    language: the modelling language that drives it.
    engine: its name in that language.
    options: its options, tolerances included.
    """

    name: str
    language: str
    engine: str
    options: dict[str, Any]


def _clarabel(tolerance: float) -> dict[str, Any]:
    return {"tol_gap_abs": tolerance, "tol_gap_rel": tolerance, "tol_feas": tolerance}


def _highs(algorithm: str, **more: Any) -> Any:
    def options(tolerance: float) -> dict[str, Any]:
        feasibility = max(tolerance, 1e-10)  # HiGHS takes no less
        return {
            "solver": algorithm,
            "primal_feasibility_tolerance": feasibility,
            "dual_feasibility_tolerance": feasibility,
            **more,
        }

    return options


_SIMPLEX = _highs("simplex")
_INTERIOR = _highs("ipm", run_crossover="off")

#: (language, name): engine, options by tolerance. The first of each language is its default.
SOLVERS: dict[tuple[str, str], tuple[str, Any]] = {
    ("cvxpy", "clarabel"): ("CLARABEL", _clarabel),
    ("cvxpy", "highs"): ("HIGHS", _SIMPLEX),
    ("cvxpy", "highs-ipm"): ("HIGHS", _INTERIOR),
    ("pyomo", "highs"): ("highs", _SIMPLEX),
    ("pyomo", "highs-ipm"): ("highs", _INTERIOR),
}

LANGUAGES = tuple(dict.fromkeys(language for language, _ in SOLVERS))


def find_solver(language: str, name: str | None, tolerance: float = TOLERANCE) -> Solver:
    """The solver of that name in that language, or the language's default.

    CVXPY drives any further solver it finds installed, with that solver's own tolerances.

    Raises
    ------
    OptionError
        If the language is unknown, or the solver is unknown there or not installed.
    """
    if language not in LANGUAGES:
        raise OptionError(f"model '{language}' is unknown; choose from: {', '.join(LANGUAGES)}")
    known = [solver for of, solver in SOLVERS if of == language]
    name = name or known[0]
    installed = {engine.lower() for engine in cp.installed_solvers()}
    entry = SOLVERS.get((language, name))
    if entry is None:
        if language == "cvxpy" and name in installed:
            return Solver(name, language, name.upper(), {})
        others = f" (CVXPY also finds: {', '.join(sorted(installed - set(known)))})"
        raise OptionError(
            f"solver '{name}' is unknown or not installed for model '{language}'; "
            f"choose from: {', '.join(known)}{others if language == 'cvxpy' else ''}"
        )
    engine, options = entry
    return Solver(name, language, engine, options(tolerance))
