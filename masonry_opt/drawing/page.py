"""A result as HTML: a page in one file that needs no network, and what a notebook shows, without a script."""

import json
import re
from functools import cache
from html import escape
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from masonry_opt.answer.motion import fastest, yielded_on
from masonry_opt.answer.outcome import Outcome
from masonry_opt.answer.solution import Way
from masonry_opt.answer.thresholds import IDLE
from masonry_opt.drawing.colours import BLOCK, FIXED, HINGES, SLIDES, UTILISATION
from masonry_opt.drawing.elements import KINDS, START, Elements, counts, motion_of, result_elements
from masonry_opt.drawing.figure import curve_picture, is_page, refuse_file, refuse_kind
from masonry_opt.drawing.forces import utilisation_label
from masonry_opt.drawing.marks import Marks, shrink_of, size_of
from masonry_opt.drawing.pictures import elements_picture
from masonry_opt.drawing.solids import ViewAngles, best_view, refuse_view, surface
from masonry_opt.drawing.svg import Canvas, blocks_svg, group, legend_svg, marks_svg
from masonry_opt.errors import OptionError, printable
from masonry_opt.files import WRITER
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.tables import library
from masonry_opt.words.page import answer, begins, certificate, described, headline, load_factor_rows, text
from masonry_opt.words.sentences import message, numeral, sentences

PUSH, _TURN = "push", 100_000  #: What joints show along a push, and units of a rotation of one.

_UNITS = 20_000  #: Of the figure along the scene's size: whole coordinates keep large scenes short.

#: Half the width of a mark of a point's width, over the size of the scene: of loads and resultants, which are
#: seen through blocks, and of marks on joints, these at most over the size of a usual joint.
_RADIUS_THROUGH, _RADIUS, _OF_JOINT = 1 / 900, 1 / 500, 1 / 80

#: What three.js ends with in the page that trimesh puts it in.
_END = 'Object.defineProperty(t,"__esModule",{value:!0})}));'


def refuse_saving(
    scene: Scene,
    path: str | Path,
    kind: str,
    names: bool = False,
    force: bool = False,
    view: ViewAngles | None = None,
) -> None:
    """Raise OptionError if a result of a scene could not be written so, before long work."""
    refuse_kind(kind, names)
    refuse_view(scene, view)
    if is_page(path) and names:
        raise OptionError(f"{path}: a page tells the blocks of each joint: leave names to pictures")
    refuse_file(path, force)
    if is_page(path) and scene.dimension == 3:
        three()


def page(result: Outcome, kind: str = "mechanism", view: ViewAngles | None = None) -> str:
    """The page as text: load factor, how sure it is, certificate, warnings, and the scene.

    A slider goes along the load history to collapse, if there is one, another moves the mechanism, and
    pointing at a joint tells its forces and motion. Joints first show their motion, or by ``kind`` "thrust"
    or "utilisation". A scene in space turns, and is first seen from ``view``.
    """
    elements, folder, way = result_elements(result), files("masonry_opt.drawing"), way_of(result)
    name, figure, data = (_plane if result.contacts is None else _space)(result, elements, view, way)
    values: dict[str, Any] = {"title": escape(elements.title), **figure}

    def piece(name: str) -> str:
        """What a file of this room says with the values, nothing if there is none."""
        file = folder.joinpath(name)
        return Template(file.read_text(encoding="utf-8")).substitute(values) if file.is_file() else ""

    values |= {part: piece(f"page_{name}_{part}.html") for part in ("controls", "block", "joint")}
    values |= {"picture": piece(f"page_{name}_picture.html") or figure["picture"]}
    layers = elements.layers
    if way is not None:
        layers = layers | {PUSH: way_marks(result)}
        data["way"] = way_data(result, way, data.pop("motions"))
        values |= {"count": len(way.d), "last_frame": len(way.d) - 1}
        values["push_ends"] = "" if result.end is None else " to collapse"
    blocks = [printable(block.name) for block in result.assembly.scene.blocks]
    joints = _joints(result, re.findall(r'data-of="(\w+)"', values["joint"])) | data.pop("joints")
    values |= {"writer": WRITER, "data": _json({"blocks": blocks, "joints": joints, **data})}
    values |= {"answer": answer(result), "caption": caption(elements), "last": result.size.joints - 1}
    values |= {"start": START, "still": "" if elements.movement else " disabled"}
    values |= {"choices": _choices(layers, kind), "legends": _legends(elements, layers)}
    values["way"] = "" if way is None else piece("page_way.html")
    values["details"] = _curve(result) + certificate(result) + described(result) + _foot(result)
    scripts = {"style": "page.css", "figure_script": f"page_{name}.js"}
    scripts |= {"way_script": "page_way.js", "script": "page.js"}
    values |= {key: folder.joinpath(file).read_text(encoding="utf-8") for key, file in scripts.items()}
    return piece("page.html")


