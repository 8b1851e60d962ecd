"""The least thickness and the least friction at which an arch stands under its own weight."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from masonry_opt.answer.result import Result
from masonry_opt.scene.arch import Arch, PointLoad
from masonry_opt.scene.blocks import JointDefaults
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.margins.least import least
from masonry_opt.studies.margins.standing import standing
from masonry_opt.studies.margins.threshold import Threshold
from masonry_opt.studies.paper.example import ProgressLine

#: Thicknesses searched, over the radius: nearly all that an arch can have.
THINNEST, THICKEST = 1e-3, 1.99

#: Frictions searched.
SMOOTHEST, ROUGHEST = 1e-3, 1.0

#: Distance of the ends of a search, relative: well beyond the solver's own error.
PROOF = 1e-6


@dataclass(frozen=True)
class LeastThickness:
    """Where an arch begins to stand under its own weight.

    Attributes
    ----------
    thickness: the least; None if the arch does not stand at any searched.
    collapse: the arch there, with its thrust and mechanism (at the thickest searched, if none stands).
    threshold: the search, whose ends prove the thickness; None if none stands.

    Load factors of its results are margins: see :func:`~masonry_opt.studies.margins.standing.standing`.
    """

    thickness: float | None
    collapse: Result = field(repr=False)
    threshold: Threshold | None = field(repr=False)


def least_thickness(
    arch: Arch, joints: JointDefaults, progress: ProgressLine = lambda _: None
) -> LeastThickness:
    """Least thickness at which an equilibrium state exists.

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
        If a linear program fails.
    OptionError
        If the arch stands at the least thickness searched already.
    """
    thinnest, thickest = THINNEST * arch.centreline, THICKEST * arch.centreline
    thick = standing(of_thickness(arch, thickest, joints))
    if thick.required() < 0:
        return LeastThickness(None, thick, None)
    found = least(
        lambda thickness: of_thickness(arch, thickness, joints),
        thinnest,
        thickest,
        tolerance=PROOF,
        samples=0,
        progress=lambda trial: progress(f"thickness {trial.value:.9g}: margin {trial.number:+.3g}"),
    )
    return LeastThickness(found.value, standing(of_thickness(arch, found.value, joints)), found)


def friction_to_stand(arch: Arch) -> float:
    """Least friction at which an arch stands under its own weight.

    Raises NoLoadFactorError if a linear program fails.
    """
    found = least(
        lambda friction: of_thickness(arch, arch.thickness, JointDefaults(friction=friction)),
        SMOOTHEST,
        ROUGHEST,
        tolerance=PROOF,
        samples=0,
    )
    return found.value


def of_thickness(arch: Arch, thickness: float, joints: JointDefaults) -> Scene:
    """The arch at another thickness."""
    return Scene(joints=joints, blocks=arch.model_copy(update={"thickness": thickness}).blocks())


def opened_scene(arch: Arch, thickness: float, joints: JointDefaults, title: str = "arch") -> Scene:
    """The arch at another thickness, with a live load that takes one voussoir's weight off the normal
    force of every joint: a uniform pressure from inside.

    Its load factor is the margin with which it stands, in voussoir weights, for methods that need a scene
    with that load written out (:func:`~masonry_opt.studies.margins.standing.standing` does not).
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
    changes = {"thickness": thickness, "live": (0.0, 0.0), "point_loads": loads}
    return Scene(title=title, joints=joints, blocks=arch.model_copy(update=changes).blocks())
