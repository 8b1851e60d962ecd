"""Properties of joints: the defaults of the scene, and its exceptions for pairs of blocks."""

from typing import Any

import numpy as np

from masonry_opt.errors import CaseError, rounded_up
from masonry_opt.scene.contacts.gaps import Closing, Gaps
from masonry_opt.scene.joints import JointDefaults
from masonry_opt.scene.scene import Scene

#: The joints of a block with two overlapping supports may have different properties if the overlap is at most
#: this fraction of both joints. With a larger value, a larger part of a joint may have the wrong properties.
_LARGEST_OVERLAP_OF_DIFFERENT_JOINTS = 0.01


def joint_properties(
    scene: Scene,
    joint_ends: tuple[np.ndarray, np.ndarray],
    overlaps: tuple[np.ndarray, np.ndarray],
    gaps: Gaps,
    closes_gaps: Closing,
) -> dict[str, Any]:
    """Return friction, cohesion, dilatancy and strength of all joints, named as in :class:`~.joints.Joints`.

    Raises CaseError if the two blocks of an exception do not touch. Also raises CaseError if a block rests on
    overlapping supports and its joints with the supports have different properties. These joints may differ
    only if the overlap is small.

    Parameters
    ----------
    scene : Scene
        The scene.
    joint_ends : tuple of ndarray
        First blocks and second blocks of the joints.
    overlaps : tuple of ndarray
        Blocks that rest on overlapping supports, shape (k, 3), and the sizes of the overlaps, shape (k,). See
        :attr:`~.joints.Joints.overlaps` and :attr:`~.joints.Joints.overlap_ratio`.
    gaps : Gaps
        Small gaps between blocks. If one of them separates the two blocks of an exception, the message names
        the option that closes all small gaps.
    closes_gaps : Closing
        Option that closes all small gaps.
    """
    first, second = joint_ends
    rows, ratio = overlaps
    _refuse_different_joints(scene, rows[ratio > _LARGEST_OVERLAP_OF_DIFFERENT_JOINTS])
    without_joint = {tuple(sorted(pair)) for pair in rows[:, [0, 2]].tolist()}
    properties = {
        name: np.full((len(first), *np.shape(value)), value)
        for name, value in _property_values(scene.joints).items()
    }
    index = {block.name: number for number, block in enumerate(scene.blocks)}
    for exception in scene.exceptions:
        block, neighbour = sorted(index[name] for name in exception.between)
        is_joint = (first == block) & (second == neighbour)
        if not is_joint.any() and (block, neighbour) not in without_joint:
            both_fixed = scene.blocks[block].fixed and scene.blocks[neighbour].fixed
            reason = "are both fixed" if both_fixed else "do not touch"
            label = f"joint between {list(exception.between)}"
            remedy = "Remove the entry for this joint, or correct the names of the blocks"
            if (block, neighbour) in gaps:
                width = rounded_up(gaps[block, neighbour], 2)
                remedy = f"The gap between the blocks is up to {width} wide: {closes_gaps.advice}"
            raise CaseError(
                f"{scene.origin}: {label}: the blocks {reason}, "
                f"so they have no joint whose properties could be set. {remedy}"
            )
        for name, value in _property_values(exception.over(scene.joints)).items():
            properties[name][is_joint] = value
    return properties


def _refuse_different_joints(scene: Scene, overlaps: np.ndarray) -> None:
    """Raise CaseError if the joints of a block with two overlapping supports have different properties.

    See :attr:`~.joints.Joints.overlaps` for ``overlaps``.
    """
    if not len(overlaps):
        return
    default = _property_values(scene.joints)
    exceptions = {
        frozenset(exception.between): _property_values(exception.over(scene.joints))
        for exception in scene.exceptions
    }
    for rows in overlaps.tolist():
        block, *supports = (scene.blocks[index].name for index in rows)
        first_values, second_values = (exceptions.get(frozenset((block, name)), default) for name in supports)
        names = [name for name, value in first_values.items() if second_values[name] != value]
        if names:
            raise CaseError(
                f"{scene.origin}: supports '{supports[0]}' and '{supports[1]}' overlap where block '{block}' "
                f"rests on both, but its joints with them differ in {' and '.join(names)}: let the supports "
                "end where they meet, or set the same values for both joints"
            )


def _property_values(joint: JointDefaults) -> dict[str, float | tuple[float, float]]:
    """Return the properties of a joint by name. The value ``inf`` means that there is no limit."""
    # A joint with unlimited friction cannot slide, so cohesion and dilatancy have no effect and are set to
    # zero.
    slides = np.isfinite(joint.friction)
    return {
        "friction": joint.friction,
        "cohesion": joint.cohesion if slides else 0.0,
        "dilatancy": joint.dilatancy if slides else 0.0,
        "dilatancy_stress": joint.dilatancy_stress or (np.inf, np.inf),
        "strength": joint.strength or np.inf,
    }
