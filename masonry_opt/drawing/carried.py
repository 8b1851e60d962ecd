"""What joints carry: resultants where they act, lines of thrust, and utilisation."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import shapely

from masonry_opt.answer.outcome import Outcome
from masonry_opt.answer.thresholds import IDLE as CARRIES_NOTHING
from masonry_opt.drawing.colours import AT_POINT, IDLE, THRUST, UTILISATION
from masonry_opt.drawing.marks import Marks, joint_marks
from masonry_opt.problem.assembly import Assembly
from masonry_opt.scene.rows import linked

#: Blocks in a row, each between two others, from which their points of thrust make a line.
_CHAIN = 3

#: Length of the longest resultant, and height of the scale over the blocks, over the size of the scene.
_LONGEST, _ABOVE = 0.12, 0.08

#: That length in space, where one joint may carry most.
_LONGEST_IN_SPACE = 0.3


def thrust(result: Outcome) -> tuple[np.ndarray, np.ndarray]:
    """Resultants on the joints' first blocks in the case's unit of force, and the points where they act, at
    m / n from the middle, in the case's coordinates, each of shape (c, 2).

    NaN without forces; points are NaN too where nothing presses the joint together.
    """
    joints, frame = result.assembly.joints, result.joints
    n, s, m = (frame[name].to_numpy() for name in ("n", "s", "m"))
    # The direction of s: from the start of a joint that has length to its end.
    along = np.column_stack([joints.normal[:, 1], -joints.normal[:, 0]])
    force = n[:, None] * joints.normal + s[:, None] * along
    pressed = n > CARRIES_NOTHING * np.abs(n).max(initial=0.0)
    off = np.divide(m, n, out=np.full_like(n, np.nan), where=pressed)
    return force, frame[["x", "y"]].to_numpy() + off[:, None] * along


def chains(assembly: Assembly, acts: np.ndarray) -> np.ndarray:
    """Pairs of joints that a line of thrust joins, shape (pairs, 2): those of blocks that have two joints,
    both pressed, in rows of at least three.

    Parameters
    ----------
    acts: whether each joint is pressed together, shape (c,).
    """
    joints, count = assembly.joints, len(assembly.scene.blocks)
    sides = np.concatenate([joints.first, joints.second])
    number = np.tile(np.arange(len(joints.first)), 2)
    between = np.bincount(sides, minlength=count) == 2
    between &= np.bincount(sides[acts[number]], minlength=count) == 2
    movable = np.zeros(count, dtype=bool)
    movable[assembly.movable] = True
    between &= movable
    along = between[joints.first] & between[joints.second]
    row = linked(count, joints.first[along], joints.second[along])
    in_chain = between & (np.bincount(row)[row] >= _CHAIN)
    order = np.argsort(sides, kind="stable")
    return number[order][in_chain[sides[order]]].reshape(-1, 2)


def thrust_marks(result: Outcome, size: float, shrink: float) -> Iterable[Marks]:
    """The line of thrust through rows of blocks that have two joints, resultants, and their scale.

    Along a line only the resultants on supports are drawn: they say how large all are.
    """
    assembly, joints = result.assembly, result.assembly.joints
    force, point = thrust(result)
    acts = np.isfinite(point).all(axis=1)
    point, pairs = point - assembly.geometry.origin, chains(assembly, acts)
    on_line = np.isin(np.arange(len(acts)), pairs)
    if len(pairs):
        at = point[on_line][:, None]
        yield Marks("line", "line of thrust", "line", THRUST, 1.8 * shrink, point[pairs])
        yield Marks("points", "line of thrust", "point", THRUST, 3.2 * shrink, at)
    on_support = ~(np.isin(joints.first, assembly.movable) & np.isin(joints.second, assembly.movable))
    shown = acts & (~on_line | on_support)
    if not shown.any():
        return
    most = float(np.hypot(*force[shown].T).max())
    unit = _LONGEST * size / most
    half, at = unit * force[shown] / 2, point[shown]
    who = "on a support" if len(pairs) and on_support[shown].all() else "of a joint"
    label = f"resultant {who}, in the case's unit of force"
    width = float(np.clip(25 / np.sqrt(len(at)), 0.8, 1.6))
    yield Marks("resultants", label, "line", THRUST, width, np.stack([at - half, at + half], axis=1))
    yield Marks("points", "", "point", THRUST, 1.8 * width, at[:, None])
    power = 10.0 ** np.floor(np.log10(most))
    scale = max(digit * power for digit in (1, 2, 5) if digit * power <= most)
    left, _, _, top = shapely.total_bounds(assembly.geometry.polygons[assembly.movable])
    start = np.array([left, top + _ABOVE * size])
    ends = np.array([[start, start + np.array([scale * unit, 0.0])]])
    yield Marks("scale", "", "bar", THRUST, 1.6, ends, text=f"= {scale:g}")


def resultant_marks(result: Outcome, size: float, shrink: float) -> Iterable[Marks]:
    """Resultants of joints in space and, thinner, the forces at their contact points, half to each side of
    where they act."""
    frame, points, origin = result.joints, result.contacts, result.assembly.geometry.origin
    force, point = (frame[[f"{kind}{axis}" for axis in "xyz"]].to_numpy() for kind in "fp")
    acts = np.isfinite(point).all(axis=1)
    if not acts.any():
        return
    force, point = force[acts], point[acts] - origin
    most = float(np.linalg.norm(force, axis=1).max())
    unit = _LONGEST_IN_SPACE * size / most
    assert points is not None
    carried = points[["fx", "fy", "fz"]].to_numpy()
    carries = np.linalg.norm(carried, axis=1) > CARRIES_NOTHING * most
    at, part = points[["x", "y", "z"]].to_numpy()[carries] - origin, unit * carried[carries] / 2
    width = float(np.clip(25 / np.sqrt(len(at)), 0.4, 1.0))
    ends = np.stack([at - part, at + part], axis=1)
    yield Marks("contacts", "force at a contact point, one state of many", "line", AT_POINT, width, ends)
    half = unit * force / 2
    label = f"resultant of a joint; the longest is {most:.3g} in the case's unit of force"
    width = float(np.clip(25 / np.sqrt(len(point)), 0.8, 1.6))
    yield Marks("resultants", label, "line", THRUST, width, np.stack([point - half, point + half], axis=1))
    yield Marks("points", "", "point", THRUST, 1.8 * width, point[:, None])


def utilisation_marks(ends: np.ndarray, used: np.ndarray, shrink: float) -> Iterable[Marks]:
    """Joints in the colours of their utilisation, the most used last; idle ones thin.

    Parameters
    ----------
    ends: of the joints, or in space of the sides of their outlines, shape (lines, 2, 2) or (lines, 2, 3).
    used: utilisation of the joint of each, shape (lines,).
    """
    steps = len(UTILISATION)
    step = np.where(np.isnan(used), -1, np.clip(np.nan_to_num(used) * steps, 0, steps - 1)).astype(int)
    for number, colour in enumerate((IDLE, *UTILISATION), start=-1):
        label, name = ("idle joint", "idle") if number < 0 else ("", "used")
        # Wider too where more is used, for readers of grey prints.
        width = 1.6 if number < 0 else 2.0 + 1.6 * number / (steps - 1)
        lines = Marks(name, label, "line", colour, width * shrink, ends[step == number])
        yield from joint_marks(lines)
