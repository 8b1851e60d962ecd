"""What joints carry, drawn on the scene at rest: thrust and utilisation."""

from __future__ import annotations

import numpy as np

from masonry_opt.answer.result import Result
from masonry_opt.report.colours import IDLE, THRUST
from masonry_opt.report.page.drawing import Pen, group, mark_size
from masonry_opt.report.page.view import SIDE
from masonry_opt.report.thrust import thrust

#: Colours of utilisation from 0 to 1, in steps of equal width: matplotlib's "viridis_r", as in pictures.
UTILISATION = ("#FDE725", "#A0DA39", "#4AC16D", "#1FA187", "#277F8E", "#365C8D", "#46327E", "#440154")

#: Length of the longest resultant, as a share of the picture.
_LONGEST = 0.08


def has_forces(result: Result) -> bool:
    """Whether joints carry anything that is known."""
    return bool(result.joints["n"].notna().all())


def draw_thrust(result: Result, pen: Pen) -> str:
    """Resultants through their points of action, and the line of thrust through blocks between two joints."""
    carried, origin = thrust(result), result.assembly.geometry.origin
    size = np.hypot(*carried.force.T)
    pressed = np.flatnonzero(np.isfinite(carried.point).all(axis=1))
    if not len(pressed):
        return ""
    points, joints = carried.point - origin, result.assembly.joints
    half = carried.force * (_LONGEST * SIDE / pen.view.scale / size[pressed].max() / 2)
    pairs = np.array(_between_two(result, pressed), dtype=int).reshape(-1, 2)
    line = pen.lines(points[pairs[:, 0]], points[pairs[:, 1]])
    # Along a line of thrust those on supports say how large they are.
    on_support = ~np.isin([joints.first, joints.second], result.assembly.movable).all(axis=0)
    shown = pressed[on_support[pressed] | ~np.isin(pressed, pairs)]
    resultants = pen.lines(points[shown] - half[shown], points[shown] + half[shown])
    width = mark_size(result)
    # Where there are many joints they could not be told apart.
    dots = pen.lines(points[pressed], points[pressed]) if len(points) < 2000 else []

    def layer(name: str, lines: list[str], thickness: float) -> str:
        paths = [pen.path("".join(lines))] if lines else []
        return group(name, paths, stroke_width=f"{thickness * width:.2g}")

    return group(
        "layer thrust",
        [layer("line", line, 2.5), layer("resultants", resultants, 2.5), layer("dots", dots, 6)],
        fill="none",
        stroke=THRUST,
        stroke_linecap="round",
    )


def _between_two(result: Result, pressed: np.ndarray) -> list[list[int]]:
    """The two joints of each movable block that has no others, as voussoirs do, where both are pressed."""
    joints, acts = result.assembly.joints, set(pressed.tolist())
    of_block: dict[int, list[int]] = {block: [] for block in result.assembly.movable.tolist()}
    for joint, pair in enumerate(zip(joints.first.tolist(), joints.second.tolist(), strict=True)):
        for block in pair:
            if block in of_block:
                of_block[block].append(joint)
    return [own for own in of_block.values() if len(own) == 2 and acts.issuperset(own)]


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
