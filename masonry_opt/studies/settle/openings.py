"""How joints open and slide while a support moves: the small motion of a mechanism."""

import numpy as np
import pandas as pd

from masonry_opt.answer.frames import unsigned
from masonry_opt.answer.motion import fastest, joint_motion
from masonry_opt.answer.thresholds import ZERO
from masonry_opt.drawing.colours import BLACK
from masonry_opt.drawing.elements import Elements
from masonry_opt.drawing.marks import Marks
from masonry_opt.result import Result

#: Joints at which a picture has numbers, and what it says of them.
_WRITTEN = 12
NOTE = "Numbers at joints: how wide they open, or slide (s), per unit of the support's movement"


def openings(result: Result) -> pd.DataFrame:
    """A row a joint that opens or slides in the mechanism of a support that moves, the widest first:
    ``joint`` (its row in ``result.joints``), ``first``, ``second``, ``x``, ``y`` (``z``) where it opens most,
    ``opening`` there, and ``sliding``, the largest slip, both over the movement of the support."""
    assembly, solution = result.assembly, result.solution
    problem, joints = assembly.problem, assembly.joints
    axes = list("xyz"[: assembly.scene.dimension])
    columns = ["joint", "first", "second", *axes, "opening", "sliding"]
    if solution.d is None or solution.load_factor is None:
        return pd.DataFrame(columns=columns)
    # The push, along the movement, is the one live load.
    movement = float(problem.live @ solution.d) / float(problem.force_sizes(problem.live).sum())
    rates, rounding = problem.motion(solution.d, solution.q), ZERO * fastest(assembly, solution.d)
    apart, slip = np.empty(len(joints.joint)), np.hypot.reduce(np.abs(problem.shears(rates)), axis=0)
    apart[assembly.pressed] = problem.at_points(rates)
    order = np.lexsort((-apart, joints.joint))
    widest = order[np.unique(joints.joint[order], return_index=True)[1]]
    motion = joint_motion(assembly, solution)
    moves = np.flatnonzero(motion.slides | motion.hinges | motion.separates)
    opens, slides = apart[widest], joints.most(slip[assembly.of_point])
    opens, slides = (np.where(rate > rounding, rate, 0.0)[moves] / movement for rate in (opens, slides))
    first, second = np.array(assembly.pairs_of(moves), dtype=object).reshape(-1, 2).T
    at = (joints.point[widest] + assembly.geometry.origin)[moves]
    frame = pd.DataFrame(dict(zip(columns, (moves, first, second, *at.T, opens, slides), strict=True)))
    widths = frame[["opening", "sliding"]].max(axis=1)
    return unsigned(frame.loc[widths.sort_values(ascending=False, kind="stable").index]).reset_index(
        drop=True
    )


def opening_marks(result: Result, elements: Elements) -> list[Marks]:
    """The numbers of the widest, at the joints."""
    joints, found = result.assembly.joints, openings(result).head(_WRITTEN)
    marks = []
    for number, opening, sliding in zip(found["joint"], found["opening"], found["sliding"], strict=True):
        ends = [joints.first[number], joints.second[number]]
        motion = elements.motion[ends].mean(axis=0)[None]
        text = f"{opening:.3g}" if opening >= sliding else f"{sliding:.3g} s"
        point = joints.middle[number][None, None]
        marks.append(Marks("openings", "", "point", BLACK, 0.0, point, motion, text=text))
    return marks
