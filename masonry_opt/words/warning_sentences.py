"""Sentences of warnings: what looks unintended in a scene, from reason codes."""

from collections.abc import Callable
from math import radians, tan
from typing import Any

from masonry_opt.answer.reasons import Code
from masonry_opt.errors import rounded_up
from masonry_opt.words.names import blocks, do, pairs, verb


def _friction_high(v: dict[str, Any]) -> str:
    angle = v["friction"]
    meant = f": in degrees? tan {angle:g}° = {tan(radians(angle)):.3f}" if angle < 90 else ""
    return f"friction {angle:g} of {_where(v)} is more than dry joints have{meant}"


def _where(v: dict[str, Any]) -> str:
    """The joints named, or all those that are not."""
    return f"joint {pairs(v)}" if v["pairs"] else "[joints]"


def _small_gaps(v: dict[str, Any]) -> str:
    wide = [f"up to {rounded_up(width, 2)} wide" for width in v["widths"]]
    return (
        f"blocks face each other across a small gap and do not touch along it: {pairs(v, wide)}; if they "
        f"should, raise 'tolerance' to {rounded_up(max(v['widths']), 2)}"
    )


def _corners_bear(v: dict[str, Any]) -> str:
    forces = [f"{force:.4g}" for force in v["normal_forces"]]
    where = f"at {pairs(v)} that may bring down what no load does here"
    if forces:
        where = f"at collapse these press with the force told, {pairs(v, forces)}"
    limits = "'strength' limits no force where a corner stands on an edge"
    return f"{limits}, and crushing there is not looked at: {where}"


#: By code, as in :mod:`~.words.sentences`.
WARNINGS: dict[Code, str | Callable[[dict[str, Any]], str]] = {
    Code.FRICTION_HIGH: _friction_high,
    Code.DILATANCY_LOW: lambda v: (
        f"'dilatancy' {v['dilatancy']:g} of {_where(v)} is below minus its friction, {v['friction']:g}: "
        "sliding would close the joint by more than friction resists; is its sign meant?"
    ),
    Code.IDLE_SUPPORTS: lambda v: (
        f"{blocks(v['blocks'])}, fixed, {verb(len(v['blocks']), 'touch')} no block that can move"
    ),
    Code.HELD_BY_CLAMPING: lambda v: (
        f"blocks are wedged between supports, and friction at {pairs(v)} carries load though nothing "
        "presses these joints together: set their friction to 0, or give the load that clamps them"
    ),
    Code.FAR_AWAY: lambda v: (
        f"{do(v, 'stand')} {v['distance']:.3g} away from the rest, whose size is {v['size']:.3g}: are the "
        "coordinates in one unit?"
    ),
    Code.SMALL_GAPS: _small_gaps,
    Code.CORNERS_MEET: lambda v: (
        f"{pairs(v)} meet corner on corner, where nothing holds them: a joint needs an edge of either"
    ),
    Code.WITHOUT_NORMAL: lambda v: (
        f"{pairs(v)} meet corner on corner, corner on edge or edge along edge, where there is no normal and "
        "nothing holds them: a joint needs a face of either, or edges that cross"
    ),
    Code.FACES_TURNED: lambda v: (
        f"not all faces of {blocks(v['blocks'])} were given turned one way; they are taken so: were these "
        "meant?"
    ),
    Code.CORNERS_BEAR: _corners_bear,
    Code.BARE_EDGE_LOAD: (
        "edge_load no. {number} meets no free edge of a movable block along {length:.4g} of its "
        "length, where it does nothing"
    ),
    Code.AXLES_LEFT_OUT: lambda v: (
        f"axles {', '.join(repr(name) for name in v['names'])} are left out, as they move: see 'crossing'"
        if v["names"]
        else "axles, which the load case names, are left out, as they move: see 'crossing'"
    ),
    Code.WEIGHTS_DIFFER: lambda v: (
        f"the weight per {v.get('per', 'area')} of {blocks(v['blocks'])} is {v['ratio']:.3g} times the "
        "median of all blocks: are weights and lengths in one unit each?"
    ),
    Code.ACTS_OUTSIDE: lambda v: (
        f"the {v['load']} force of {blocks(v['blocks'])} acts {v['distance']:.3g} outside of the block: is "
        f"'{v['load']}_at' (of a load: 'at') in the scene's coordinates?"
    ),
    Code.FORCES_DIFFER: lambda v: (
        f"the {v['load']} force on {blocks(v['blocks'])} is {v['ratio']:.3g} times the weight there: are "
        "forces and weights in one unit?"
    ),
}
