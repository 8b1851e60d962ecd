"""The least or the greatest reaction of ``settle``: what moves there, and how joints open and slide."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from masonry_opt.answer.frames import unsigned
from masonry_opt.answer.motion import fastest, joint_motion, moving_names
from masonry_opt.answer.thresholds import ZERO
from masonry_opt.drawing.colours import BLACK
from masonry_opt.drawing.elements import Elements
from masonry_opt.drawing.marks import Marks
from masonry_opt.result import Result

COLUMNS = ("kind", "reaction", "status", "moves")  #: Columns of a table of reactions, beside the end.
_WRITTEN = 12  #: Joints at which a picture has numbers, and what it says of them.
NOTE = "Numbers at joints: how wide they open, or slide (s), per unit of the support's movement"


@dataclass(frozen=True)
class Bound:
    """The least or the greatest reaction, in the case's unit of force; None where there is none.

    Attributes
    ----------
    result: of the method asked, with its mechanism, tables and pictures. Its live load pushes the supports,
        from the reaction ``start`` on: the reaction is ``start`` and its load factor times
        ``per_load_factor``.
    with_associative: the same with associative flow; ``result`` itself where that is what was asked.
    """

    result: Result
    with_associative: Result = field(repr=False)
    start: float = field(repr=False)
    per_load_factor: float = field(repr=False)

    @property
    def reaction(self) -> float | None:
        """That of the method asked."""
        return self._reaction(self.result.load_factor)

    @property
    def expected(self) -> float | None:
        """That to expect of a scene at rest whose supports then move; None of an associative answer, or where
        the forces at rest were not found."""
        return self._reaction(self.result.expected)

    @property
    def associative(self) -> float | None:
        """That with associative flow, which no other lies beyond."""
        return self._reaction(self.with_associative.load_factor)

    @property
    def across_rest(self) -> float | None:
        """That of a state met on the other side of rest, of other forces there than those at rest, if any."""
        return self._reaction(below if (below := self.result.solution.below_zero) < -ZERO else None)

    @property
    def unlimited(self) -> bool:
        """Whether the scene is proven to stand with any reaction on this side."""
        return self.result.solution.carries_any_load

    @property
    def results(self) -> dict[str, Result]:
        """Results by kind: "coulomb" and "expected", where asked for, and "associative"."""
        if self.result is self.with_associative:
            return {"associative": self.result}
        found = {"coulomb": self.result, "expected": self.result.at_expected}
        return {kind: of for kind, of in found.items() if of} | {"associative": self.with_associative}

    @cached_property
    def openings(self) -> pd.DataFrame:
        """How wide joints open, and how far they slide, for each unit that the support moves, in the small
        motion of the mechanism of the first of ``results`` that has one: see :attr:`Settlement.openings`."""
        return joint_openings(next((of for of in self.results.values() if of.solution.answer), self.result))

    def rows(self) -> list[dict[str, Any]]:
        """Reaction, status and moving blocks of each of the results."""
        results = self.results.items()
        rows = ((kind, self._reaction(of.load_factor), str(of.status), moving(of)) for kind, of in results)
        return [dict(zip(COLUMNS, row, strict=True)) for row in rows]

    def _reaction(self, load_factor: float | None) -> float | None:
        if load_factor is None:
            return None
        reaction = self.start + self.per_load_factor * load_factor
        return reaction if abs(reaction) > ZERO * abs(self.per_load_factor) else 0.0


def moving(result: Result) -> list[str]:
    """Names of the blocks that move at a load factor, fastest first."""
    found = result.solution.answer
    return moving_names(result.assembly, found.d) if found else []


def joint_openings(result: Result) -> pd.DataFrame:
    """:attr:`Settlement.openings` of the mechanism of a result."""
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
    widths = frame[["opening", "sliding"]].max(axis=1).sort_values(ascending=False, kind="stable")
    return unsigned(frame.loc[widths.index]).reset_index(drop=True)


def opening_marks(result: Result, elements: Elements) -> list[Marks]:
    """The numbers of the widest, at the joints."""
    joints, found = result.assembly.joints, joint_openings(result).head(_WRITTEN)
    marks = []
    for number, opening, sliding in zip(found["joint"], found["opening"], found["sliding"], strict=True):
        ends = [joints.first[number], joints.second[number]]
        motion = elements.motion[ends].mean(axis=0)[None]
        text = f"{opening:.3g}" if opening >= sliding else f"{sliding:.3g} s"
        point = joints.middle[number][None, None]
        marks.append(Marks("openings", "", "point", BLACK, 0.0, point, motion, text=text))
    return marks
