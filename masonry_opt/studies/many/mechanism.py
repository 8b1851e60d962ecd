"""What a mechanism is called: by sliding, by hinging, by both."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from masonry_opt.answer.solution import Solution
from masonry_opt.problem.assembly import Assembly

#: What mechanisms are called; "none" where blocks move without a joint that slides or opens.
SLIDING, HINGING, MIXED, SEPARATING, NONE = "sliding", "hinging", "mixed", "separating", "none"

#: Rates below this share of the fastest corner's velocity are nothing, as in a picture of the mechanism.
_STILL = 2e-3


def mechanism(assembly: Assembly, solution: Solution) -> dict[str, Any]:
    """What the mechanism is called, and how many joints slide, hinge and come apart; empty without one.

    A joint slides or hinges while an edge of it touches, but for the opening that the flow rule of the answer
    gives to sliding (associative flow: the friction); it may do both. It comes apart where neither edge does.
    """
    if solution.d is None:
        return {}
    problem, joints = assembly.problem, assembly.joints
    in_a_point = joints.length == 0
    half = np.where(in_a_point, problem.length_unit, joints.length / 2)
    slope = np.zeros(problem.joints)
    # Blocks that fall under dead load do so by associative flow.
    own = problem.friction if solution.load_factor is None else problem.dilatancy
    slope[problem.sliding] = own if solution.slope is None else solution.slope
    opening, slip, _ = (problem.B.T @ solution.d).reshape(3, -1)
    opening, slip = opening - slope * np.abs(slip), np.abs(slip)
    omega = np.zeros(len(assembly.scene.blocks))
    omega[assembly.movable] = solution.d[2::3] / problem.length_unit
    turning = np.abs(omega[joints.first] - omega[joints.second]) * half
    still = _STILL * _fastest(assembly, solution.d)
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


def _fastest(assembly: Assembly, d: np.ndarray) -> float:
    """Speed of the fastest corner under block velocities (3b,); 1 where nothing moves."""
    movable, shapes = assembly.movable, assembly.geometry
    corners, block = shapely.get_coordinates(shapes.polygons[movable], return_index=True)
    vx, vy, omega = d.reshape(-1, 3)[block].T
    x, y = (corners - shapes.centroid[movable[block]]).T / assembly.problem.length_unit
    return float(np.hypot(vx - omega * y, vy + omega * x).max()) or 1.0
