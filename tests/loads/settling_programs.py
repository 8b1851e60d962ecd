"""Second formulations of supports that settle under associative flow: joint forces and lines of thrust.

The programs of joint forces are those of `second_program`. Lines of thrust in arches use geometry alone.
"""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from scipy.optimize import Bounds, LinearConstraint, linprog, milp
from second_program import program

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import Problem


def reactions(
    scene: mo.Scene, settling: Sequence[str], direction: tuple[float, float] = (0.0, -1.0)
) -> tuple[float, float]:
    """Return the least and the greatest sum of the reactions of some supports against a direction."""
    assembly = assemble(scene)
    problem, joints = assembly.problem, assembly.joints
    statics, rows, limits = program(assembly, inside=True)
    along = np.column_stack([joints.normal[:, 1], -joints.normal[:, 0]])
    settles = np.array([block.name in settling for block in scene.blocks], dtype=float)
    # Joint forces act on the first block along `normal` and `along`, and on the second block against them.
    sign = settles[joints.first] - settles[joints.second]
    normal, shear = (sign * (of @ direction) for of in (joints.normal, along))
    # In these scenes, ties and props connect movable blocks: none of them ends in a support.
    limited = np.zeros(len(assembly.limited))
    found = _least_and_greatest(
        np.concatenate([normal, normal, shear, limited]),
        A_ub=-rows,
        b_ub=limits,
        A_eq=statics,
        b_eq=-problem.dead,
        bounds=[(None, None)] * statics.shape[1],
    )
    return found[0] * problem.force_unit, found[1] * problem.force_unit


def exact_load_factors(problem: Problem, low: float, high: float) -> tuple[float, float] | None:
    """Return the least and the greatest load factor of exact Coulomb states between `low` and `high`.

    The program has one binary for each face: 0 at yield and 1 at rest. HiGHS solves it by branch and bound.
    The matrices are the package's. States with a slack or rate above 200, in the problem's units, are not
    counted. Returns None if there are no states.
    """
    (rows, forces), faces, most = problem.B.shape, problem.faces, 200.0
    free, one = np.full(forces, np.inf), sp.eye_array(faces)

    def row(load_factor=None, q=None, d=None, p=None, resting=None):
        """Return the blocks of one row of the program side by side; a block that is None is zero."""
        given = (load_factor, q, d, p, resting)
        height = next(block.shape[0] for block in given if block is not None)
        widths = (1, forces, rows, faces, faces)
        blocks = zip(given, widths, strict=True)
        return sp.hstack(
            [sp.csr_array((height, width)) if block is None else block for block, width in blocks]
        )

    live, no_limit = sp.csr_array(problem.live), np.full(faces, np.inf)
    given = [
        (row(live.reshape((-1, 1)), problem.B), -problem.dead, -problem.dead),
        (row(q=problem.true_yield), -problem.face_cohesion, no_limit),
        (row(q=problem.true_yield, resting=-most * one), -no_limit, -problem.face_cohesion),
        (row(p=one, resting=most * one), -no_limit, np.full(faces, most)),
        (row(d=problem.B.T, p=-problem.D(problem.dilatancy)), np.zeros(forces), np.zeros(forces)),
        (row(d=live.reshape((1, -1))), [problem.live_norm], [problem.live_norm]),
    ]
    bounds = Bounds(
        np.concatenate([[low], -free, np.full(rows, -np.inf), np.zeros(2 * faces)]),
        np.concatenate([[high], free, np.full(rows, np.inf), np.full(faces, most), np.ones(faces)]),
    )
    conditions = [LinearConstraint(*each) for each in given]
    integrality = np.concatenate([np.zeros(1 + forces + rows + faces), np.ones(faces)])
    cost = np.eye(1, len(integrality))[0]
    program = {"constraints": conditions, "bounds": bounds, "integrality": integrality}
    least = milp(cost, **program)
    if least.status == 2:  # No state exists, so the greatest need not be computed.
        return None
    greatest = milp(-cost, **program)
    assert (least.status, greatest.status) == (0, 0)
    return least.fun, -greatest.fun


