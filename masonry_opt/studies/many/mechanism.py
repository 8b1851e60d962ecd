"""Names of mechanisms, by what their joints do."""

from __future__ import annotations

from typing import Any

from masonry_opt.answer.motion import joint_motion
from masonry_opt.answer.solution import Solution
from masonry_opt.problem.assembly import Assembly

#: Names of mechanisms. Joints that come apart give it its name where no other moves, and "none" is one whose
#: blocks move without a joint that slides, opens or crushes.
SLIDING, HINGING, CRUSHING, MIXED = "sliding", "hinging", "crushing", "mixed"
SEPARATING, NONE = "separating", "none"

_NAMES = {"slides": SLIDING, "hinges": HINGING, "crushes": CRUSHING}


def mechanism(assembly: Assembly, solution: Solution) -> dict[str, Any]:
    """Name of the mechanism, and how many joints slide, hinge, come apart and crush; empty without one."""
    if solution.d is None:
        return {}
    motion = joint_motion(assembly, solution)
    counts = {kind: int(getattr(motion, kind).sum()) for kind in (*_NAMES, "separates")}
    names = [name for kind, name in _NAMES.items() if counts[kind]]
    if not names:
        names = [SEPARATING if counts["separates"] else NONE]
    return {"mechanism": names[0] if len(names) == 1 else MIXED, **counts}
