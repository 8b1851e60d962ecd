"""Return columns for a result's JSON, from which other programs can recompute its certificate.

Tables of a result contain the joint forces and the velocities of the blocks. These columns add the points on
which forces act, the loads of the blocks, the guide forces of supports that settle, and the limits of the
yield conditions. Forces and lengths are in the case's units.
"""

from typing import Any

import numpy as np

from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.displaced import placed
from masonry_opt.problem.limited_forces import Role
from masonry_opt.solution.solution import Solution

Columns = dict[str, list[Any]]


def load_columns(assembly: Assembly) -> Columns:
    """Return the dead and live load of each movable block: forces, and moments about the block's centroid.

    In the plane the columns also contain the ``vertices`` of the block, after a settlement at their displaced
    positions.
    """
    problem = assembly.problem
    columns: Columns = {}
    if assembly.scene.dimension == 2:
        columns["vertices"] = [_vertices(assembly, row) for row in assembly.movable]
    for kind, load in (("dead", problem.dead), ("live", problem.live)):
        forces = problem.forces(load) * problem.force_unit
        moments = problem.moments(load) * problem.force_unit * problem.length_unit
        columns |= _components(forces, moments, f"{kind}_")
    return columns


def _vertices(assembly: Assembly, row: int) -> Any:
    """Return the vertices of a block in the plane, displaced by the settlement of supports if there is one.

    The result is None for a block that consists of several polygons.
    """
    vertices, settled = assembly.scene.blocks[row].vertices, assembly.scene.settled
    if vertices is None or settled is None:
        return vertices
    origin = assembly.geometry.origin
    return (placed(np.array(vertices) - origin, settled.poses[row]) + origin).tolist()


def limit_columns(assembly: Assembly, solution: Solution) -> Columns:
    """Return the yield limits and the flow rule of each joint (in space, of each contact point).

    - ``friction``: friction coefficient μ.
    - ``cohesion_force``: cohesion times the area of the joint or contact point.
    - ``crushing_force``: normal force that crushes the whole joint; infinite without a strength.
    - ``flow_slope``: opening per unit slip by the flow rule of the answer.
    """
    problem = assembly.problem
    friction, crushing = (np.full(problem.joints, np.inf) for _ in range(2))
    cohesion, slope = (np.zeros(problem.joints) for _ in range(2))
    friction[problem.sliding] = problem.friction
    cohesion[problem.sliding] = problem.cohesion * problem.force_unit
    crushing[problem.crushing] = problem.crushing_force * problem.force_unit
    slope[problem.sliding] = problem.dilatancy if solution.state.slope is None else solution.state.slope
    limits = {"friction": friction, "cohesion_force": cohesion, "flow_slope": slope}
    if assembly.scene.dimension == 2:
        limits["crushing_force"] = crushing
    return {name: column.tolist() for name, column in limits.items()}


def normal_columns(assembly: Assembly) -> Columns:
    """Return the unit normals of the joints in the plane. Each normal points into the joint's first block."""
    return {f"n{axis}": column.tolist() for axis, column in zip("xy", assembly.joints.normal.T, strict=True)}


def line_columns(assembly: Assembly, *roles: Role) -> Columns:
    """Return the lines of action of forces with limits, such as ties: a point and a direction for each force.

    The argument ``roles`` selects kinds of forces. The point is on the first block of the limited force.
    The columns ``ux``, ``uy`` (and ``uz``) are the force on this block per unit of the limited force. The
    opposite force acts on the second block of a tie or prop, along the same line.
    """
    actions = [force.actions[0] for force in assembly.limited if force.role in roles]
    points = [action.point + assembly.geometry.origin for action in actions]
    axes = "xyz"[: assembly.scene.dimension]
    columns = {axis: [float(point[row]) for point in points] for row, axis in enumerate(axes)}
    return columns | {
        f"u{axis}": [float(action.force[row]) for action in actions] for row, axis in enumerate(axes)
    }


def guide_columns(assembly: Assembly, solution: Solution) -> Columns | None:
    """Return the forces that guide the motion of settling supports; None if no support settles.

    These guide forces prevent all motions of a support except its settlement. The columns contain one row for
    each support that settles: its name ``block``, its guide force, and the moment of this force about the
    centroid of the support. Several supports settle at one rate. The forces that couple them along the
    direction of the settlement are included.
    """
    problem = assembly.problem
    guides = [force.role is Role.SUPPORT for force in assembly.limited]
    actions = [force.actions for force in assembly.limited if force.role is Role.SUPPORT]
    guided = {action.block for group in actions for action in group}
    if not guided:
        return None
    q = np.full(problem.B.shape[1], np.nan) if solution.q is None else solution.q
    first = problem.B.shape[1] - len(guides)
    of_guides = first + np.flatnonzero(guides)
    on_blocks = problem.B[:, of_guides] @ q[of_guides]
    forces = problem.forces(on_blocks) * problem.force_unit
    moments = problem.moments(on_blocks) * problem.force_unit * problem.length_unit
    rows = [row for row, block in enumerate(assembly.movable) if int(block) in guided]
    columns: Columns = {"block": [assembly.scene.blocks[assembly.movable[row]].name for row in rows]}
    return columns | _components(forces[rows], moments[rows])


def _components(forces: np.ndarray, moments: np.ndarray, prefix: str = "") -> Columns:
    """Return forces and moments of several blocks as columns; each column name begins with the prefix."""
    axes = "xyz"[: forces.shape[1]]
    moment_names = [f"m{axis}" for axis in axes] if len(axes) == 3 else ["moment"]
    names = [*(f"f{axis}" for axis in axes), *moment_names]
    values = [*forces.T, *moments.T]
    return {f"{prefix}{name}": column.tolist() for name, column in zip(names, values, strict=True)}
