"""Scenes on ground that is tilted until they fall: where the load factor is the tangent of the tilt."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal

from masonry_opt.scene.blocks import Block, Joint, JointDefaults
from masonry_opt.scene.edge_load import EdgeLoad
from masonry_opt.scene.load import Load

Side = Literal["left", "right"]


def why_no_tilt(
    blocks: Iterable[Block],
    properties: Sequence[JointDefaults | Joint],
    edge_loads: Sequence[EdgeLoad],
    loads: Sequence[Load],
) -> str | None:
    """What makes a scene another one than tilting shows; None if nothing does.

    Tilted by θ, weights are cos θ (W + tan θ W'), W' the weights turned a quarter: λ = tan θ if all else
    grows with cos θ too. Other forces do not, nor what joints resist without being pressed.
    """
    for block in blocks:
        for force in ("live", "live_per_weight", "dead"):
            if any(getattr(block, force)):
                return f"block '{block.name}' has a force '{force}', which does not tilt: take it away"
    for load in loads:
        if load.live is not None or load.dead is not None:
            return f"a 'load' on block '{load.block}' is a force, which does not tilt: take it away"
    if edge_loads:
        return "an 'edge_load' does not tilt: take it away"
    for joint in properties:
        if joint.cohesion:
            return "'cohesion' does not grow with the weights: take it away"
        if joint.strength:
            return "'strength' does not grow with the weights: take it away"
        if joint.dilatancy_stress and joint.dilatancy:
            return "'dilatancy_stress' does not grow with the weights: take it away"
    return None


def turned_towards(side: Side, gravity: tuple[float, float]) -> tuple[float, float]:
    """Gravity turned a quarter towards that side (of one who stands upright)."""
    x, y = gravity
    return (-y, x) if side == "right" else (y, -x)
