"""Check the scene and the arguments of a capacity curve, and return the forces that the curve needs.

The checks need no solution, so that the command makes them before the scene is solved.
"""

from typing import NamedTuple

import numpy as np

from masonry_opt.errors import OptionError
from masonry_opt.finite_motion.moved_blocks import LEAST_RATE, point_forces
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role
from masonry_opt.problem.loads import Forces
from masonry_opt.reporting.names import some
from masonry_opt.scene.rows import lengths
from masonry_opt.scene.solids import COORDINATES, coordinates

#: Default number of states of a capacity curve if λ decreases linearly. With more states the curve is
#: smoother, and takes longer.
CURVE_STEPS = 40

#: Roles of the forces that prevent a capacity curve. Each role is mapped to the table that defines such
#: forces in a case file. Ties and props prevent the curve only in the plane.
_NOT_FOLLOWED = {
    Role.TIE: "[[tie]]",
    Role.PROP: "[[prop]]",
    Role.EARTH: "[[fill]]",
}


class CurveForces(NamedTuple):
    """Forces of a capacity curve, at the points where they act."""

    dead: Forces
    live: Forces
    control: Forces  #: forces whose points of action define the control displacement


def curve_forces(
    assembly: Assembly,
    block: str | None = None,
    point: tuple[float, ...] | None = None,
    steps: int = CURVE_STEPS,
) -> CurveForces:
    """Return the forces of a capacity curve. Raise OptionError if the curve is impossible.

    See :func:`~masonry_opt.capacity` for the arguments, and for the scenes whose curve is impossible.
    """
    refuse_parts_not_followed(assembly)
    if isinstance(steps, bool) or not isinstance(steps, int) or steps < 2:
        raise OptionError(f"steps must be a whole number, at least 2 (found {steps!r})")
    dead, live = point_forces(assembly)
    return CurveForces(dead, live, _control_force(assembly, live, block, point))


def refuse_parts_not_followed(assembly: Assembly) -> None:
    """Raise OptionError if a scene has settling supports or other parts that prevent a capacity curve."""
    case = assembly.scene.called
    if any(force.role is Role.SUPPORT for force in assembly.limited):
        raise OptionError(
            f"{case}: a capacity curve is not possible while a support settles: call mo.solve with "
            "the option 'settled', which moves the support before the live load acts"
        )
    not_followed = _not_followed(assembly)
    if not not_followed:
        return
    where = "in the plane" if assembly.scene.dimension == 2 else "in space"
    parts = " and ".join(f"{part} {some(names)}".strip() for part, names in not_followed.items())
    is_one = sum(max(len(names), 1) for names in not_followed.values()) == 1
    instead = f"omit {'it' if is_one else 'them'}, or use 'solve' to compute only the load factor"
    raise OptionError(f"{case}: a capacity curve {where} cannot take account of {parts}: {instead}")


def _not_followed(assembly: Assembly) -> dict[str, list[str]]:
    """Return the kinds of parts for which no capacity curve can be computed, each with its parts' names.

    Only ties and props have names. In space, a capacity curve takes account of ties and props.
    """
    parts: dict[str, list[str]] = {}
    for force in assembly.limited:
        is_strut = force.role in (Role.TIE, Role.PROP)
        if is_strut and assembly.scene.dimension == 3:
            continue
        names = parts.setdefault(_NOT_FOLLOWED[force.role], [])
        if is_strut:
            names.append(repr(force.name))
    if len(assembly.problem.crushing):
        parts["limited 'strength' of joints"] = []
    return parts


def _control_force(
    assembly: Assembly, live: Forces, block: str | None, point: tuple[float, ...] | None
) -> Forces:
    """Return the forces along which the control displacement is measured.

    The control displacement is the mean displacement of the points of action along these forces.

    Without a block, the forces are the live loads. With a block, the force is the resultant of the live loads
    at the control point.
    """
    if block is None:
        if point is not None:
            raise OptionError("a control point belongs to a block: specify 'block' (--block) too")
        return live
    names = assembly.names(assembly.movable)
    if block not in names:
        none = f"there is no movable block '{block}': choose from {some(names)}"
        raise OptionError(f"{assembly.scene.called}: block: {none}")
    row, along = names.index(block), live.force.sum(axis=0)
    if not np.linalg.norm(along) > LEAST_RATE * lengths(live.force).sum():
        raise OptionError(
            "the live load has no resultant, so the direction of the displacement is undefined: omit 'block'"
        )
    at = assembly.geometry.centroid[assembly.movable[row]]
    if point is not None:
        position = coordinates(point, len(at))
        if position is None:
            raise OptionError(f"the control point needs {COORDINATES[len(at)]} (found {point!r})")
        at = position - assembly.geometry.origin
    return Forces(np.array([row]), along[None], at[None], np.zeros(0))