#: What the figure of a page is: its name, values of its templates, and data of its script.
_FigureOf = tuple[str, dict[str, str], dict[str, Any]]


def _plane(result: Outcome, elements: Elements, _: ViewAngles | None, way: Way | None) -> _FigureOf:
    canvas, joints = Canvas(elements, elements.all_marks), result.assembly.joints
    groups = {"loads": elements.loads} | {f"layer {name}": of for name, of in elements.layers.items()}
    drawn = [group(name, (marks_svg(each, canvas) for each in marks)) for name, marks in groups.items()]
    start, end = canvas.at(joints.start), canvas.at(joints.end)
    (x, y), (dx, dy) = start.T.tolist(), (end - start).T.tolist()
    picture = canvas.svg(f"picture of {elements.title}", [blocks_svg(elements, canvas), *drawn])
    data: dict[str, Any] = {"joints": {"x": x, "y": y, "dx": dx, "dy": dy}}
    if way is not None:
        data["motions"] = canvas.motions(way_motions(result, way))
    return "plane", {"picture": picture, "library": ""}, data


def _space(result: Outcome, elements: Elements, view: ViewAngles | None, way: Way | None) -> _FigureOf:
    """The figure turns; beside it is a picture, for browsers that draw no solids, and for print."""
    view = view or best_view(elements)
    rates = [_rounded(result.blocks.filter(regex=f"^{kind}").to_numpy().ravel()) for kind in "vw"]
    moves: list[dict[str, list[float | None]] | None] = [None] * len(elements.motion)
    for row, block in enumerate(result.assembly.movable if elements.movement else ()):
        moves[block] = {kind: of[3 * row : 3 * row + 3] for kind, of in zip("vw", rates, strict=True)}
    source = elements_picture(elements, view=view).source()
    fixed = np.setdiff1d(np.arange(len(moves)), result.assembly.movable)
    values = {"source": source, "view": "{:g} {:g}".format(*view), "library": f"<script>{three()}</script>\n"}
    scale = _UNITS / size_of(elements.assembly)
    data = {"figure": _figure(elements, view, scale), "rates": moves, "fixed": fixed.tolist()}
    if way is not None:
        data["motions"] = way_motions(result, way) * np.repeat([scale, 1.0], 3)
    return "space", values, {"joints": {}, **data}


def caption(elements: Elements) -> str:
    """What is drawn, and how large it is."""
    size = counts(elements.assembly)
    if not elements.movement:
        return f"{size}, at rest: no motion was found."
    moved = elements.movement[0].upper() + elements.movement[1:]
    return f'{size}. <span class="mechanism">{moved}.</span>'


def _choices(layers: dict[str, list[Marks]], first: str) -> str:
    """What joints show, of what there is."""
    states = {kind: "" if kind in layers else " disabled" for kind in (PUSH, *KINDS)}
    states[first if first in layers else "mechanism"] = " checked"
    choice = '<label><input type="radio" name="show" value="{0}"{1}> {0}</label>\n'
    return "".join(choice.format(kind, state) for kind, state in states.items())


def _legends(elements: Elements, layers: dict[str, list[Marks]]) -> str:
    """A legend for each choice of what joints show."""
    steps = ", ".join(
        f"{colour} {100 * number / len(UTILISATION):g}% {100 * (number + 1) / len(UTILISATION):g}%"
        for number, colour in enumerate(UTILISATION)
    )
    scale = f'0<span class="scale" style="background: linear-gradient(90deg, {steps})"></span>1'
    written = ""
    for kind in (PUSH, *KINDS):
        entries = legend_svg([*layers.get(kind, ()), *elements.loads])
        if kind == "utilisation":
            entries.insert(0, f"{utilisation_label(elements.assembly)}: {scale}")
        items = "".join(f"<li>{entry}</li>" for entry in entries)
        written += f'<ul class="{kind}">{items}</ul>\n'
    return written


def _curve(result: Outcome) -> str:
    """λ over displacement, if it was asked for, as a picture that brings nothing into the page but itself."""
    if result.curve is None or result.curve.empty:
        return ""
    return f'<img class="curve" alt="λ over displacement" src="{curve_picture(result).source("svg")}">\n'


