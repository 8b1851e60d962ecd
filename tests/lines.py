"""Made-up lines of results.csv, without a run of a solver."""

from typing import Any

from masonry_opt.studies.compare.runs import COMPARISON_COLUMNS

#: A good line of a static run.
GOOD: dict[str, Any] = dict.fromkeys(COMPARISON_COLUMNS)
GOOD |= {"scene": "made/up", "content": "c", "versions": "v", "method": "static", "model": "cvxpy"}
GOOD |= {"solver": "clarabel", "tolerance": 1e-8, "repeat": 1, "ended": "finished", "status": "optimal"}
GOOD |= dict.fromkeys(("message", "existence", "crushing", "friction_law"), "")
GOOD |= dict.fromkeys(("equilibrium", "yield", "flow", "complementarity", "nlp_solves"), 0.0)
GOOD |= {
    "load_factor": 1.0,
    "load_factor_unit": 1.0,
    "wall": 1.0,
    "peak_memory": 100.0,
    "joints": 100.0,
    "blocks": 50.0,
}
GOOD |= {"lp_solves": 1.0, "iterations": 9.0, "time_limit": 60.0, "memory_limit": 4e3}
KINDS = {"static": "associative", "kinematic": "associative", "nonassociative": "loop"}
KINDS |= {"coulomb": "nearly complementary", "mpec": "relaxed"}


def line(**known: Any) -> dict[str, Any]:
    """Return a good line with the given entries changed."""
    kind = KINDS.get((GOOD | known)["method"], "exact")
    return GOOD | {"kind": kind} | known
