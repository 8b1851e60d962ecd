"""One page of a result: a single file of HTML that needs no network."""

from __future__ import annotations

import json
from base64 import b64encode
from html import escape
from importlib.metadata import version
from importlib.resources import files
from string import Template
from typing import Any

import numpy as np

from masonry_opt.answer.motion import fastest
from masonry_opt.answer.outcome import Outcome
from masonry_opt.answer.thresholds import IDLE
from masonry_opt.drawing.colours import UTILISATION
from masonry_opt.drawing.curve import curve_picture
from masonry_opt.drawing.elements import KINDS, START, Elements, result_elements, utilisation_label
from masonry_opt.drawing.found import counts
from masonry_opt.drawing.pictures import result_picture
from masonry_opt.drawing.solid_figure import Figure, three
from masonry_opt.drawing.svg import Canvas, blocks_svg, group, legend_svg, marks_svg
from masonry_opt.drawing.view import ViewAngles, best_view
from masonry_opt.errors import printable
from masonry_opt.files import WRITER
from masonry_opt.words.page import answer, certificate, described, text

#: Columns of ``Result.joints`` that the page tells of a joint, and what they are, in the plane and in space.
_RATES = {"slip": "slip, as a rate", "opening": "opening, as a rate"}
_COLUMNS = {
    2: {
        "n": "<i>n</i>, normal (compression +)",
        "s": "<i>s</i>, shear",
        "m": "<i>m</i>, moment about the middle",
        **_RATES,
        "utilisation": "utilisation, force over its limit",
    },
    3: {
        "n": "<i>n</i>, normal (compression +)",
        "s": "<i>s</i>, size of the shear",
        "torsion": "torsion about the normal",
        **_RATES,
        "rotation": "rotation, as a rate",
        "utilisation": "utilisation, shear over its limit",
    },
}
_NOTE = {
    2: "<i>n</i> and <i>s</i> act on the first block, <i>s</i> along the joint, a quarter turn clockwise of "
    "<i>n</i>; rates are of its motion against the second. Units are those of the case.",
    3: "Forces act on the first block; rates are of its motion against the second. Units are those of the "
    "case.",
}


def page(result: Outcome, kind: str = "mechanism", view: ViewAngles | None = None) -> str:
    """The page as text: load factor, how sure it is, certificate, warnings, and the scene.

    A slider moves the mechanism, and pointing at a joint tells its forces and motion. Joints first show their
    motion, or by ``kind`` "thrust" or "utilisation". A scene in space turns, and is first seen from ``view``.
    """
    elements, dimension = result_elements(result), result.assembly.scene.dimension
    figure = _in_space(result, elements, view) if dimension == 3 else _in_the_plane(result, elements)
    title, folder = elements.title, files("masonry_opt.drawing")

    def read(name: str) -> str:
        return folder.joinpath(name).read_text(encoding="utf-8")

    data = {
        "blocks": [printable(block.name) for block in result.assembly.scene.blocks],
        "joints": _joints(result) | figure.pop("joints"),
        **figure.pop("data"),
    }
    rows = "".join(
        f'<tr><th scope="row">{words}</th><td class="number" data-of="{name}"></td></tr>\n'
        for name, words in _COLUMNS[dimension].items()
    )
    return Template(read("page.html")).substitute(
        figure,
        writer=WRITER,
        title=escape(title),
        style=read("page.css"),
        answer=answer(result),
        caption=caption(elements),
        choices=_choices(elements, kind),
        start=START,
        still="" if elements.movement else " disabled",
        legends=_legends(elements),
        last=result.size.joints - 1,
        rows=rows,
        joint_note=_NOTE[dimension],
        details=_curve(result) + certificate(result) + described(result) + _foot(result),
        data=_json(data),
        figure_script=read("page_space.js" if dimension == 3 else "page_plane.js"),
        script=read("page.js"),
    )


def _in_the_plane(result: Outcome, elements: Elements) -> dict[str, Any]:
    """What the page's figure is: markup, scripts, and data."""
    canvas, joints = Canvas(elements, elements.all_marks), result.assembly.joints
    groups = {"loads": elements.loads}
    groups |= {f"layer {name}": marks for name, marks in elements.layers.items()}
    drawn = [group(name, (marks_svg(each, canvas) for each in marks)) for name, marks in groups.items()]
    start, end = canvas.at(joints.start), canvas.at(joints.end)
    columns = {"x": start[:, 0], "y": start[:, 1], "dx": (end - start)[:, 0], "dy": (end - start)[:, 1]}
    return {
        "picture": canvas.svg(
            f"picture of {elements.title}",
            [blocks_svg(elements, canvas), *drawn],
            f'class="picture" style="--ratio: {canvas.width / canvas.height:.4f}"',
        ),
        "controls": "",
        "block": "",
        "library": "",
        "joints": {name: values.tolist() for name, values in columns.items()},
        "data": {},
    }


