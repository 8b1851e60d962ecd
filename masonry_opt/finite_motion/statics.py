"""Forces of blocks that have moved: the greatest load factor, and whether any forces bear a given one."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from masonry_opt.answer.thresholds import IDLE
from masonry_opt.effort import Effort
from masonry_opt.finite_motion.moved_blocks import MovedBlocks
from masonry_opt.problem.problem import Problem
from masonry_opt.solvers.driver import Driver
from masonry_opt.solvers.highs import HighsSession, LinearProgram
from masonry_opt.solvers.registry import Verdict, find_solver


@dataclass(frozen=True)
class ForceOptimum:
    """An optimum of statics."""

    #: Load factor, or by how much yield conditions are violated at the least, in the unit of force.
    value: float
    #: Rates of the poses of all blocks that the multipliers of equilibrium are, shape (blocks, 3).
    motion: np.ndarray
    pressed: np.ndarray  #: joints with any force, shape (joints,)


def optimum(
    blocks: MovedBlocks, touch: np.ndarray, poses: np.ndarray, load_factor: float | None, effort: Effort
) -> ForceOptimum | None:
    """The greatest load factor, eq. (9), of the blocks with these poses and corners that touch, or by how
    much forces under a given one miss its conditions at the least; None if there is no such optimum."""
    problem = blocks.problem(touch, poses)
    if load_factor is None:
        solver = find_solver("cvxpy", "highs")
        state = Driver(problem, "static", solver, effort, of_load=True).solve().state
        found = None if state is None else (state.load_factor, state.d, state.q)
    else:
        found = least_missed(problem, load_factor, effort)
    if found is None:
        return None
    value, d, q = found
    size, pressed = np.abs(problem.by_kind(q)).max(axis=0), np.zeros(len(touch), dtype=bool)
    pressed[touch.any(axis=1)] = size > IDLE * size.max(initial=0.0)
    return ForceOptimum(value, blocks.rates(poses, d), pressed)


def least_missed(
    problem: Problem, load_factor: float, effort: Effort
) -> tuple[float, np.ndarray, np.ndarray] | None:
    """By how much forces miss equilibrium and yield at the least, the motion that gains by it, and they.

        min  v    s.t.    −v ≤ B q + λ f_L + f_D ≤ v,    z + v = C q + c + v ≥ 0

    Hinges leave the forces of a given λ no room: without v rounding would make the program infeasible.
    """
    load = problem.dead + load_factor * problem.live
    rows, faces = len(load), problem.faces
    column = np.repeat([1.0, -1.0, 1.0], [rows, rows, faces])
    # Slacks of rocking are so many times the normal force that is missed.
    column[2 * rows :][problem.table.rocks] = problem.layout.points
    conditions = sp.vstack([problem.B, problem.B, problem.true_yield])
    matrix = sp.hstack([conditions, sp.csr_array(column[:, None])], format="csc")
    cost = np.zeros(matrix.shape[1])
    cost[-1] = 1.0
    row_lower = np.concatenate([-load, np.full(rows, -np.inf), -problem.face_cohesion])
    row_upper = np.concatenate([np.full(rows, np.inf), -load, np.full(faces, np.inf)])
    low, high = np.where(cost > 0, 0.0, -np.inf), np.full(len(cost), np.inf)
    program = LinearProgram(cost, matrix, row_lower, row_upper, low, high)
    for presolve in ("choose", "off"):  # of what presolve leaves HiGHS' simplex may end in an error
        session = HighsSession(program, effort, "finite motion", small_matrix_value=1e-12, presolve=presolve)
        if session.solve() is Verdict.OPTIMAL:
            break
    else:
        return None
    *q, value = session.point()
    below, above = session.multipliers()[: 2 * rows].reshape(2, rows)
    return float(value), -(below + above), np.array(q)
