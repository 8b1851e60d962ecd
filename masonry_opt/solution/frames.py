"""Tables of a solution, with one row for each block or joint, in the case's units."""

from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.faces import parabola
from masonry_opt.problem.limited_forces import Role
from masonry_opt.problem.problem import ShearLimits
from masonry_opt.scene.positions import in_scene
from masonry_opt.scene.rows import dots, lengths, sums
from masonry_opt.solution.load_history import LoadHistory, LoadStep
from masonry_opt.solution.motion import fastest, joints_that_move, relative_rotation, velocities
from masonry_opt.solution.solution import Solution
from masonry_opt.solution.thresholds import AT_HIGHEST, HINGES, MOVES, NEGLIGIBLE_SHARE

if TYPE_CHECKING:
    import pandas as pd


def unsigned(frame: "pd.DataFrame") -> "pd.DataFrame":
    """Return a copy of a table in which −0.0 is replaced by 0.0."""
    numbers = frame.select_dtypes("float64").columns
    return frame.assign(**{str(name): frame[name] + 0.0 for name in numbers})


def framed(rows: Any) -> "pd.DataFrame":
    """Return a table from a list of rows or a dictionary of columns, with −0.0 replaced by 0.0."""
    # Importing pandas takes a quarter of a second, and few analyses need a table, so the import is local.
    import pandas as pd

    return unsigned(pd.DataFrame(rows))


def block_frame(assembly: Assembly, solution: Solution) -> "pd.DataFrame":
    """Return a table with the centroid and the velocities of each movable block.

    Unknown velocities are NaN.
    """
    problem, shapes = assembly.problem, assembly.geometry
    _, _, d = _known(assembly, solution)
    rotations = problem.moments(d) / problem.length_unit
    columns = {
        "block": assembly.names(assembly.movable),
        **_columns("", in_scene(shapes, shapes.centroid[assembly.movable])),
        **_columns("v", problem.forces(d)),
        **(_columns("w", rotations) if assembly.scene.dimension == 3 else {"omega": rotations[:, 0]}),
    }
    return framed(columns)


def joint_frame(assembly: Assembly, solution: Solution) -> "pd.DataFrame":
    """Return a table with the blocks, position, size, forces and relative velocities of each joint.

    Velocities are those of the joint's first block relative to its second block. Unknown forces and
    velocities are NaN. In space the columns also contain the normal of the joint, the components of the
    resultant, and its point of action.
    """
    joints = assembly.joints
    q, u, d = _known(assembly, solution)
    extent, forces = ("length", _forces) if assembly.scene.dimension == 2 else ("area", _resultants)
    used = assembly.most_of_joints(np.nan_to_num(_utilisation(assembly, q), nan=-1.0))
    columns = {
        "first": assembly.names(joints.first),
        "second": assembly.names(joints.second),
        **_columns("", in_scene(assembly.geometry, joints.middle)),
        extent: joints.extent,
        **forces(assembly, q, u, d),
        "utilisation": np.where(used < 0, np.nan, used),
    }
    return framed(columns)


def contact_frame(assembly: Assembly, solution: Solution) -> "pd.DataFrame | None":
    """Return a table with the force and the relative velocity at each contact point; None in the plane.

    The force acts on the first block of the joint. The velocity is that of the first block relative to the
    second block. Unknown forces and velocities are NaN.
    """
    if assembly.scene.dimension == 2:
        return None
    joints, problem = assembly.joints, assembly.problem
    q, u, _ = _known(assembly, solution)
    joint, normal, n = joints.joint, joints.normal[joints.joint], problem.normal_forces(q)
    force, motion = _vectors(assembly, q), _vectors(assembly, u)
    opening = dots(motion, normal)
    columns = {
        "joint": joint,
        "first": assembly.names(joints.first[joint]),
        "second": assembly.names(joints.second[joint]),
        **_columns("", in_scene(assembly.geometry, joints.point)),
        "n": n * problem.force_unit,
        "s": lengths(force - n[:, None] * normal) * problem.force_unit,
        **_columns("f", force * problem.force_unit),
        "slip": lengths(motion - opening[:, None] * normal),
        "opening": opening,
        **_columns("v", motion),
        "utilisation": _utilisation(assembly, q),
    }
    return framed(columns)


def history_frame(assembly: Assembly, solution: Solution) -> "pd.DataFrame":
    """Return a table with one row for each step of the method.

    Rows of a load history list the joints that begin to slide, open or stick in the step.
    """
    steps = solution.history
    if not steps or not isinstance(steps[0], LoadStep):
        return framed(list(steps)).drop(columns="solved", errors="ignore")
    slide, are_open = joints_that_move(assembly, steps)
    unit, rows = assembly.problem.live_displacement, []
    for number, step in enumerate(steps):
        now, before = (np.stack([slide[row], are_open[row]]) for row in (number, max(number - 1, 0)))
        sticks = before.any(axis=0) & ~now.any(axis=0)
        changes = [assembly.pairs_of(joints) for joints in (*(now & ~before), sticks)]
        names = ("begins_to_slide", "begins_to_open", "begins_to_stick")
        row = {"iteration": step.iteration, "load_factor": step.load_factor}
        row |= {"displacement": unit * step.displacement, "jump": step.is_jump}
        rows.append(row | dict(zip(names, changes, strict=True)))
    return framed(rows)


