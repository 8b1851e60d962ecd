"""One page of a result: a single file of HTML that needs no network."""

from __future__ import annotations

import json
from base64 import b64encode
from html import escape
from importlib.metadata import version
from importlib.resources import files
from string import Template

import numpy as np

from masonry_opt.answer.result import Result
from masonry_opt.answer.thresholds import IDLE
from masonry_opt.drawing.colours import UTILISATION
from masonry_opt.drawing.curve import curve_picture
from masonry_opt.drawing.elements import KINDS, START, UTILISATION_LABEL, Elements, result_elements
from masonry_opt.drawing.found import counts
from masonry_opt.drawing.svg import Canvas, blocks_svg, group, legend_svg, marks_svg
from masonry_opt.errors import printable
from masonry_opt.files import WRITER
from masonry_opt.words.page import answer, certificate, described, text

#: Columns of ``Result.joints`` that the page tells of a joint.
_COLUMNS = ("n", "s", "m", "slip", "opening", "utilisation")


def page(result: Result, kind: str = "mechanism") -> str:
    """The page as text: load factor, how sure it is, certificate, warnings, and the scene.

    A slider moves the mechanism, and pointing at a joint tells its forces and motion. Joints first show their
    motion, or by ``kind`` "thrust" or "utilisation".
    """
    elements = result_elements(result)
    canvas = Canvas(elements, elements.all_marks)
    groups = {"loads": elements.loads}
    groups |= {f"layer {name}": marks for name, marks in elements.layers.items()}
    drawn = [group(name, (marks_svg(each, canvas) for each in marks)) for name, marks in groups.items()]
    folder = files("masonry_opt.drawing")
    title, ratio = elements.title, canvas.width / canvas.height
    return Template(folder.joinpath("page.html").read_text(encoding="utf-8")).substitute(
        writer=WRITER,
        title=escape(title),
        style=folder.joinpath("page.css").read_text(encoding="utf-8"),
        answer=answer(result),
        picture=canvas.svg(
            f"picture of {title}",
            [blocks_svg(elements, canvas), *drawn],
            f'class="picture" style="--ratio: {ratio:.4f}"',
        ),
        caption=caption(elements),
        choices=_choices(elements, kind),
        start=START,
        still="" if elements.movement else " disabled",
        legends=_legends(elements),
        last=result.size.joints - 1,
        details=_curve(result) + certificate(result) + described(result) + _foot(result),
        data=_data(result, canvas),
        script=folder.joinpath("page.js").read_text(encoding="utf-8"),
    )


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
            entries.insert(0, f"{UTILISATION_LABEL}: {scale}")
        items = "".join(f"<li>{entry}</li>" for entry in entries)
        written += f'<ul class="{kind}">{items}</ul>\n'
    return written


def _curve(result: Result) -> str:
    """λ over displacement, if it was asked for, as a picture that brings nothing into the page but itself."""
    if result.curve is None or result.curve.empty:
        return ""
    source = b64encode(curve_picture(result).image("svg")).decode()
    return f'<img class="curve" alt="λ over displacement" src="data:image/svg+xml;base64,{source}">\n'


def _foot(result: Result) -> str:
    origin = result.assembly.scene.origin
    known = [
        *([origin] if origin != "scene" else []),
        f"method {result.method} ({result.model}, {result.solver})",
        f"masonry_opt {version('masonry_opt')}",
    ]
    return f'<p class="note">{text(" · ".join(known))}</p>\n'


def _data(result: Result, canvas: Canvas) -> str:
    """Names of blocks, and joints by columns, as JSON that may stand in HTML."""
    assembly, frame = result.assembly, result.joints
    joints = assembly.joints
    start, end = canvas.at(joints.start), canvas.at(joints.end)
    columns: dict[str, list[float | None]] = {
        "first": joints.first.tolist(),
        "second": joints.second.tolist(),
        "x": start[:, 0].tolist(),
        "y": start[:, 1].tolist(),
        "dx": (end - start)[:, 0].tolist(),
        "dy": (end - start)[:, 1].tolist(),
    }
    for name in _COLUMNS:
        columns[name] = _rounded(frame[name].to_numpy())
    data = {"blocks": [printable(block.name) for block in assembly.scene.blocks], "joints": columns}
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _rounded(values: np.ndarray) -> list[float | None]:
    """Five digits of each number, None in place of NaN, what is next to nothing as 0."""
    nothing = IDLE * np.nan_to_num(np.abs(values)).max(initial=0.0)
    return [
        None if np.isnan(value) else 0 if abs(value) <= nothing else float(f"{value:.5g}") for value in values
    ]
