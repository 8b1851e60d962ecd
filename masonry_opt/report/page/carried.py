"""What joints carry, drawn on the scene at rest: thrust and utilisation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_opt.answer.result import Result
from masonry_opt.report.colours import IDLE, THRUST
from masonry_opt.report.page.drawing import Pen, group, mark_size
from masonry_opt.report.page.view import SIDE
from masonry_opt.report.thrust import chains, thrust

#: Colours of utilisation from 0 to 1, in steps of equal width: matplotlib's "viridis_r", as in pictures.
UTILISATION = ("#FDE725", "#A0DA39", "#4AC16D", "#1FA187", "#277F8E", "#365C8D", "#46327E", "#440154")

#: Length of the longest resultant drawn, as a share of the picture.
_LONGEST = 0.08


def has_forces(result: Result) -> bool:
    """Whether joints carry anything that is known."""
    return bool(result.joints["n"].notna().all())


@dataclass(frozen=True)
class Resultants:
    """What of the joints' forces is drawn.

    Attributes
    ----------
    pressed: joints that carry anything, by their numbers.
    line: pairs of them that the line of thrust joins, through rows of blocks with two, shape (pairs, 2).
    shown: those whose resultants are drawn: along a line of thrust only the ones on supports, which say how
        large they are.
    longest: the largest resultant drawn; 0 where there is none.
    """

    pressed: np.ndarray
    line: np.ndarray
    shown: np.ndarray
    longest: float


def resultants(result: Result) -> Resultants:
    """Choose what is drawn of a result that has forces."""
    carried, joints, movable = thrust(result), result.assembly.joints, result.assembly.movable
    acts = np.isfinite(carried.point).all(axis=1)
    pressed, line = np.flatnonzero(acts), chains(result.assembly, acts)
    on_support = ~(np.isin(joints.first, movable) & np.isin(joints.second, movable))
    shown = pressed[on_support[pressed] | ~np.isin(pressed, line)]
    longest = np.hypot(*carried.force[shown].T).max(initial=0.0)
    return Resultants(pressed, line, shown, float(longest))


def draw_thrust(result: Result, pen: Pen) -> str:
    """Resultants through their points of action, and the line of thrust."""
    carried, chosen, width = thrust(result), resultants(result), mark_size(result)
    points = carried.point - result.assembly.geometry.origin
    half = carried.force * (_LONGEST * SIDE / pen.view.scale / (chosen.longest or 1.0) / 2)
    first, second = points[chosen.line].transpose(1, 0, 2)
    shown, pressed = points[chosen.shown], points[chosen.pressed]
    # Where there are many joints dots could not be told apart.
    dots = pen.lines(pressed, pressed) if len(points) < 2000 else []

    def layer(name: str, lines: list[str], thickness: float) -> str:
        paths = [pen.path("".join(lines))] if lines else []
        return group(name, paths, stroke_width=f"{thickness * width:.2g}")

    return group(
        "layer thrust",
        [
            layer("line", pen.lines(first, second), 2.5),
            layer("resultants", pen.lines(shown - half[chosen.shown], shown + half[chosen.shown]), 2.5),
            layer("dots", dots, 6),
        ],
        fill="none",
        stroke=THRUST,
        stroke_linecap="round",
    )


def draw_utilisation(result: Result, pen: Pen) -> str:
    """Joints coloured by how much of what they can carry they do; idle ones thin."""
    joints, used = result.assembly.joints, result.joints["utilisation"].to_numpy()
    lines = pen.lines(joints.start, joints.end)
    steps = len(UTILISATION)
    step = np.where(np.isnan(used), -1, np.clip(np.nan_to_num(used) * steps, 0, steps - 1)).astype(int)
    width = mark_size(result)
    drawn = []
    for number, colour in enumerate((IDLE, *UTILISATION), start=-1):
        path = "".join(lines[joint] for joint in np.flatnonzero(step == number))
        thickness = f"{(1.5 if number < 0 else 5) * width:.2g}"
        drawn.append(group("used", [pen.path(path)] if path else [], stroke=colour, stroke_width=thickness))
    return group("layer utilisation", drawn, fill="none", stroke_linecap="round")
