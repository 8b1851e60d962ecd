"""Tables of a solution: a row a block, a row a joint, with names and in the case's units."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pandas as pd

from masonry_opt.answer import space_frames
from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.motion import joint_motion
from masonry_opt.answer.solution import GivingState, Solution
from masonry_opt.answer.status import Status
from masonry_opt.answer.thresholds import IDLE
from masonry_opt.problem.assembly import Assembly, SpaceAssembly
from masonry_opt.problem.chords import parabola
from masonry_opt.problem.problem import Problem, ShearLimits


def unsigned(frame: pd.DataFrame) -> pd.DataFrame:
    """The same frame, without a minus before any zero of its real numbers."""
    numbers = frame.select_dtypes("float64").columns
    return frame.assign(**{str(name): frame[name] + 0.0 for name in numbers})


def history_frame(solution: Solution) -> pd.DataFrame:
    """A row a step of the method."""
    return unsigned(pd.DataFrame(solution.history).drop(columns="solved", errors="ignore"))


def block_frame(assembly: Assembly, solution: Solution) -> pd.DataFrame:
    """A row a movable block: its centroid, and its velocities (NaN without a mechanism)."""
    problem, shapes = assembly.problem, assembly.geometry
    centroid = shapes.centroid[assembly.movable] + shapes.origin
    d = np.full(problem.dead.shape, np.nan) if solution.d is None else solution.d
    axes = "xyz"[: problem.layout.dimension]
    moves = [f"v{axis}" for axis in axes]
    turns = ["omega"] if len(axes) == 2 else [f"w{axis}" for axis in axes]
    columns = (
        *zip(axes, centroid.T, strict=True),
        *zip(moves, problem.forces(d).T, strict=True),
        *zip(turns, problem.moments(d).T / problem.length_unit, strict=True),
    )
    return unsigned(pd.DataFrame({"block": assembly.names(assembly.movable), **dict(columns)}))


def joint_frame(assembly: Assembly, solution: Solution) -> pd.DataFrame:
    """A row a joint: its blocks, middle and length, forces and rates (NaN without forces, or mechanism)."""
    if isinstance(assembly, SpaceAssembly):
        return unsigned(space_frames.joint_frame(assembly, solution))
    problem, joints = assembly.problem, assembly.joints
    nothing = np.full(problem.B.shape[1], np.nan)
    q = nothing if solution.q is None else solution.q
    u = nothing if solution.d is None else problem.B.T @ solution.d
    n, s, m = problem.by_kind(q)
    m = np.where(problem.in_a_point, 0.0, m)
    opening, slip, rotation = problem.by_kind(u)
    if solution.d is not None:
        turning = np.zeros(len(assembly.scene.blocks))
        turning[assembly.movable] = problem.moments(solution.d)[:, 0]
        rotation = turning[joints.first] - turning[joints.second]
    force, length = problem.force_unit, problem.length_unit
    middle = joints.middle + assembly.geometry.origin
    return unsigned(
        pd.DataFrame(
            {
                "first": assembly.names(joints.first),
                "second": assembly.names(joints.second),
                "x": middle[:, 0],
                "y": middle[:, 1],
                "length": joints.extent,
                "n": n * force,
                "s": s * force,
                "m": m * force * length,
                "slip": slip,
                "opening": opening,
                "rotation": rotation / length,
                "utilisation": _utilisation(problem, q),
            }
        )
    )


def contact_frame(assembly: Assembly, solution: Solution) -> pd.DataFrame | None:
    """A row a contact point of a scene in space; None in the plane."""
    if isinstance(assembly, SpaceAssembly):
        return unsigned(space_frames.contact_frame(assembly, solution))
    return None


def curve_frame(assembly: Assembly, states: Iterable[GivingState]) -> pd.DataFrame:
    """A row a state of contacts that give less and less; joints that start are those of no row before."""
    problem = assembly.problem
    rows, started = [], np.zeros((2, len(assembly.joints.first)), dtype=bool)
    # In the plane velocities are scaled by a sum over components, which depends on the axes: a displacement
    # must not.
    work = problem.live_norm / (problem.force_sizes(problem.live).sum() or problem.live_norm)
    for state in states:
        solution = Solution(Status.CONVERGED, Kind.COMPLIANT, found=state.answer)
        motion = joint_motion(replace(assembly, problem=state.problem), solution)
        n = state.problem.normal_forces(state.answer.q)
        # Joints without force slip as they please.
        pressed = assembly.most_of_joints(n > IDLE * np.abs(n).max(initial=0.0))
        moves = np.stack([motion.slides & pressed, motion.hinges | motion.separates])
        slide, part = (assembly.pairs_of(joints) for joints in moves & ~started)
        started |= moves
        rows.append(
            {
                "displacement": work / state.give,
                "load_factor": state.answer.load_factor,
                "give": state.give,
                "sliding": int(moves[0].sum()),
                "opening": int(moves[1].sum()),
                "starts_sliding": slide,
                "starts_opening": part,
            }
        )
    return pd.DataFrame(rows)


def _utilisation(problem: Problem, q: np.ndarray) -> np.ndarray:
    """Largest of |s| over the true Coulomb limit, of |m| over n L/2 (less what crushing takes), and of n over
    f_c L; NaN where a joint is idle."""
    n, s, m = problem.by_kind(q)
    m = np.where(problem.in_a_point, 0.0, np.abs(m) / problem.half_length)
    nothing = IDLE * (np.abs(n).max() or 1.0)  # no limit is taken for smaller
    limit = ShearLimits.true(problem).at(n[problem.sliding])
    most = n.copy()
    most[problem.crushing] = parabola(n[problem.crushing], problem.crushing_force)
    used = m / np.maximum(most, nothing)
    used[problem.crushing] = np.maximum(used[problem.crushing], n[problem.crushing] / problem.crushing_force)
    shear = np.abs(s[problem.sliding]) / np.maximum(limit, nothing)
    used[problem.sliding] = np.maximum(used[problem.sliding], shear)
    return np.where(np.stack([np.abs(n), np.abs(s), m]).max(axis=0) <= nothing, np.nan, used)
