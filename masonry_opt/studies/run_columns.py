"""Columns of tables of runs: load factor, status and mechanism of each run, with their types.

Tables of sweeps, samples, thresholds and crossings have these columns.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import pandas as pd

from masonry_opt.problem.assembly import Assembly
from masonry_opt.reporting.load_factors import own_name
from masonry_opt.result import Result
from masonry_opt.solution.frames import unsigned
from masonry_opt.solution.motion import joint_motion
from masonry_opt.solution.reasons import Code
from masonry_opt.solution.solution import Solution

#: Types of the columns of a run's answer, by column name. Only the values of ``seconds`` depend on the
#: computer.
ANSWER_COLUMNS = {
    "load_factor": "float64",
    **dict.fromkeys(("which", "status", "reason"), "object"),
    **dict.fromkeys(("any_load", "exact"), "boolean"),
    "states": "Int64",
    **dict.fromkeys(("incremental", "spread_lower", "spread_upper", "associative"), "float64"),
    **dict.fromkeys(("equilibrium", "yield", "flow", "complementarity"), "float64"),
    "mechanism": "object",
    **dict.fromkeys(("slides", "hinges", "separates", "crushes", "blocks", "joints"), "Int64"),
    "message": "object",
    "seconds": "float64",
}

#: Types of the columns of a run in a sweep or sample. ``state_from`` names the run from which the collapse
#: state was taken; it is empty if the run found the state itself. ``warnings`` contains the warnings about
#: the scene.
RUN_COLUMNS = ANSWER_COLUMNS | {"state_from": "object", "warnings": "object"}

#: Columns that describe the worst position of axles.
PLACE = ("axles", "position", "direction", "load_case")
#: Explanation of λ that is printed if axles cross the scene in each run.
CROSSED_RUNS = "axles cross the scene in each run: λ is the least load factor of the solved positions"

#: Types of the additional columns of a run with moving axles: the worst position, the proven lower bound on
#: λ, and the numbers of solved and undecided positions.
CROSSING_COLUMNS = {
    **dict.fromkeys(("load_case", "axles", "direction"), "object"),
    **dict.fromkeys(("position", "bound"), "float64"),
    **dict.fromkeys(("positions", "undecided_positions"), "Int64"),
}

#: Names of mechanisms by the kind of joint motion. In each of these mechanisms, joints may also separate.
_MECHANISM_NAMES = {"slides": "sliding", "hinges": "hinging", "crushes": "crushing"}


def is_crossed(frame: pd.DataFrame) -> bool:
    """Return True if axles cross the scene in the runs of a table."""
    return "position" in frame


def framed(
    rows: Sequence[Mapping[str, Any]],
    before: Iterable[str] | Mapping[str, str],
    of_runs: Mapping[str, str] = ANSWER_COLUMNS,
) -> pd.DataFrame:
    """Convert the rows of a table of runs to a DataFrame with typed columns.

    Parameters
    ----------
    rows: Entries by column, one dictionary a run.
    before: Names of the first columns, or their types by name. Columns without a type are numbers.
    of_runs: Types of the other columns by name.
    """
    types = dict(before) if isinstance(before, Mapping) else dict.fromkeys(before, "float64")
    types |= of_runs
    return unsigned(pd.DataFrame(rows, columns=[*types]).astype(types))


def columns(result: Result) -> dict[str, Any]:
    """Return a result as a row with the columns of ``ANSWER_COLUMNS``, except ``seconds``."""
    assembly, solution = result.assembly, result.solution
    spread = _spread_values(solution)
    certificate = solution.answer.certificate.as_dict() if solution.answer else {}
    entries: dict[str, Any] = {
        "load_factor": solution.load_factor,
        "which": "" if solution.load_factor is None else own_name(result),
        "status": str(solution.status),
        "reason": str(solution.reasons[0].code) if solution.reasons else "",
        "any_load": solution.carries_any_load,
        "exact": result.exact,
        "states": solution.exact_states,
        "incremental": solution.incremental_value,
        "spread_lower": min(spread, default=None),
        "spread_upper": max(spread, default=None),
        "associative": solution.associative_value,
        "blocks": assembly.problem.blocks,
        "joints": len(assembly.joints.first),
        "message": result.message,
    }
    return entries | certificate | mechanism(assembly, solution)


def _spread_values(solution: Solution) -> list[float]:
    """Return the limits of the incremental load factor for random stiffness, then for random self-stress.

    Option ``spread`` requests these limits. The list is empty without the option.
    """
    values: list[float] = []
    for reason in solution.reasons:
        if reason.code is Code.SPREAD:
            for kind in ("stiffness", "stress"):
                values += reason.values[kind] or ()
    return values


def mechanism(assembly: Assembly, solution: Solution) -> dict[str, Any]:
    """Return table columns: kind of mechanism, and how many joints slide, hinge, separate or crush.

    The dictionary is empty if the solution has no mechanism.
    """
    if solution.d is None:
        return {}
    motion = joint_motion(assembly, solution)
    counts = {kind: int(getattr(motion, kind).sum()) for kind in (*_MECHANISM_NAMES, "separates")}
    names = [name for kind, name in _MECHANISM_NAMES.items() if counts[kind]]
    if not names:
        names = ["separating" if counts["separates"] else "none"]
    return {"mechanism": names[0] if len(names) == 1 else "mixed", **counts}
