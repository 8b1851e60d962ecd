"""Sizes of a scene and of its linear program."""

from __future__ import annotations

from dataclasses import dataclass

from masonry_opt.answer.reasons import size_of as size_as_values
from masonry_opt.answer.solution import Solution
from masonry_opt.problem.assembly import Assembly


@dataclass(frozen=True)
class Size:
    """Sizes of the scene and of the linear program.

    Attributes
    ----------
    blocks, joints: movable blocks b and joints, in the plane c.
    rows, columns, nonzeros: of the linear program as the solver received it; None if none was built.
    left_out: what was not modelled, each with its reason, where that is told.
    contacts: contact points of a scene in space, c; None in the plane.
    """

    blocks: int
    joints: int
    rows: int | None
    columns: int | None
    nonzeros: int | None
    left_out: tuple[str, ...] = ()
    contacts: int | None = None


def size_of(assembly: Assembly, solution: Solution) -> Size:
    """The sizes of a scene and of the program of its solution."""
    problem, lp = assembly.problem, solution.size
    rows, columns, nonzeros = (None, None, None) if lp is None else (lp.rows, lp.columns, lp.nonzeros)
    points, joints = size_as_values(problem).get("contacts"), len(assembly.joints.first)
    return Size(problem.blocks, joints, rows, columns, nonzeros, contacts=points)