def _foot(result: Outcome) -> str:
    origin = result.assembly.scene.origin
    said = f"method {result.method} ({result.model}, {result.solver}) · masonry_opt {version('masonry_opt')}"
    return f'<p class="note">{text(said if origin == "scene" else f"{origin} · {said}")}</p>\n'


def _joints(result: Outcome, told: list[str]) -> dict[str, list[float | None]]:
    """Joints by columns: their blocks, and what is told of them."""
    joints, frame = result.assembly.joints, result.joints
    beside: dict[str, float] = {}
    if result.contacts is not None:
        # Where a column is zero but for rounding, forces and the fastest motion show that it is.
        force, length = float(frame["n"].abs().max()), 2 * result.assembly.problem.length_unit
        speed = 1.0 if result.solution.d is None else fastest(result.assembly, result.solution.d)
        beside = {"s": force, "torsion": force * length}
        beside |= {"slip": speed, "opening": speed, "rotation": speed / length}
    columns = {name: _rounded(frame[name].to_numpy(), beside.get(name, 0.0)) for name in told}
    return {"first": joints.first.tolist(), "second": joints.second.tolist(), **columns}


def _json(data: dict[str, Any]) -> str:
    """Data as JSON that may stand in HTML."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _rounded(values: np.ndarray, beside: float = 0.0) -> list[float | None]:
    """Five digits of each number; None for NaN, 0 for what is nothing beside the largest, or ``beside``."""
    nothing = IDLE * np.nan_to_num(np.abs([*values, beside])).max()
    shown = (0 if abs(value) <= nothing else float(f"{value:.5g}") for value in values)
    return [None if np.isnan(value) else value for value in shown]


def way_of(result: Outcome) -> Way | None:
    """Return the keyframes of the load history; None if it led to no load factor."""
    state = result.solution.at_expected
    return state.way() if state is not None and state.load_factor is not None and state.way else None


def way_motions(result: Outcome, way: Way) -> np.ndarray:
    """Motions of movable blocks at each keyframe, (k, b, 3) or (k, b, 6), the last as large as a full one."""
    assembly = result.assembly
    return np.stack([motion_of(assembly, d, way.d[-1])[assembly.movable] for d in way.d])


def way_marks(result: Outcome) -> list[Marks]:
    """How joints are marked that have slid, and that have opened."""
    dimension, width = result.assembly.scene.dimension, 2.3 * shrink_of(result.assembly)
    dashes, nowhere = (1.6, 1.1) if dimension == 2 else (), np.empty((0, 2, dimension))
    opened = Marks("open", "has opened", "line", HINGES, 0.7 * width, nowhere, dashes=dashes)
    return [Marks("slid", "has slid", "line", SLIDES, width, nowhere), opened]


def way_data(result: Outcome, way: Way, motions: np.ndarray) -> dict[str, Any]:
    """What a page shows at each keyframe, motions in the figure's units; events tell what began last."""
    assembly, moves = result.assembly, yielded_on(result.assembly, way)
    starts = moves & ~np.maximum.accumulate(np.concatenate([np.zeros_like(moves[:1]), moves[:-1]]))
    events = ["no joint has slid or opened yet"]
    for load, (slide, part) in zip(way.load_factor[1:], starts[1:], strict=True):
        new = begins(assembly.pairs_of(slide), assembly.pairs_of(part), load)
        events.append(new or events[-1])
    if result.end is not None:
        events[-1] = f"moves on at λ = {numeral(result.end, '.3g')}: collapse"
    along = way.displacement * assembly.problem.live_displacement
    u, loads = ([float(f"{value:.4g}") for value in of] for of in (along, way.load_factor))
    slid, opened = ([np.flatnonzero(joints).tolist() for joints in kind] for kind in moves.swapaxes(0, 1))
    # Lengths of the figure are whole; so, scaled, are rotations, which keeps large scenes short.
    scales = np.where(np.arange(motions.shape[-1]) < assembly.scene.dimension, 1, _TURN)
    whole = np.rint(motions * scales).astype(int).reshape(len(motions), -1)
    marks = [[each.colour, each.width, each.dashes] for each in way_marks(result)]
    data = {"displacement": u, "load_factor": loads, "expected": result.expected}
    data |= {"blocks": assembly.movable.tolist(), "motions": whole.tolist(), "scales": (1 / scales).tolist()}
    return data | {"marks": marks, "joints": [slid, opened], "events": events}


MOST_BLOCKS = 2000  #: Blocks above which there is no picture: a notebook keeps all that it shows.
_WIDTH = 560  #: Width of the picture at most, in pixels.


