"""The solvers a user can name, and their options. Adding a solver is one entry."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cvxpy as cp
import highspy

from masonry_opt.errors import OptionError

#: Feasibility and gap tolerance asked of every solver; looser values cost digits of λ.
TOLERANCE = 1e-9

#: From here on an answer is meant to be rough.
_ROUGH = 1e-5


@dataclass(frozen=True)
class Solver:
    """A solver and how it is asked.

    Attributes
    ----------
    name: what a user calls it.
    language: the modelling language that drives it.
    engine: its name in that language.
    options: its options, tolerances included.
    tolerance: feasibility and gap asked of it.
    """

    name: str
    language: str
    engine: str
    options: dict[str, Any]
    tolerance: float = TOLERANCE


def _clarabel(tolerance: float) -> dict[str, Any]:
    options: dict[str, Any] = {"tol_gap_abs": tolerance, "tol_gap_rel": tolerance, "tol_feas": tolerance}
    # Its own choice is faer from some hundred thousand joints on, which takes four times as long there.
    options["direct_solve_method"] = "qdldl"
    if tolerance >= _ROUGH:
        # A third of the time goes into refining search directions, which so rough an answer does not need.
        options["iterative_refinement_enable"] = False
    return options


def _highs_simplex(tolerance: float) -> dict[str, Any]:
    feasibility = max(tolerance, 1e-10)  # HiGHS takes no less
    return {
        "solver": "simplex",
        "primal_feasibility_tolerance": feasibility,
        "dual_feasibility_tolerance": feasibility,
    }


def _highs_interior(tolerance: float) -> dict[str, Any]:
    # Crossover would end in a vertex, and the loop needs the middle of the optimal states.
    return _highs_simplex(tolerance) | {
        "solver": "ipx",  # "ipm" would be HiPO where that is installed
        "run_crossover": "off",
        "ipm_optimality_tolerance": max(tolerance, 1e-12),
    }


def _highs_hipo(tolerance: float) -> dict[str, Any]:
    return _highs_interior(tolerance) | {"solver": "hipo"}


def _has_hipo() -> bool:
    highs = highspy.Highs()
    highs.silent()
    return bool(highs.setOptionValue("solver", "hipo") == highspy.HighsStatus.kOk)


#: (language, name): engine, options by tolerance. The first of each language is its default.
SOLVERS: dict[tuple[str, str], tuple[str, Any]] = {
    ("cvxpy", "clarabel"): ("CLARABEL", _clarabel),
    ("cvxpy", "highs"): ("HIGHS", _highs_simplex),
    ("cvxpy", "highs-ipm"): ("HIGHS", _highs_interior),
    ("pyomo", "highs"): ("highs", _highs_simplex),
    ("pyomo", "highs-ipm"): ("highs", _highs_interior),
}

#: HiGHS's newer interior point, of the extra "solvers".
HIPO = "highs-hipo"
if _has_hipo():
    SOLVERS[("cvxpy", HIPO)] = ("HIGHS", _highs_hipo)
    SOLVERS[("pyomo", HIPO)] = ("highs", _highs_hipo)

#: Solvers that stop at whatever tolerance they are asked for. At 1e-4 HiGHS's interior points end "unknown",
#: and its simplex ends in a vertex all the same.
STOPS_EARLY = ("clarabel", "piqp")

LANGUAGES = tuple(dict.fromkeys(language for language, _ in SOLVERS))


def _osqp(tolerance: float) -> dict[str, Any]:
    # A first-order method: many cheap iterations. Its own limit is a tenth of SCS's.
    return {"eps_abs": tolerance, "eps_rel": tolerance, "max_iter": 100_000}


def _scs(tolerance: float) -> dict[str, Any]:
    return {"eps_abs": tolerance, "eps_rel": tolerance, "max_iters": 100_000}


def _piqp(tolerance: float) -> dict[str, Any]:
    # Unless asked to, it does not tell its time.
    limits = dict.fromkeys(("eps_abs", "eps_rel", "eps_duality_gap_abs", "eps_duality_gap_rel"), tolerance)
    return {**limits, "compute_timings": True}


def _scipy(tolerance: float) -> dict[str, Any]:
    # SciPy's own HiGHS.
    feasibility = max(tolerance, 1e-10)
    names = ("primal_feasibility_tolerance", "dual_feasibility_tolerance")
    return {"scipy_options": dict.fromkeys(names, feasibility)}


#: Options by tolerance of further solvers that CVXPY may find. Others keep tolerances of their own.
FOUND_BY_CVXPY: dict[str, Callable[[float], dict[str, Any]]] = {
    "osqp": _osqp,
    "piqp": _piqp,
    "scs": _scs,
    "scipy": _scipy,
}


def found_by_cvxpy() -> tuple[str, ...]:
    """Solvers of linear programs that CVXPY finds installed, beyond those of ``SOLVERS``."""
    known = {solver for language, solver in SOLVERS if language == "cvxpy"}
    return tuple(sorted({engine.lower() for engine in cp.installed_solvers()} - known))


def find_solver(language: str, name: str | None, tolerance: float = TOLERANCE) -> Solver:
    """The solver of that name in that language, or the language's default.

    CVXPY drives any further solver it finds installed; the tolerance reaches those of
    ``FOUND_BY_CVXPY``.

    Raises
    ------
    OptionError
        If the language is unknown, the solver unknown there or not installed, or the tolerance no
        number between 0 and 0.1.
    """
    if language not in LANGUAGES:
        raise OptionError(f"model '{language}' is unknown; choose from: {', '.join(LANGUAGES)}")
    if not (isinstance(tolerance, float) and 0 < tolerance <= 0.1):
        raise OptionError(f"tolerance must be a number above 0, at most 0.1 (found {tolerance!r})")
    known = [solver for of, solver in SOLVERS if of == language]
    name = (name or known[0]).lower()
    found = found_by_cvxpy()
    entry = SOLVERS.get((language, name))
    if entry is None:
        if language == "cvxpy" and name in found:
            own = FOUND_BY_CVXPY.get(name)
            return Solver(name, language, name.upper(), own(tolerance) if own else {}, tolerance)
        others = f" (CVXPY also finds: {', '.join(found)})"
        raise OptionError(
            f"solver '{name}' is unknown or not installed for model '{language}'; "
            f"choose from: {', '.join(known)}{others if language == 'cvxpy' else ''}"
        )
    engine, options = entry
    return Solver(name, language, engine, options(tolerance), tolerance)


def rougher(solver: Solver, tolerance: float) -> Solver:
    """The same solver, asked for no more than this tolerance."""
    return find_solver(solver.language, solver.name, max(tolerance, solver.tolerance))
