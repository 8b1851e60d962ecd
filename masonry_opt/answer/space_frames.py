"""Tables of joints and contact points in space, with names and in the case's units."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd

from masonry_opt.answer.motion import fastest, relative_rotation, velocities
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import HINGES, IDLE
from masonry_opt.problem.assembly import SpaceAssembly
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.scene.space.frames import dots, lengths
from masonry_opt.scene.space.surfaces import sums


class _OfPoints(NamedTuple):
    """Forces on the first block and its motion against the second at each contact point, shape (points, 3);
    normal forces, and forces over their limits, shape (points,). NaN where not found; in the problem's
    units."""

    force: np.ndarray
    motion: np.ndarray
    n: np.ndarray
    utilisation: np.ndarray


def joint_frame(assembly: SpaceAssembly, solution: Solution) -> pd.DataFrame:
    """A row a joint: its blocks, centroid, area and normal, resultants and rates (NaN without forces, or
    mechanism)."""
    contacts, of, force = assembly.joints, _of_points(assembly, solution), assembly.problem.force_unit
    length, joint, normal = assembly.problem.length_unit, contacts.joint, contacts.normal
    middle, count = contacts.middle, len(contacts.first)
    resultant, n = sums(joint, of.force, count), np.bincount(joint, of.n)
    pressed = n > IDLE * np.nanmax(n, initial=0.0)
    share = (of.n / np.where(pressed, n, np.inf)[joint])[:, None]
    acts = np.where(pressed[:, None], sums(joint, share * contacts.point, count), np.nan)
    # About the centroid where nothing presses.
    about = np.where(pressed[:, None], acts, middle)[joint]
    torsion = np.bincount(joint, dots(normal[joint], np.cross(contacts.point - about, of.force)))
    motion, turned, on_axis = _rates(assembly, solution, middle)
    opening = dots(motion, normal)
    used = assembly.most_of_joints(np.nan_to_num(of.utilisation, nan=-1.0))
    origin = assembly.geometry.origin
    return pd.DataFrame(
        {
            "first": assembly.names(contacts.first),
            "second": assembly.names(contacts.second),
            **_columns("", middle + origin),
            "area": contacts.extent,
            **_columns("n", normal),
            "n": n * force,
            "s": lengths(resultant - n[:, None] * normal) * force,
            **_columns("f", resultant * force),
            **_columns("p", acts + origin),
            "torsion": torsion * force,
            "slip": lengths(motion - opening[:, None] * normal),
            "opening": opening,
            **_columns("v", motion),
            "rotation": lengths(turned) / length,
            **_columns("w", turned / length),
            **_columns("a", on_axis + origin),
            "utilisation": np.where(used < 0, np.nan, used),
        }
    )


def contact_frame(assembly: SpaceAssembly, solution: Solution) -> pd.DataFrame:
    """A row a contact point: its joint and blocks, forces and rates (NaN without forces, or mechanism)."""
    contacts, of, force = assembly.joints, _of_points(assembly, solution), assembly.problem.force_unit
    joint, normal = contacts.joint, contacts.normal[contacts.joint]
    opening = dots(of.motion, normal)
    return pd.DataFrame(
        {
            "joint": joint,
            "first": assembly.names(contacts.first[joint]),
            "second": assembly.names(contacts.second[joint]),
            **_columns("", contacts.point + assembly.geometry.origin),
            "n": of.n * force,
            "s": lengths(of.force - of.n[:, None] * normal) * force,
            **_columns("f", of.force * force),
            "slip": lengths(of.motion - opening[:, None] * normal),
            "opening": opening,
            **_columns("v", of.motion),
            "utilisation": of.utilisation,
        }
    )


def _columns(prefix: str, vectors: np.ndarray) -> dict[str, np.ndarray]:
    return {f"{prefix}{axis}": vectors[:, number] for number, axis in enumerate("xyz")}


def _of_points(assembly: SpaceAssembly, solution: Solution) -> _OfPoints:
    problem, contacts = assembly.problem, assembly.joints
    nothing = np.full(problem.B.shape[1], np.nan)
    q = nothing if solution.q is None else solution.q
    u = nothing if solution.d is None else problem.B.T @ solution.d
    normal, tangent = contacts.normal[contacts.joint], contacts.tangent[contacts.joint]
    axes = np.stack([normal, tangent, np.cross(normal, tangent)])
    force, motion = (np.einsum("kp,kpi->pi", problem.by_kind(of_kinds), axes) for of_kinds in (q, u))
    return _OfPoints(force, motion, problem.normal_forces(q), _utilisation(problem, q))


def _utilisation(problem: Problem, q: np.ndarray) -> np.ndarray:
    """|(s, t)| over the true Coulomb limit, by the cone; 0 where friction is unlimited, NaN where a point is
    idle."""
    n, *shears = problem.by_kind(q)
    s = np.hypot(*shears)
    nothing = IDLE * (np.abs(n).max() or 1.0)  # no limit is taken for smaller
    used, limit = np.zeros_like(n), ShearLimits.true(problem).at(n[problem.sliding])
    used[problem.sliding] = s[problem.sliding] / np.maximum(limit, nothing)
    return np.where(np.maximum(np.abs(n), s) > nothing, used, np.nan)


def _rates(
    assembly: SpaceAssembly, solution: Solution, middle: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Velocity of each joint's first block against the second at its middle, its rotation, and the point of
    the axis of both that is nearest to the middle (NaN where it does not turn), shape (joints, 3) each."""
    contacts, d = assembly.joints, solution.d
    if d is None:
        nothing = np.full((len(contacts.first), 3), np.nan)
        return nothing, nothing, nothing
    motion = velocities(assembly, d, contacts.first, middle) - velocities(
        assembly, d, contacts.second, middle
    )
    turned = relative_rotation(assembly, d)
    turns = (lengths(turned) > HINGES * fastest(assembly, d))[:, None]
    square = np.where(turns, dots(turned, turned)[:, None], 1.0)
    on_axis = middle + np.cross(turned, motion) / square * assembly.problem.length_unit
    return motion, turned, np.where(turns, on_axis, np.nan)
