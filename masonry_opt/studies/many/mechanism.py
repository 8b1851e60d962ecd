"""What a mechanism is called: by sliding, by hinging, by both."""

from __future__ import annotations

from typing import Any

import numpy as np

from masonry_opt.answer.result import Result
from masonry_opt.report.motion import STILL, fastest

#: What mechanisms are called; "none" where blocks move without a joint that slides or opens.
SLIDING, HINGING, MIXED, SEPARATING, NONE = "sliding", "hinging", "mixed", "separating", "none"


def mechanism(result: Result) -> dict[str, Any]:
    """What the mechanism is called, and how many joints slide, hinge and come apart; empty without one.

    A joint slides or hinges while an edge of it touches, but for the opening that the flow rule of the answer
    gives to sliding (associative flow: the friction); it may do both. It comes apart where neither edge does.
    """
    solution, problem, joints = result.solution, result.assembly.problem, result.assembly.joints
    if solution.d is None:
        return {}
    in_a_point = joints.length == 0
    half = np.where(in_a_point, problem.length_unit, joints.length / 2)
    slope = np.zeros(problem.joints)
    # Blocks that fall under dead load do so by associative flow.
    own = problem.friction if solution.load_factor is None else problem.dilatancy
    slope[problem.sliding] = own if solution.slope is None else solution.slope
    slip, turning = (
        np.abs(result.joints["slip"].to_numpy()),
        np.abs(result.joints["rotation"].to_numpy()) * half,
    )
    opening = result.joints["opening"].to_numpy() - slope * slip
    still = STILL * fastest(result)
    touches = opening - np.where(in_a_point, 0.0, turning) <= still
    slides = int((touches & (slip > still)).sum())
    hinges = int((touches & (turning > still)).sum())
    separates = int((~touches).sum())
    return {
        "mechanism": _name(slides, hinges, separates),
        "slides": slides,
        "hinges": hinges,
        "separates": separates,
    }


def _name(slides: int, hinges: int, separates: int) -> str:
    if slides and hinges:
        return MIXED
    if slides or hinges:
        return SLIDING if slides else HINGING
    return SEPARATING if separates else NONE