def notebook_html(result: Outcome) -> str:
    """Load factor, status, picture and certificate of a result, as HTML that stands by itself."""
    elements = result_elements(result)
    status = text(": ".join(filter(None, (result.status, message(result.reasons, result.method)))))
    lines = [f"<b>{text(elements.title)}</b>", f'<span style="font-size:1.4em">{headline(result)}</span>']
    lines += [status, load_factor_rows(result)]
    lines += [f"Warning: {text(words)}" for words in sentences(result.warnings)]
    if result.size.blocks <= MOST_BLOCKS:
        # With its own title and legend.
        source = elements_picture(elements).source()
        lines.append(f'<img alt="picture of {text(elements.title)}" style="width:100%" src="{source}">')
    lines.append(caption(elements))
    if result.certificate is not None:
        left = (f"{name} {numeral(value, '.1e')}" for name, value in result.certificate.as_dict().items())
        lines.append(f"certificate: {' · '.join(left)}")
    rows = "".join(f"<div>{line}</div>\n" for line in lines)
    return f'<div style="max-width:{_WIDTH}px;overflow-wrap:break-word">\n{rows}</div>'


@cache
def three() -> str:
    """The script three.js, with its licence, as trimesh brings it. Raises OptionError if trimesh, of the
    extra "meshes", is not installed, or brings another one."""
    why = "pages of solids need trimesh, which brings three.js; install it with: pip install '.[meshes]'"
    trimesh, viewer = library("trimesh", why), library("trimesh.viewer", why)
    whole = viewer.scene_to_html(trimesh.creation.box().scene())
    script, end, _ = whole.partition("<script>")[2].partition(_END)
    if not end or "</script" in script:
        why = "brings no known three.js: install that of constraints.txt"
        raise OptionError(f"trimesh {trimesh.__version__} {why}")
    return f"{script}{end}"


def _figure(elements: Elements, view: ViewAngles, scale: float) -> dict[str, Any]:
    """All that a page draws of elements in space, in whole units of the figure: see ``page_space.js``."""
    contacts, drawn = elements.assembly.joints, surface(elements)
    areas = contacts.extent[contacts.extent > 0]
    usual = np.sqrt(np.median(areas)) if len(areas) else np.inf
    radius = min(_RADIUS * _UNITS, _OF_JOINT * usual * scale)
    table: dict[tuple[float, ...], int] = {(0.0,) * 6: 0}

    def at(points: np.ndarray) -> list[int]:
        whole: list[int] = np.rint(points * scale).astype(int).ravel().tolist()
        return whole

    def in_figure(motion: np.ndarray) -> tuple[float, ...]:
        moved = np.round(motion[:3] * scale, 1) + 0.0
        return (*moved.tolist(), *(np.round(motion[3:], 6) + 0.0).tolist())

    def drawn_as(marks: Marks) -> dict[str, Any]:
        motion = None
        if marks.motion is not None:
            motion = [table.setdefault(in_figure(each), len(table)) for each in marks.motion]
        half = marks.width * (_RADIUS_THROUGH * _UNITS if marks.through else radius)
        placed = {"shape": marks.shape, "points": at(marks.points), "motion": motion}
        look = {"radius": round(half, 2), "colour": marks.colour, "dashes": marks.dashes}
        return {**placed, **look, "through": marks.through}

    corners = np.concatenate([drawn.triangles.reshape(-1, 3), drawn.edges.reshape(-1, 3)])
    block = np.concatenate([np.repeat(drawn.of_triangle, 3), np.repeat(drawn.of_edge, 2)])
    numbered = np.column_stack([block, np.reshape(at(corners), (-1, 3))])
    rows, number = np.unique(numbered, axis=0, return_inverse=True)
    triangles, edges = np.split(number, [3 * len(drawn.triangles)])
    middle = (rows[:, 1:].min(axis=0) + rows[:, 1:].max(axis=0)) / 2
    lines, joint = contacts.lines()
    layers = elements.layers | {"loads": elements.loads}
    return {
        "size": _UNITS,
        "middle": middle.tolist(),
        "view": view,
        "block": BLOCK,
        "fixed": FIXED,
        "radius": round(3 * radius, 2),
        "surface": {
            "points": rows[:, 1:].ravel().tolist(),
            "of": rows[:, 0].tolist(),
            "triangles": triangles.tolist(),
            "edges": edges.tolist(),
            "hatching": at(drawn.hatching),
        },
        "motions": [in_figure(motion) for motion in elements.motion],
        "outlines": {"points": at(lines), "of": joint.tolist()},
        "layers": {name: [drawn_as(each) for each in marks] for name, marks in layers.items()},
        "table": list(table),
    }