def curve_frame(assembly: Assembly, history: LoadHistory) -> "pd.DataFrame":
    """Return a table of load steps.

    Each row lists the joints that slide or open for the first time in this step.
    """
    moves = np.stack(joints_that_move(assembly, history.steps), axis=1)
    started = np.zeros_like(moves[0])
    unit, rows = assembly.problem.live_displacement, []
    for step, now in zip(history.steps, moves, strict=True):
        slide, opened = (assembly.pairs_of(joints) for joints in now & ~started)
        started |= now
        row = {"displacement": unit * step.displacement, "load_factor": step.load_factor}
        row |= {"jump": step.is_jump, "sliding": int(now[0].sum()), "opening": int(now[1].sum())}
        rows.append(row | {"starts_sliding": slide, "starts_opening": opened})
    return framed(rows)


def _known(assembly: Assembly, solution: Solution) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return joint forces, joint motions and block velocities of a solution; unknown values are NaN.

    The shapes are (3c + t,), (3c + t,) and (3b,).
    """
    B = assembly.problem.B
    no_forces, no_motion = (np.full(count, np.nan) for count in B.T.shape)
    q = no_forces if solution.q is None else solution.q
    return (q, no_forces, no_motion) if solution.d is None else (q, B.T @ solution.d, solution.d)


def _columns(prefix: str, vectors: np.ndarray) -> dict[str, np.ndarray]:
    """Return the components of vectors as table columns, one for each axis.

    The vectors have shape (rows, 2) or (rows, 3). The name of a column is the prefix and the axis.
    """
    return {f"{prefix}{axis}": column for axis, column in zip("xyz", vectors.T, strict=False)}


def _vectors(assembly: Assembly, of_kinds: np.ndarray) -> np.ndarray:
    """Convert normal and tangential components at contact points to vectors in space, shape (points, 3).

    Each vector is the force on the first block at a contact point, or the motion of the first block relative
    to the second block.
    """
    axes = assembly.joints.axes[:, assembly.joints.joint]
    vectors: np.ndarray = np.einsum("kp,kpi->pi", assembly.problem.by_kind(of_kinds), axes)
    return vectors


def _forces(assembly: Assembly, q: np.ndarray, u: np.ndarray, d: np.ndarray) -> dict[str, np.ndarray]:
    """Return the table columns of the forces and relative velocities of joints in a plane scene."""
    problem = assembly.problem
    (first, second, s), (*openings, slip) = problem.by_kind(q), problem.by_kind(u)
    return {
        "n": (first + second) * problem.force_unit,
        "s": s * problem.force_unit,
        "m": assembly.joints.extent / 2 * (second - first) * problem.force_unit,
        "slip": slip,
        "opening": np.mean(openings, axis=0),
        "rotation": relative_rotation(assembly, d)[:, 2] / problem.length_unit,
    }


def _resultants(assembly: Assembly, q: np.ndarray, _: np.ndarray, d: np.ndarray) -> dict[str, np.ndarray]:
    """Return the table columns of the normals, resultants and relative velocities of joints in space."""
    joints, problem, shapes = assembly.joints, assembly.problem, assembly.geometry
    joint, normal, middle, count = joints.joint, joints.normal, joints.middle, len(joints.first)
    of_points, n_of_points = _vectors(assembly, q), problem.normal_forces(q)
    resultant, n = sums(joint, of_points, count), np.bincount(joint, n_of_points)
    pressed = n > NEGLIGIBLE_SHARE * np.nanmax(n, initial=0.0)
    share = (n_of_points / np.where(pressed, n, np.inf)[joint])[:, None]
    acts = np.where(pressed[:, None], sums(joint, share * joints.point, count), np.nan)
    # The torsion is the moment about an axis along the joint's normal. The axis passes through the point of
    # action of the resultant, or through the joint's centroid if the joint is not pressed.
    about = np.where(pressed[:, None], acts, middle)[joint]
    torsion = np.bincount(joint, dots(normal[joint], np.cross(joints.point - about, of_points)))
    motion = velocities(assembly, d, joints.first, middle) - velocities(assembly, d, joints.second, middle)
    opening, turned = dots(motion, normal), relative_rotation(assembly, d)
    turns = (lengths(turned) > HINGES * fastest(assembly, d))[:, None]
    square = np.where(turns, dots(turned, turned)[:, None], 1.0)
    on_axis = middle + np.cross(turned, motion) / square * problem.length_unit
    return {
        **_columns("n", normal),
        "n": n * problem.force_unit,
        "s": lengths(resultant - n[:, None] * normal) * problem.force_unit,
        **_columns("f", resultant * problem.force_unit),
        **_columns("p", in_scene(shapes, acts)),
        "torsion": torsion * problem.force_unit,
        "slip": lengths(motion - opening[:, None] * normal),
        "opening": opening,
        **_columns("v", motion),
        "rotation": lengths(turned) / problem.length_unit,
        **_columns("w", turned / problem.length_unit),
        **_columns("a", in_scene(shapes, np.where(turns, on_axis, np.nan))),
    }


def _utilisation(assembly: Assembly, q: np.ndarray) -> np.ndarray:
    """Return the utilisation of each joint of the problem: the largest ratio of a force to its limit.

    The shape is (c,). The utilisation is NaN if the joint carries no force. The ratios are:

    - the shear |s|, in space |(s, t)|, over the exact Coulomb limit; 0 if friction is unlimited;
    - in the plane, the moment |m| over n L/2, which crushing reduces;
    - in the plane, n over f_c L, the normal force that crushes the joint.
    """
    problem, has_length = assembly.problem, assembly.joints.extent[assembly.joint] > 0
    points, n = problem.at_points(q), problem.normal_forces(q)
    s = np.hypot.reduce(np.abs(problem.shears(q)), axis=0)
    # If a corner touches an edge, both contact points of the joint coincide, so the joint has no moment.
    m = np.where(has_length, points.max(axis=0) - points.min(axis=0), 0.0)
    # Forces and moments up to this value count as rounding errors. The limits of moment and shear, by which
    # moment and shear are divided, are raised to at least this value. This avoids a division by zero.
    rounding = NEGLIGIBLE_SHARE * (np.abs(n).max(initial=0.0) or 1.0)
    limit = ShearLimits.true(problem).at(n[problem.sliding])
    # Compute the largest moment that each joint can carry under its normal force. Moments are expressed as
    # the difference of the normal forces at the two ends of the joint.
    largest = n.copy()
    largest[problem.crushing] = parabola(n[problem.crushing], problem.crushing_force)
    used = m / np.maximum(largest, rounding)
    used[problem.crushing] = np.maximum(used[problem.crushing], n[problem.crushing] / problem.crushing_force)
    used[problem.sliding] = np.maximum(
        used[problem.sliding], s[problem.sliding] / np.maximum(limit, rounding)
    )
    return np.where(np.stack([np.abs(n), s, m]).max(axis=0) <= rounding, np.nan, used)


def tie_frame(assembly: Assembly, solution: Solution, *roles: Role) -> "pd.DataFrame":
    """Return a table of the forces with limits that have one of the given roles, such as tie forces.

    Each of these forces has a lower and an upper limit. The table has one row for each force. Unknown
    values are NaN.
    """
    problem = assembly.problem
    has_role = [force.role in roles for force in assembly.limited]
    forces = [force for force in assembly.limited if force.role in roles]
    q, u, d = _known(assembly, solution)
    T = problem.of_forces(q)[has_role] * problem.force_unit
    closing = problem.of_forces(u)[has_role]
    names = [*(block.name for block in assembly.scene.blocks), "ground"]
    lowest, highest = np.array([[force.lowest, force.highest] for force in forces], float).reshape(-1, 2).T
    # Solvers satisfy a force limit only to a tolerance that is relative to the forces of the scene.
    # A force that exceeds its limit by at most this value is set to the limit.
    rounding = NEGLIGIBLE_SHARE * np.abs(problem.normal_forces(q)).max(initial=0.0) * problem.force_unit
    within = np.clip(T, lowest, highest)
    T = np.where(np.abs(T - within) <= rounding, within, T)
    goes_on = (highest > 0) & (-closing > MOVES * fastest(assembly, d))
    # In an unstable scene, the forces T are NaN. The comparison is negated, so that ties and props with
    # unknown forces count as yielding if the mechanism works against them.
    yields = goes_on & ~(AT_HIGHEST * highest > T)
    columns = {
        "name": [force.name for force in forces],
        "kind": [str(force.role) for force in forces],
        "first": [names[force.actions[0].block] for force in forces],
        "second": [names[force.actions[-1].block] if force.actions[1:] else "ground" for force in forces],
        "force": np.where(yields & (np.abs(highest - T) <= rounding), highest, T),
        "lowest": lowest,
        "highest": highest,
        # ``closing`` is positive if a tie shortens or a prop lengthens.
        "lengthens": np.where([force.role is Role.PROP for force in forces], closing, -closing),
        "yields": yields,
    }
    return framed(columns)
