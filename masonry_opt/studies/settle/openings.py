"""Openings of joints in the mechanism of supports that settle, per unit of the supports' movement."""

import numpy as np
import pandas as pd

from masonry_opt.reporting.names import some
from masonry_opt.reporting.sentences import numeral
from masonry_opt.result import Result
from masonry_opt.scene.positions import in_scene
from masonry_opt.solution.frames import unsigned
from masonry_opt.solution.motion import fastest, joint_motion
from masonry_opt.solution.thresholds import MOVES, NEGLIGIBLE_SHARE

#: A movement is rejected if it rotates a block by more than this angle, in radians. Openings are calculated
#: for small rotations, with a relative error about as large as the rotation.
SMALL_ROTATION = 0.1


def after_movement(movement: float | None) -> str:
    """Return a phrase that states for which movement of the supports openings are reported."""
    if movement is None:
        return "per unit of the support's movement"
    return f"after a movement of {numeral(movement, '.6g')}, in the length unit of the case"


def in_words(openings: pd.DataFrame, movement: float | None) -> str:
    """Return a text that lists the largest openings at the least reaction.

    The openings are lengths after a movement, or per unit of the support's movement if it is None.
    """
    scale = 1.0 if movement is None else movement
    widths = scale * openings[["opening", "sliding"]].max(axis=1)
    joints = zip(openings["first"], openings["second"], widths, strict=True)
    listed = some([f"'{first}'–'{second}' {numeral(width, '.3g')}" for first, second, width in joints])
    return f"{after_movement(movement)}, at the least reaction: {listed}"


def joint_openings(result: Result) -> pd.DataFrame:
    """Return a table of the joints that open or slide in the mechanism of a result.

    The table is empty if no support moves in the mechanism.
    """
    assembly, solution = result.assembly, result.solution
    problem, joints = assembly.problem, assembly.joints
    columns = ["joint", "first", "second", *"xyz"[: assembly.scene.dimension], "opening", "sliding"]
    movement = movement_of_supports(result) if has_mechanism(result) else 0.0
    if not movement:
        return pd.DataFrame(columns=columns)
    assert solution.d is not None
    rates, rounding = problem.motion(solution.d), NEGLIGIBLE_SHARE * fastest(assembly, solution.d)
    gap = np.empty(len(joints.joint))  # opening rate of each contact point
    gap[assembly.pressed] = problem.at_points(rates)
    slip = np.hypot.reduce(np.abs(problem.shears(rates)), axis=0)
    widest = pd.Series(gap).groupby(joints.joint).idxmax().to_numpy()
    motion = joint_motion(assembly, solution)
    moves = np.flatnonzero(motion.slides | motion.hinges | motion.separates)
    opening, sliding = gap[widest], joints.most(slip[assembly.of_point])
    opening = np.where(opening > rounding, opening, 0.0)[moves] / movement
    sliding = np.where(sliding > rounding, sliding, 0.0)[moves] / movement
    first, second = np.array(assembly.pairs_of(moves), dtype=object).reshape(-1, 2).T
    at = in_scene(assembly.geometry, joints.point[widest[moves]])
    frame = pd.DataFrame(dict(zip(columns, (moves, first, second, *at.T, opening, sliding), strict=True)))
    widths = frame[["opening", "sliding"]].max(axis=1).sort_values(ascending=False, kind="stable")
    return unsigned(frame.loc[widths.index]).reset_index(drop=True)


def has_mechanism(result: Result) -> bool:
    """Return True if a result has a mechanism at a load factor."""
    return result.solution.d is not None and result.solution.load_factor is not None


def movement_of_supports(result: Result) -> float:
    """Return the velocity with which the supports move in a mechanism; 0 if they are at rest."""
    # The live load acts only on the supports, in the direction of their movement, and all supports move at
    # one velocity. The power of the live load is therefore this velocity times the sum of its force
    # magnitudes.
    problem, d = result.assembly.problem, result.solution.d
    assert d is not None
    movement = float(problem.live @ d) / float(problem.force_sizes(problem.live).sum())
    return movement if abs(movement) > MOVES * fastest(result.assembly, d) else 0.0


def largest_movement(result: Result) -> float:
    """Return the largest movement of the supports for which the calculated openings are accurate.

    Openings are calculated for small rotations of the blocks.
    """
    movement = movement_of_supports(result) if has_mechanism(result) else 0.0
    if not movement:
        return np.inf
    assert result.solution.d is not None
    problem = result.assembly.problem
    rotations = np.abs(problem.moments(result.solution.d)) / problem.length_unit
    rate = float(rotations.max(initial=0.0)) / movement
    return SMALL_ROTATION / rate if rate > 0 else np.inf