def _in_space(result: Outcome, elements: Elements, view: ViewAngles | None) -> dict[str, Any]:
    """The same in space, where the figure turns; beside it a picture, for browsers that draw no solids, and
    for print."""
    view = view or best_view(elements)
    folder, frame = files("masonry_opt.drawing"), result.blocks
    rates = [_rounded(frame.filter(regex=f"^{kind}").to_numpy().ravel()) for kind in "vw"]
    moves: list[dict[str, list[float | None]] | None] = [None] * len(elements.motion)
    for row, block in enumerate(result.assembly.movable if elements.movement else ()):
        moves[block] = {kind: of[3 * row : 3 * row + 3] for kind, of in zip("vw", rates, strict=True)}
    source = b64encode(result_picture(result, view=view).image("png")).decode()
    fixed = np.setdiff1d(np.arange(len(moves)), result.assembly.movable)
    azimuth, elevation = view
    return {
        "picture": Template(folder.joinpath("page_space.html").read_text(encoding="utf-8")).substitute(
            title=escape(elements.title), source=source
        ),
        "controls": Template(
            folder.joinpath("page_space_controls.html").read_text(encoding="utf-8")
        ).substitute(view=f"{azimuth:g} {elevation:g}"),
        "block": folder.joinpath("page_space_block.html").read_text(encoding="utf-8"),
        "library": f"<script>{three()}</script>\n",
        "joints": {},
        "data": {"figure": Figure(elements).data(view), "rates": moves, "fixed": fixed.tolist()},
    }


def caption(elements: Elements) -> str:
    """What is drawn, and how large it is."""
    size = counts(elements.assembly)
    if not elements.movement:
        return f"{size}, at rest: no motion was found."
    moved = elements.movement[0].upper() + elements.movement[1:]
    return f'{size}. <span class="mechanism">{moved}.</span>'


def _choices(elements: Elements, first: str) -> str:
    """What joints show, of what there is."""
    first = first if first in elements.layers else "mechanism"
    choices = ""
    for kind in KINDS:
        state = " checked" if kind == first else "" if kind in elements.layers else " disabled"
        choices += f'<label><input type="radio" name="show" value="{kind}"{state}> {kind}</label>\n'
    return choices


def _legends(elements: Elements) -> str:
    """A legend for each choice of what joints show."""
    steps = ", ".join(
        f"{colour} {100 * number / len(UTILISATION):g}% {100 * (number + 1) / len(UTILISATION):g}%"
        for number, colour in enumerate(UTILISATION)
    )
    scale = f'0<span class="scale" style="background: linear-gradient(90deg, {steps})"></span>1'
    written = ""
    for kind in KINDS:
        entries = legend_svg([*elements.layers.get(kind, ()), *elements.loads])
        if kind == "utilisation":
            entries.insert(0, f"{utilisation_label(elements.assembly)}: {scale}")
        items = "".join(f"<li>{entry}</li>" for entry in entries)
        written += f'<ul class="{kind}">{items}</ul>\n'
    return written


def _curve(result: Outcome) -> str:
    """λ over displacement, if it was asked for, as a picture that brings nothing into the page but itself."""
    if result.curve is None or result.curve.empty:
        return ""
    source = b64encode(curve_picture(result).image("svg")).decode()
    return f'<img class="curve" alt="λ over displacement" src="data:image/svg+xml;base64,{source}">\n'


def _foot(result: Outcome) -> str:
    origin = result.assembly.scene.origin
    known = [
        *([origin] if origin != "scene" else []),
        f"method {result.method} ({result.model}, {result.solver})",
        f"masonry_opt {version('masonry_opt')}",
    ]
    return f'<p class="note">{text(" · ".join(known))}</p>\n'


def _joints(result: Outcome) -> dict[str, list[float | None]]:
    """Joints by columns."""
    joints, frame = result.assembly.joints, result.joints
    beside: dict[str, float] = {}
    if result.assembly.scene.dimension == 3:
        # Where a column is zero but for rounding, forces and the fastest motion show that it is.
        force, length = float(frame["n"].abs().max()), 2 * result.assembly.problem.length_unit
        speed = 1.0 if result.solution.d is None else fastest(result.assembly, result.solution.d)
        beside = {"s": force, "torsion": force * length, "slip": speed, "opening": speed}
        beside["rotation"] = speed / length
    columns = {
        name: _rounded(frame[name].to_numpy(), beside.get(name, 0.0))
        for name in _COLUMNS[result.assembly.scene.dimension]
    }
    return {"first": joints.first.tolist(), "second": joints.second.tolist(), **columns}


def _json(data: dict[str, Any]) -> str:
    """Data as JSON that may stand in HTML."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _rounded(values: np.ndarray, beside: float = 0.0) -> list[float | None]:
    """Five digits of each number, None in place of NaN, what is next to nothing beside the largest, or a
    number that is larger, as 0."""
    nothing = IDLE * np.nan_to_num(np.abs([*values, beside])).max()
    return [
        None if np.isnan(value) else 0 if abs(value) <= nothing else float(f"{value:.5g}") for value in values
    ]
