"""What joints carry: resultants where they act, lines of thrust, and utilisation."""

from collections.abc import Iterable

import numpy as np
import shapely

from masonry_opt.answer.outcome import Outcome
from masonry_opt.answer.thresholds import IDLE as CARRIES_NOTHING
from masonry_opt.drawing.colours import AT_POINT, IDLE, THRUST, UTILISATION
from masonry_opt.drawing.marks import Marks, joint_marks, shrink_of, size_of
from masonry_opt.problem.assembly import Assembly
from masonry_opt.scene.rows import linked

_CHAIN = 3  #: Blocks in a row, each between two others, from which their points of thrust make a line.
_LONGEST = 0.12  #: Length of the longest resultant, over the size of the scene.
_LONGEST_IN_SPACE = 0.3  #: That length in space, where one joint may carry most.
_ABOVE = 0.08  #: Height of the scale over the blocks, over that size.


def thrust(result: Outcome) -> tuple[np.ndarray, np.ndarray]:
    """Resultants on the joints' first blocks in the case's unit of force, and the points where they act, in
    the plane at m / n from the middle, in the case's coordinates, each of shape (c, 2), in space (c, 3). NaN
    without forces; points are NaN too where nothing presses the joint together."""
    joints, frame = result.assembly.joints, result.joints
    if result.contacts is not None:
        force, point = (frame[[f"{kind}{axis}" for axis in "xyz"]].to_numpy() for kind in "fp")
        return force, point
    n, s, m = (frame[name].to_numpy() for name in ("n", "s", "m"))
    force = n[:, None] * joints.normal + s[:, None] * joints.tangent
    pressed = n > CARRIES_NOTHING * np.abs(n).max(initial=0.0)
    off = np.divide(m, n, out=np.full_like(n, np.nan), where=pressed)
    return force, frame[["x", "y"]].to_numpy() + off[:, None] * joints.tangent


def chains(assembly: Assembly, acts: np.ndarray) -> np.ndarray:
    """Pairs of joints that a line of thrust joins, shape (pairs, 2): those of blocks that have two joints,
    both pressed together, which ``acts`` tells, shape (c,), in rows of at least three."""
    joints, count = assembly.joints, len(assembly.scene.blocks)
    sides = np.concatenate([joints.first, joints.second])
    number = np.tile(np.arange(len(joints.first)), 2)
    between = np.bincount(sides, minlength=count) == 2
    between &= np.bincount(sides[acts[number]], minlength=count) == 2
    between &= np.isin(np.arange(count), assembly.movable)
    along = between[joints.first] & between[joints.second]
    row = linked(count, joints.first[along], joints.second[along])
    in_chain = between & (np.bincount(row)[row] >= _CHAIN)
    order = np.argsort(sides, kind="stable")
    return number[order][in_chain[sides[order]]].reshape(-1, 2)


def thrust_marks(result: Outcome) -> Iterable[Marks]:
    """Resultants half to each side of where they act, and how large they are. In the plane also the line of
    thrust through rows of blocks that have two joints, along which only the resultants on supports are drawn:
    they say how large all are. In space also, thinner, the forces at contact points."""
    assembly, (force, point) = result.assembly, thrust(result)
    size, shrink = size_of(assembly), shrink_of(assembly)
    shown: np.ndarray = np.isfinite(point).all(axis=1)
    point = point - assembly.geometry.origin
    longest, who = _LONGEST, "of a joint"
    if result.contacts is not None:
        longest = _LONGEST_IN_SPACE
    elif len(pairs := chains(assembly, shown)):
        on_line = np.isin(np.arange(len(shown)), pairs)
        at = point[on_line][:, None]
        yield Marks("line", "line of thrust", "line", THRUST, 1.8 * shrink, point[pairs])
        yield Marks("points", "line of thrust", "point", THRUST, 3.2 * shrink, at)
        ends = np.stack([assembly.joints.first, assembly.joints.second])
        on_support = np.logical_or(*~np.isin(ends, assembly.movable))
        shown &= ~on_line | on_support
        who = "on a support" if on_support[shown].all() else who
    if not shown.any():
        return
    most = float(np.linalg.norm(force[shown], axis=1).max())
    unit = longest * size / most
    label = f"resultant {who}, in the case's unit of force"
    if (points := result.contacts) is not None:
        label = f"resultant {who}; the longest is {most:.3g} in the case's unit of force"
        carried = points[["fx", "fy", "fz"]].to_numpy()
        carries = np.linalg.norm(carried, axis=1) > CARRIES_NOTHING * most
        at = points[["x", "y", "z"]].to_numpy()[carries] - assembly.geometry.origin
        lines, width = _through(at, unit * carried[carries], 0.4, 1.0)
        yield Marks("contacts", "force at a contact point, one state of many", "line", AT_POINT, width, lines)
    lines, width = _through(point[shown], unit * force[shown], 0.8, 1.6)
    yield Marks("resultants", label, "line", THRUST, width, lines)
    yield Marks("points", "", "point", THRUST, 1.8 * width, point[shown][:, None])
    if points is None:
        scale = round_below(most)
        left, _, _, top = shapely.total_bounds(assembly.geometry.polygons[assembly.movable])
        ends = np.add([left, top + _ABOVE * size], [[[0.0, 0.0], [scale * unit, 0.0]]])
        yield Marks("scale", "", "bar", THRUST, 1.6, ends, text=f"= {scale:g}")


def _through(at: np.ndarray, arrows: np.ndarray, thin: float, thick: float) -> tuple[np.ndarray, float]:
    """Lines half to each side of points, and their width: the thinner the more they are."""
    lines = np.stack([at - arrows / 2, at + arrows / 2], axis=1)
    return lines, float(np.clip(25 / np.sqrt(len(at)), thin, thick))


def round_below(most: float) -> float:
    """The largest of 1, 2 and 5 times powers of ten that is no more."""
    power = 10.0 ** np.floor(np.log10(most))
    return float(max(digit * power for digit in (1, 2, 5) if digit * power <= most))


def utilisation_marks(result: Outcome) -> Iterable[Marks]:
    """Joints, or in space the sides of their outlines, in the colours of their utilisation, the most used
    last; idle ones thin."""
    ends, joint = result.assembly.joints.lines()
    used, steps = result.joints["utilisation"].to_numpy()[joint], len(UTILISATION)
    step = np.where(np.isnan(used), -1, np.clip(np.nan_to_num(used) * steps, 0, steps - 1)).astype(int)
    for number, colour in enumerate((IDLE, *UTILISATION), start=-1):
        label, name = ("idle joint", "idle") if number < 0 else ("", "used")
        # Wider too where more is used, for readers of grey prints.
        width = 1.6 if number < 0 else 2.0 + 1.6 * number / (steps - 1)
        lines = Marks(name, label, "line", colour, width * shrink_of(result.assembly), ends[step == number])
        yield from joint_marks(lines)


def utilisation_label(assembly: Assembly) -> str:
    """What a legend says of the colours of utilisation."""
    limit = "slide, hinge or crush" if assembly.scene.dimension == 2 else "slide"
    return f"utilisation of joints (1: about to {limit})"
