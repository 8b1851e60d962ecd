"""Lines of results.csv that no solver made."""

from typing import Any

from masonry_opt.studies.compare.runs import COLUMNS


def line(**known: Any) -> dict[str, Any]:
    """A good line of a static run, but for what is given."""
    given: dict[str, Any] = dict.fromkeys(COLUMNS)
    given |= {"scene": "made/up", "content": "c", "versions": "v", "method": "static", "model": "cvxpy"}
    given |= {"solver": "clarabel", "tolerance": 1e-8, "repeat": 1, "ended": "finished", "status": "optimal"}
    given |= {
        "message": "",
        "kind": "associative",
        "existence": "",
        "crushing": "",
        "friction_law": "",
        "load_factor": 1.0,
        "equilibrium": 0.0,
        "yield": 0.0,
        "flow": 0.0,
    }
    given |= {"complementarity": 0.0, "wall": 1.0, "peak_memory": 100.0, "joints": 100.0, "blocks": 50.0}
    given |= {"lp_solves": 1.0, "nlp_solves": 0.0, "iterations": 9.0, "time_limit": 60.0, "memory_limit": 4e3}
    kinds = {"static": "associative", "kinematic": "associative", "nonassociative": "loop"}
    kinds |= {"mcp": "one pass", "mpec": "relaxed"}
    kind = kinds.get(known.get("method", given["method"]), "exact")
    return given | {"kind": kind} | known
