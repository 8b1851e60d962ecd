"""Associative load factor of blocks in space: Coulomb's cones handed to Clarabel, polygons in them to HiGHS.

Greatest λ so that B q + λ live + dead = 0 with, at each contact point, n ≥ 0 and |(s, t)| ≤ c + μ n.
"""

import clarabel
import highspy
import numpy as np
import scipy.sparse as sp
from space.boxes import Pushed


def by_cones(wall: Pushed, friction: float, cohesion: float = 0.0) -> float:
    """Greatest load factor by second-order cones; cohesion is a force per area.

    Raises ArithmeticError where Clarabel ends with anything but a solution.
    """
    points, rows = len(wall.area), len(wall.dead)
    unknowns = 1 + 3 * points  # λ, then (n, s, t) of each point
    statics = sp.hstack([wall.live[:, None], wall.B])
    normal = 1 + 3 * np.arange(points)
    pressing = sp.csc_array((-np.ones(points), (np.arange(points), normal)), shape=(points, unknowns))
    # Clarabel: A x + slack = b, so a cone's slack is (c + μ n, s, t).
    factor = np.tile([friction, 1.0, 1.0], points)
    cone = sp.hstack([sp.csc_array((3 * points, 1)), sp.diags_array(-factor)])
    limit = np.zeros((points, 3))
    limit[:, 0] = cohesion * wall.area
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-9
    solution = clarabel.DefaultSolver(
        sp.csc_matrix((unknowns, unknowns)),
        -np.eye(1, unknowns)[0],
        sp.csc_matrix(sp.vstack([statics, pressing, cone])),
        np.concatenate([-wall.dead, np.zeros(points), limit.ravel()]),
        [
            clarabel.ZeroConeT(rows),
            clarabel.NonnegativeConeT(points),
            *[clarabel.SecondOrderConeT(3)] * points,
        ],
        settings,
    ).solve()
    if solution.status != clarabel.SolverStatus.Solved:
        raise ArithmeticError(f"Clarabel: {solution.status}")
    return float(solution.x[0])


def by_polygons(
    wall: Pushed, friction: float, sides: int, turned: float = 0.0, cohesion: float = 0.0
) -> float:
    """Greatest load factor by polygons inside the cones, whose first side faces the angle ``turned``.

    Side k: cos(π/P) (c + μ n) − e_k·(s, t) ≥ 0. The angle counts in radians from the point's first direction
    of shear to its second. Raises ArithmeticError where HiGHS ends with anything but an optimum.
    """
    points = len(wall.area)
    angle = turned + 2 * np.pi * np.arange(sides) / sides
    inner = np.cos(np.pi / sides)
    side = np.column_stack([np.full(sides, inner * friction), -np.cos(angle), -np.sin(angle)])
    faces = sp.hstack([sp.csc_array((points * sides, 1)), sp.kron(sp.eye_array(points), side)])
    A = sp.csc_array(sp.vstack([sp.hstack([wall.live[:, None], wall.B]), faces]))
    least = np.repeat(-inner * cohesion * wall.area, sides)
    program = highspy.HighsLp()
    program.num_row_, program.num_col_ = A.shape
    program.sense_ = highspy.ObjSense.kMaximize
    program.col_cost_ = np.eye(1, A.shape[1])[0]
    program.col_lower_ = np.concatenate(
        [[-highspy.kHighsInf], np.tile([0.0, *[-highspy.kHighsInf] * 2], points)]
    )
    program.col_upper_ = np.full(A.shape[1], highspy.kHighsInf)
    program.row_lower_ = np.concatenate([-wall.dead, least])
    program.row_upper_ = np.concatenate([-wall.dead, np.full(len(least), highspy.kHighsInf)])
    program.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    program.a_matrix_.start_, program.a_matrix_.index_ = A.indptr, A.indices
    program.a_matrix_.value_ = A.data
    highs = highspy.Highs()
    highs.silent()
    highs.setOptionValue("solver", "ipm")
    highs.passModel(program)
    highs.run()
    if highs.getModelStatus() != highspy.HighsModelStatus.kOptimal:
        raise ArithmeticError(f"HiGHS: {highs.getModelStatus()}")
    return float(highs.getObjectiveValue())
