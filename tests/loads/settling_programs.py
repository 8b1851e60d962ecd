"""Second formulations of supports that settle, from geometry alone. Nothing of the package is used here.

Blocks are upright rectangles (left, right, bottom, top), or voussoirs of an arch; the weight of a rectangle
is its area. Forces of a joint are a normal force at either end and a shear; flow is associative.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.optimize import linprog

Rectangle = tuple[float, float, float, float]


def reactions(
    blocks: Mapping[str, Rectangle],
    fixed: Sequence[str],
    settling: Sequence[str],
    friction: float,
    direction: tuple[float, float] = (0.0, -1.0),
) -> tuple[float, float]:
    """Least and greatest sum of the reactions of some fixed blocks against a direction."""
    names = [name for name in blocks if name not in fixed]
    row = {name: 3 * number for number, name in enumerate(names)}
    columns, reaction = [], []
    everyone = list(blocks)
    for number, below in enumerate(everyone):
        for above in everyone[number + 1 :]:
            if below in fixed and above in fixed:
                continue
            for ends, normal in _shared(blocks[below], blocks[above]):
                along = np.array([-normal[1], normal[0]])
                for point, unit in ((ends[0], normal), (ends[1], normal), (ends[0], along)):
                    column, pressed = np.zeros(3 * len(names)), 0.0
                    for name, force in ((above, unit), (below, -unit)):
                        if name in row:
                            arm = point - _centre(blocks[name])
                            moment = arm[0] * force[1] - arm[1] * force[0]
                            column[row[name] : row[name] + 3] += [*force, moment]
                        elif name in settling:
                            pressed += float(force @ direction)
                    columns.append(column)
                    reaction.append(pressed)
    equilibrium = np.array(columns).T
    load = np.zeros(3 * len(names))
    for name in names:
        left, right, bottom, top = blocks[name]
        load[row[name] + 1] = (right - left) * (top - bottom)
    joints = len(columns) // 3
    limits = np.zeros((2 * joints, len(columns)))
    for joint in range(joints):
        for sign in (0, 1):
            limits[2 * joint + sign, 3 * joint : 3 * joint + 3] = [-friction, -friction, 1 - 2 * sign]
    bounds = [(0, None), (0, None), (None, None)] * joints
    yields = {"A_ub": limits, "b_ub": np.zeros(len(limits))}
    return _least_and_greatest(np.array(reaction), **yields, A_eq=equilibrium, b_eq=load, bounds=bounds)


def _shared(one: Rectangle, other: Rectangle) -> list[tuple[np.ndarray, np.ndarray]]:
    """Ends of the length that two rectangles share, and the unit normal from the first into the second."""
    found = []
    for axis, (a, b) in enumerate(((one, other), (one, other))):
        near, far = a[2 * axis : 2 * axis + 2], b[2 * axis : 2 * axis + 2]
        across_a, across_b = a[2 - 2 * axis : 4 - 2 * axis], b[2 - 2 * axis : 4 - 2 * axis]
        low, high = max(across_a[0], across_b[0]), min(across_a[1], across_b[1])
        if high - low < 1e-9:
            continue
        for at, sign in ((near[1], 1.0), (near[0], -1.0)):
            if abs(at - far[0 if sign > 0 else 1]) < 1e-9:
                ends, normal = np.zeros((2, 2)), np.zeros(2)
                ends[:, axis], ends[:, 1 - axis], normal[axis] = at, (low, high), sign
                found.append((ends, normal))
    return found


def _centre(block: Rectangle) -> np.ndarray:
    left, right, bottom, top = block
    return np.array([(left + right) / 2, (bottom + top) / 2])


def thrusts(
    voussoirs: Sequence[np.ndarray],
    unit_weight: float,
    friction: float,
    pivot: tuple[float, float] | None = None,
    motion: np.ndarray | None = None,
) -> tuple[float, float] | None:
    """Least and greatest horizontal thrust of an arch on two supports, None if there is none: a search among
    lines of thrust.

    Unknown are the force and the moment at the first springing; statics give the resultant in each joint.

    Parameters
    ----------
    voussoirs: corners of each from the first springing on, shape (4, 2): inner and outer corner of its first
        joint, then outer and inner corner of its second.
    pivot: the point about which the second support turns freely; None: it does not turn.
    motion: centroid, velocity and rotation of the first support, the voussoirs and the second support, shape
        (voussoirs + 2, 5), with which the thrust is to go by Coulomb's law: what opens carries nothing, and
        what slides all its friction.
    """
    state = np.eye(3, 4)  # force and moment about the origin, of what is behind a joint: three unknowns, 1
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
    """Inner and outer corner of each joint."""
    return [*(corners[:2] for corners in voussoirs), voussoirs[-1][[3, 2]]]


def _moving(voussoirs: Sequence[np.ndarray], motion: np.ndarray) -> np.ndarray:
    """Whether each joint opens at its outer and at its inner corner, and slides inwards or outwards, in this
    order. What overlaps is no motion."""
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
