"""What a mechanism is called: by sliding, by hinging, by both."""

from __future__ import annotations

from typing import Any

from masonry_opt.answer.motion import joint_motion
from masonry_opt.answer.solution import Solution
from masonry_opt.problem.assembly import Assembly

#: What mechanisms are called; "none" where blocks move without a joint that slides, opens or crushes.
SLIDING, HINGING, CRUSHING, MIXED = "sliding", "hinging", "crushing", "mixed"
SEPARATING, NONE = "separating", "none"


def mechanism(assembly: Assembly, solution: Solution) -> dict[str, Any]:
    """What the mechanism is called, and how many joints slide, hinge, come apart and crush; empty without
    one."""
    if solution.d is None:
        return {}
    motion = joint_motion(assembly, solution)
    counts = {kind: int(getattr(motion, kind).sum()) for kind in ("slides", "hinges", "separates", "crushes")}
    return {"mechanism": _name(**counts), **counts}


def _name(slides: int, hinges: int, separates: int, crushes: int) -> str:
    done = [name for name, count in ((SLIDING, slides), (HINGING, hinges), (CRUSHING, crushes)) if count]
    if len(done) > 1:
        return MIXED
    if done:
        return done[0]
    return SEPARATING if separates else NONE
