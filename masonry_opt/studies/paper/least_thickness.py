"""The least thickness and the least friction at which an arch stands: roots of a margin that one linear
program gives."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import pandas as pd
from scipy.optimize import brentq

from masonry_opt.answer.result import Result, make_result
from masonry_opt.errors import NoLoadFactorError
from masonry_opt.explain.sentences import message
from masonry_opt.methods.associative import associative
from masonry_opt.methods.task import Task
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.arch import Arch, PointLoad
from masonry_opt.scene.blocks import JointDefaults
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.paper.example import ProgressLine

#: Thicknesses searched, over the radius: nearly all that an arch can have.
THINNEST, THICKEST = 1e-3, 1.99

#: The root is bracketed as closely, relative.
ROOT_TOLERANCE = 1e-12

#: Distance of the thicknesses that prove the root, relative: well beyond the solver's own error.
PROOF = 1e-6


@dataclass(frozen=True)
class LeastThickness:
    """Where an arch begins to stand under its own weight.

    Attributes
    ----------
    thickness: the least; None if the arch does not stand at any searched.
    collapse: the arch there, with its thrust and mechanism (at the thickest searched, if none stands).
    stands, falls: the arch a millionth thicker and thinner; their load factors, of either sign, prove the
        root. None if no thickness stands.
    history: frame, one row a linear program: ``thickness``, ``margin``.

    All of them carry the live load of :func:`opened`, and their load factor is the margin.
    """

    thickness: float | None
    collapse: Result = field(repr=False)
    stands: Result | None = field(repr=False)
    falls: Result | None = field(repr=False)
    history: pd.DataFrame = field(repr=False)


def opened(arch: Arch, thickness: float) -> Arch:
    """The arch at another thickness, with a live load that takes one voussoir's weight off the normal
    force of every joint.

    That load is a uniform pressure from inside. With n = n' + λ, statics of the arch under its own weight
    with n' at yield is eq. (9) with that live load: its load factor is the largest λ by which every
    normal force exceeds what its shear and moment need. Positive, the arch stands with that margin;
    negative, it falls unless pressed together from outside. (λ in voussoir weights.)
    """
    angle = arch.voussoir_angle
    thrust = arch.unit_weight * angle * arch.centreline * thickness
    outward = 2 * math.sin(angle / 2) * thrust
    first, last = arch.springings
    loads = []
    for number in range(1, arch.voussoirs + 1):
        middle = first + (last - first) * (number - 0.5) / arch.voussoirs
        force = (outward * math.cos(middle), outward * math.sin(middle))
        loads.append(PointLoad(voussoir=number, force=force))
    return arch.model_copy(update={"thickness": thickness, "live": (0.0, 0.0), "point_loads": loads})


def opened_scene(arch: Arch, thickness: float, joints: JointDefaults, title: str = "arch") -> Scene:
    """The scene of :func:`opened`."""
    return Scene(title=title, joints=joints, blocks=opened(arch, thickness).blocks())


def least_thickness(
    arch: Arch, joints: JointDefaults, progress: ProgressLine = lambda _: None
) -> LeastThickness:
    """Least thickness at which an equilibrium state exists, by Brent's method on the margin.

    The arch's own thickness and live loads are left aside; its radius stays that of the centreline.
    Below the thickness found no state exists, so that the arch falls whatever the flow rule.

    Parameters
    ----------
    arch: the arch, with weight.
    joints: properties of its joints.
    progress: called with a line a linear program.

    Raises
    ------
    NoLoadFactorError
        If a linear program fails, or the arch stands at the least thickness searched already.
    """
    rows: list[dict[str, float]] = []

    def at(thickness: float) -> Result:
        result = margin(arch, thickness, joints)
        rows.append({"thickness": thickness, "margin": result.required()})
        progress(f"thickness {thickness:.9g}: margin {rows[-1]['margin']:+.3g}")
        return result

    thinnest, thickest = THINNEST * arch.centreline, THICKEST * arch.centreline
    at_most = at(thickest)
    if at_most.required() < 0:
        return LeastThickness(None, at_most, None, None, pd.DataFrame(rows))
    if at(thinnest).required() >= 0:
        raise NoLoadFactorError(f"the arch stands even {thinnest:.3g} thick: no least thickness is found")
    known = {row["thickness"]: row["margin"] for row in rows}
    root = brentq(
        lambda t: known[t] if t in known else at(t).required(),
        thinnest,
        thickest,
        xtol=ROOT_TOLERANCE * arch.centreline,
        rtol=ROOT_TOLERANCE,
    )
    collapse, stands, falls = at(root), at(root * (1 + PROOF)), at(root * (1 - PROOF))
    if not stands.required() > 0 > falls.required():
        raise NoLoadFactorError(
            f"the margin does not change its sign at the thickness found, {root:.9g}: solver accuracy"
        )
    return LeastThickness(root, collapse, stands, falls, pd.DataFrame(rows))


def friction_to_stand(arch: Arch) -> float:
    """Least friction at which an arch stands under its own weight: where its margin changes sign.

    Raises NoLoadFactorError if a linear program fails.
    """

    def at(friction: float) -> float:
        return margin(arch, arch.thickness, JointDefaults(friction=friction)).required()

    return float(brentq(at, 1e-3, 1.0, xtol=1e-10))


def margin(arch: Arch, thickness: float, joints: JointDefaults) -> Result:
    """The arch at a thickness, its load factor the margin with which it stands, of either sign.

    (``solve`` would refuse an arch that falls, whose margin is negative.)
    """
    assembly = assemble(opened_scene(arch, thickness, joints))
    task = Task(assembly.problem)
    solution = associative(task)
    return make_result(
        assembly,
        solution,
        task.effort,
        method="static",
        model=task.solver.language,
        solver=task.solver.name,
        message=message(solution.reasons),
    )