def thrusts(
    voussoirs: Sequence[np.ndarray],
    unit_weight: float,
    friction: float,
    pivot: tuple[float, float] | None = None,
    motion: np.ndarray | None = None,
) -> tuple[float, float] | None:
    """Return the least and the greatest horizontal thrust of an arch on two supports, by lines of thrust.

    The force and the moment at the first springing are unknown; statics give the resultant in each joint.
    Returns None if no line of thrust exists.

    Parameters
    ----------
    voussoirs: corners of each voussoir from the first springing on, shape (4, 2): the inner and the outer
        corner of its first joint, then the outer and the inner corner of its second joint.
    pivot: the point about which the second support turns freely. If None, the support does not turn.
    motion: centroid, velocity and rotation of the first support, the voussoirs and the second support, shape
        (voussoirs + 2, 5). The thrust then obeys Coulomb's law for this motion: a joint carries nothing where
        it opens, and all of its friction where it slides.
    """
    # Force and moment of the part behind a joint, about the origin: coefficients of the three unknowns and of
    # 1.
    state = np.eye(3, 4)
    rows = []
    for number, (inner, outer) in enumerate(_springings(voussoirs)):
        middle, thickness = (inner + outer) / 2, np.linalg.norm(outer - inner)
        along = (outer - inner) / thickness
        ahead = np.array([along[1], -along[0]])
        n, s = ahead @ state[:2], along @ state[:2]
        m = state[2] - (middle[0] * state[1] - middle[1] * state[0])
        rows += [m - thickness / 2 * n, -m - thickness / 2 * n, s - friction * n, -s - friction * n]
        if number < len(voussoirs):
            x, y = voussoirs[number].T
            cross = x * np.roll(y, -1) - y * np.roll(x, -1)
            weight = unit_weight * abs(cross.sum()) / 2
            state[1:, 3] -= weight * np.array([1.0, (x + np.roll(x, -1)) @ cross / (3 * cross.sum())])
    limits = np.array(rows)
    equal = np.zeros((0, 4)) if motion is None else limits[_moving(voussoirs, motion)]
    if pivot is not None:
        equal = np.vstack([equal, state[2] - (pivot[0] * state[1] - pivot[1] * state[0])])
    return _least_and_greatest(
        np.eye(3)[0],
        A_ub=limits[:, :3],
        b_ub=-limits[:, 3],
        A_eq=equal[:, :3],
        b_eq=-equal[:, 3],
        bounds=[(None, None)] * 3,
    )


def _springings(voussoirs: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return the inner and the outer corner of each joint."""
    return [*(corners[:2] for corners in voussoirs), voussoirs[-1][[3, 2]]]


def _moving(voussoirs: Sequence[np.ndarray], motion: np.ndarray) -> np.ndarray:
    """Return four flags per joint: opens at its outer corner, opens at its inner corner, slides inwards,
    slides outwards.

    Rates are compared with the fastest. A motion in which joints overlap raises AssertionError.
    """
    rates = []
    for behind, ahead, (inner, outer) in zip(motion, motion[1:], _springings(voussoirs), strict=False):
        along = (outer - inner) / np.linalg.norm(outer - inner)
        apart = [_velocity(ahead, corner) - _velocity(behind, corner) for corner in (outer, inner)]
        slip = apart[0] @ along
        rates += [*(velocity @ [along[1], -along[0]] for velocity in apart), -slip, slip]
    found = np.array(rates) / np.abs(rates).max()
    assert found.reshape(-1, 4)[:, :2].min() > -1e-6
    moving: np.ndarray = found > 1e-6
    return moving


def _velocity(of: np.ndarray, corner: np.ndarray) -> np.ndarray:
    x, y = corner - of[:2]
    velocity: np.ndarray = of[2:4] + of[4] * np.array([-y, x])
    return velocity


def _least_and_greatest(cost: np.ndarray, **program: object) -> tuple[float, float] | None:
    found = [linprog(sign * cost, **program, method="highs") for sign in (1, -1)]
    if [each.status for each in found] == [2, 2]:
        return None
    assert all(each.status == 0 for each in found)
    return found[0].fun, -found[1].fun
