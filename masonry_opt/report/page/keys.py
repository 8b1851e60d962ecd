"""What the marks of a picture mean."""

from __future__ import annotations

import numpy as np

from masonry_opt.answer.result import Result
from masonry_opt.answer.status import Status
from masonry_opt.errors import counted
from masonry_opt.problem.loads import loads
from masonry_opt.report.colours import BLOCK, DEAD, FIXED, FURTHER_DEAD, HATCH, IDLE, LIVE, THRUST
from masonry_opt.report.motion import has_mechanism
from masonry_opt.report.page.arrows import MOST_ARROWS
from masonry_opt.report.page.carried import UTILISATION, has_forces, resultants
from masonry_opt.report.page.drawing import KINDS, joints_by_kind


def caption(result: Result) -> str:
    """What is drawn, and how large it is."""
    size = f"{counted(result.size.blocks, 'block')}, {counted(result.size.joints, 'joint')}"
    if not has_mechanism(result):
        return f"{size}, at rest: no motion was found."
    if result.load_factor is not None:
        moved = "The mechanism of collapse, magnified."
    elif result.status is Status.UNSTABLE:
        moved = "How the scene falls under its dead load, magnified."
    else:
        moved = "The last motion tried, magnified: no collapse."
    return f'{size}. <span class="mechanism">{moved}</span>'


def marks(result: Result) -> list[str]:
    """Marks of the mechanism, blocks and loads, with their meaning."""
    drawn = []
    if has_mechanism(result):
        for kind in joints_by_kind(result):
            colour, width, dashes, words = KINDS[kind]
            cap = "butt" if kind == "crushes" else "round"
            d = "M14 6h0" if kind == "hinges" else "M3 6h22"
            style = f'stroke-width="{width}" stroke-linecap="{cap}" stroke-dasharray="{dashes}"'
            drawn.append(_mark(f'<path stroke="{colour}" {style} d="{d}"/>', words))
    return drawn + _blocks_and_loads(result)


def keys(result: Result) -> str:
    """A list of marks for each choice of what joints show."""
    line = f'<path stroke="{THRUST}" stroke-width="2.5" stroke-linecap="round" d="M3 10l22-8"/>'
    dot = f'<path stroke="{THRUST}" stroke-width="6" stroke-linecap="round" d="M14 6h0"/>'
    steps = ", ".join(
        f"{colour} {100 * number / len(UTILISATION):g}% {100 * (number + 1) / len(UTILISATION):g}%"
        for number, colour in enumerate(UTILISATION)
    )
    scale = f'<span class="scale" style="background: linear-gradient(90deg, {steps})"></span>'
    carried = "what a joint carries, where it acts"
    if has_forces(result):
        chosen = resultants(result)
        carried += "; through voussoirs the line of thrust" if len(chosen.line) else ""
        carried += f". The longest resultant is {chosen.longest:.4g}, in the case's unit of force"
    lists = {
        "mechanism": marks(result),
        "thrust": [
            _mark(line + dot, carried),
            *_blocks_and_loads(result),
        ],
        "utilisation": [
            f"force over its limit: 0{scale}1 (about to slide, hinge or crush)",
            _mark(f'<path stroke="{IDLE}" stroke-width="1.5" d="M3 6h22"/>', "idle joint"),
            *_blocks_and_loads(result),
        ],
    }
    written = ""
    for name, listed in lists.items():
        items = "".join(f"<li>{mark}</li>" for mark in listed)
        written += f'<ul class="{name}">{items}</ul>\n'
    return f'<div class="keys">\n{written}</div>\n'


def _blocks_and_loads(result: Result) -> list[str]:
    assembly = result.assembly
    found = [
        _mark(f'<path fill="{BLOCK}" stroke="#000" d="M1 1h26v10h-26z"/>', "block"),
        _mark(
            f'<path fill="{FIXED}" d="M1 1h26v10h-26z"/>'
            f'<path stroke="{HATCH}" d="M3 11l10-10M11 11l10-10M19 11l8-8"/>',
            "support",
        ),
    ]
    given = loads(assembly.scene, assembly.geometry, assembly.movable)
    kinds = [("dead", given.dead, FURTHER_DEAD, "further dead load")]
    if result.status.live_load_acts:
        kinds.insert(0, ("live", given.live, LIVE, "live load, times λ"))
    for kind, forces, colour, words in kinds:
        count = len(forces.force)
        if count or any(load.kind == kind for load in assembly.scene.edge_loads):
            drawn = f" (resultant of {count})" if count > MOST_ARROWS else ""
            found.append(_arrow(colour, 0.0, words + drawn))
    if len(given.weight.force):
        x, y = assembly.scene.gravity
        found.append(_arrow(DEAD, float(np.degrees(np.arctan2(-y, x))), "all weights (not drawn)"))
    return found


def _arrow(colour: str, angle: float, words: str) -> str:
    return _mark(
        f'<path stroke="{colour}" stroke-width="1.6" transform="rotate({angle:.0f} 14 6)" '
        'd="M8.5 6h11m-4-3l4 3l-4 3"/>',
        words,
    )


def _mark(drawn: str, words: str) -> str:
    return f'<svg width="28" height="12" fill="none" aria-hidden="true">{drawn}</svg> {words}'
