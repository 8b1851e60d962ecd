"""Results as HTML: a page in one file that needs no network, and a summary for notebooks, without scripts."""

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

from masonry_opt.drawing.colours import BLOCK, HINGING_COLOUR, SLIDING_COLOUR, SUPPORT_COLOUR, UTILISATION
from masonry_opt.drawing.elements import (
    PICTURE_KINDS,
    SHOWN_MOTION_SHARE,
    Elements,
    counts,
    motion_of,
    result_elements,
)
from masonry_opt.drawing.figure import curve_picture, is_page, refuse_file, refuse_kind
from masonry_opt.drawing.forces import utilisation_label
from masonry_opt.drawing.keyframes import Keyframes, keyframes_of
from masonry_opt.drawing.marks import Marks, shrink_of, size_of
from masonry_opt.drawing.pictures import elements_picture
from masonry_opt.drawing.solids import ViewAngles, best_view, refuse_view, surface
from masonry_opt.drawing.svg import Canvas, blocks_svg, group, legend_svg, marks_svg
from masonry_opt.errors import OptionError, printable
from masonry_opt.files import WRITER
from masonry_opt.reporting.names import unbroken_values
from masonry_opt.reporting.page import (
    answer,
    begins,
    certificate,
    described,
    headline,
    load_factor_rows,
    text,
)
from masonry_opt.reporting.sentences import message, numeral, sentences
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.tables import library
from masonry_opt.solution.motion import fastest
from masonry_opt.solution.outcome import Outcome
from masonry_opt.solution.thresholds import NEGLIGIBLE_SHARE

HISTORY = "history"  #: Name of the layer with joints that have slid or opened during the load history.
#: Rotations in the data of a page are integers: radians times this factor, rounded. With a smaller value,
#: animated rotations are less smooth.
_ROTATION_FACTOR = 100_000

#: Size of the scene in the integer units of a figure in space. Coordinates are rounded to whole units; a
#: larger value makes larger pages.
_FIGURE_SIZE = 20_000

#: In a figure in space, the radius of marks that stay visible behind blocks is this number × ``Marks.width``
#: × the size of the scene.
_RADIUS_THROUGH = 1 / 900
#: In a figure in space, the radius of marks that blocks can hide is this number × ``Marks.width`` × the size
#: of the scene, unless ``_OF_JOINT`` limits it.
_RADIUS = 1 / 500
#: The radius of marks that blocks can hide is at most this number × ``Marks.width`` × √A, in which A is the
#: median joint area. Marks in scenes with small joints are therefore thinner.
_OF_JOINT = 1 / 80

#: Text at the end of the library three.js in the pages that trimesh writes. It separates the library from the
#: rest of the page.
_END_OF_LIBRARY = 'Object.defineProperty(t,"__esModule",{value:!0})}));'


def refuse_saving(
    scene: Scene,
    path: str | Path,
    kind: str,
    names: bool = False,
    force: bool = False,
    view: ViewAngles | None = None,
) -> None:
    """Raise OptionError if a result cannot be saved with the given options.

    Call this function before a long analysis.
    """
    refuse_kind(kind, names)
    refuse_view(scene, view)
    if is_page(path) and names:
        raise OptionError(
            f"{path}: a page does not show the names of all blocks: omit 'names', and move the mouse over a "
            "joint to see the names of its blocks"
        )
    refuse_file(path, force)
    if is_page(path) and scene.dimension == 3:
        three()


def page(result: Outcome, kind: str = "mechanism", view: ViewAngles | None = None) -> str:
    """Return the HTML page of a result: load factors, certificate, warnings, and a figure of the scene.

    One slider follows the load history to collapse, if there is a load history. Another slider moves the
    mechanism. Pointing at a joint shows its forces and motion. ``kind`` is the quantity that joints show
    first: "mechanism", "thrust" or "utilisation". A stable scene has no mechanism, and shows thrust instead.
    A scene in space can be turned; ``view`` is its first view.
    """
    if kind == "mechanism" and result.stability is not None:
        kind = "thrust"
    elements, folder, frames = result_elements(result), files("masonry_opt.drawing"), keyframes_of(result)
    name, figure, data = (_plane if result.contacts is None else _space)(result, elements, view, frames)
    values: dict[str, Any] = {"title": escape(elements.title), **figure}

    def fill_template(name: str) -> str:
        """Return the text of a template with the values filled in, or "" if the file does not exist."""
        file = folder.joinpath(name)
        return Template(file.read_text(encoding="utf-8")).substitute(values) if file.is_file() else ""

    values |= {part: fill_template(f"page_{name}_{part}.html") for part in ("controls", "block", "joint")}
    values |= {"picture": fill_template(f"page_{name}_picture.html") or figure["picture"]}
    layers = elements.layers
    if frames is not None:
        layers = layers | {HISTORY: history_marks(result)}
        data["history"] = history_data(result, frames, data.pop("motions"))
        values |= {"count": len(frames.d), "last_frame": len(frames.d) - 1}
    blocks = [printable(block.name) for block in result.assembly.scene.blocks]
    joints = _joints(result, re.findall(r'data-of="(\w+)"', values["joint"])) | data.pop("joints")
    values |= {"writer": WRITER, "data": _json({"blocks": blocks, "joints": joints, **data})}
    values |= {"answer": answer(result), "caption": caption(elements), "last": result.size.joints - 1}
    values |= {"start": SHOWN_MOTION_SHARE, "still": "" if elements.movement else " disabled"}
    values |= {"choices": _choices(layers, kind), "legends": _legends(elements, layers)}
    values["history"] = "" if frames is None else fill_template("page_history.html")
    values["details"] = _curve(result) + certificate(result) + described(result) + _foot(result)
    values |= {part: unbroken_values(values[part]) for part in ("answer", "details")}
    scripts = {"style": "page.css", "figure_script": f"page_{name}.js"}
    scripts |= {"history_script": "page_history.js", "script": "page.js"}
    values |= {key: folder.joinpath(file).read_text(encoding="utf-8") for key, file in scripts.items()}
    return fill_template("page.html")


#: Figure of a page, in three parts. The word "plane" or "space" selects the HTML templates. A dictionary
#: contains texts, keyed by the placeholders of the templates. Another dictionary contains the script's data.
_PageFigure = tuple[str, dict[str, str], dict[str, Any]]


def _plane(
    result: Outcome, elements: Elements, _: ViewAngles | None, frames: Keyframes | None
) -> _PageFigure:
    """Return the figure of a scene in the plane: an SVG picture whose elements the page can move."""
    canvas, joints = Canvas(elements, elements.all_marks), result.assembly.joints
    groups = {"loads": elements.loads} | {f"layer {name}": marks for name, marks in elements.layers.items()}
    drawn = [
        group(name, (marks_svg(mark_group, canvas) for mark_group in marks)) for name, marks in groups.items()
    ]
    start, end = canvas.at(joints.start), canvas.at(joints.end)
    (x, y), (dx, dy) = start.T.tolist(), (end - start).T.tolist()
    picture = canvas.svg(f"picture of {elements.title}", [blocks_svg(elements, canvas), *drawn])
    data: dict[str, Any] = {"joints": {"x": x, "y": y, "dx": dx, "dy": dy}}
    if frames is not None:
        data["motions"] = canvas.motions(motions_of(result, frames))
    return "plane", {"picture": picture, "library": ""}, data


def _space(
    result: Outcome, elements: Elements, view: ViewAngles | None, frames: Keyframes | None
) -> _PageFigure:
    """Return the figure of a scene in space, which the reader of the page can rotate.

    The figure includes a fixed picture for print, and for browsers that cannot draw solids.
    """
    view = view or best_view(elements.assembly)
    rates = [_rounded(result.blocks.filter(regex=f"^{kind}").to_numpy().ravel()) for kind in "vw"]
    moves: list[dict[str, list[float | None]] | None] = [None] * len(elements.motion)
    for row, block in enumerate(result.assembly.movable if elements.movement else ()):
        moves[block] = {kind: values[3 * row : 3 * row + 3] for kind, values in zip("vw", rates, strict=True)}
    source = elements_picture(elements, view=view).source()
    fixed = np.setdiff1d(np.arange(len(moves)), result.assembly.movable)
    values = {"source": source, "view": "{:g} {:g}".format(*view), "library": f"<script>{three()}</script>\n"}
    scale = _FIGURE_SIZE / size_of(elements.assembly)
    data = {"figure": _figure(elements, view, scale), "rates": moves, "fixed": fixed.tolist()}
    if frames is not None:
        data["motions"] = motions_of(result, frames) * np.repeat([scale, 1.0], 3)
    return "space", values, {"joints": {}, **data}


def caption(elements: Elements) -> str:
    """Return the caption of a drawing: numbers of blocks and joints, and a description of the motion."""
    numbers = counts(elements.assembly)
    if not elements.movement:
        return f"{numbers}, at rest."
    moved = elements.movement[0].upper() + elements.movement[1:]
    return f'{numbers}. <span class="mechanism">{moved}.</span>'


def _choices(layers: dict[str, list[Marks]], first: str) -> str:
    """Return HTML buttons that select the quantity drawn on joints. Buttons without data are disabled."""
    states = {kind: "" if kind in layers else " disabled" for kind in (HISTORY, *PICTURE_KINDS)}
    states[first if first in layers else "mechanism"] = " checked"
    choice = '<label><input type="radio" name="show" value="{0}"{1}> {0}</label>\n'
    return "".join(choice.format(kind, state) for kind, state in states.items())


def _legends(elements: Elements, layers: dict[str, list[Marks]]) -> str:
    """Return the HTML legends, one for each quantity that can be drawn on joints."""
    steps = ", ".join(
        f"{colour} {100 * number / len(UTILISATION):g}% {100 * (number + 1) / len(UTILISATION):g}%"
        for number, colour in enumerate(UTILISATION)
    )
    scale = f'0<span class="scale" style="background: linear-gradient(90deg, {steps})"></span>1'
    written = ""
    for kind in (HISTORY, *PICTURE_KINDS):
        entries = legend_svg([*layers.get(kind, ()), *elements.loads])
        if kind == "utilisation":
            entries.insert(0, f"{utilisation_label(elements.assembly)}: {scale}")
        items = "".join(f"<li>{entry}</li>" for entry in entries)
        written += f'<ul class="{kind}">{items}</ul>\n'
    return written


def _curve(result: Outcome) -> str:
    """Return the HTML picture of the load–displacement curve, or "" if the result has no curve."""
    if result.curve is None or result.curve.empty:
        return ""
    return f'<img class="curve" alt="λ over displacement" src="{curve_picture(result).source("svg")}">\n'


def _foot(result: Outcome) -> str:
    """Return the footer of a page: an HTML note with the case file, method, model, solver and version."""
    origin = result.assembly.scene.origin
    note = f"method {result.method} ({result.model}, {result.solver}) · masonry_opt {version('masonry_opt')}"
    return f'<p class="note">{text(note if origin == "scene" else f"{origin} · {note}")}</p>\n'


def _joints(result: Outcome, names: list[str]) -> dict[str, list[float | None]]:
    """Return data of the joints: the two blocks of each joint, and rounded columns of ``Outcome.joints``.

    ``names`` are the names of the columns.
    """
    joints, frame = result.assembly.joints, result.joints
    scales: dict[str, float] = {}
    if result.contacts is not None:
        # Compute a typical magnitude for columns of the table ``Outcome.joints``. Values that are negligible
        # relative to the typical magnitude of their column are rounding errors, and are set to zero.
        force, length = float(frame["n"].abs().max()), 2 * result.assembly.problem.length_unit
        speed = 1.0 if result.solution.d is None else fastest(result.assembly, result.solution.d)
        scales = {"s": force, "torsion": force * length}
        scales |= {"slip": speed, "opening": speed, "rotation": speed / length}
    columns = {name: _rounded(frame[name].to_numpy(), scales.get(name, 0.0)) for name in names}
    return {"first": joints.first.tolist(), "second": joints.second.tolist(), **columns}


def _json(data: dict[str, Any]) -> str:
    """Return data as JSON. Characters that have a meaning in HTML are escaped."""
    encoded = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return encoded.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _rounded(values: np.ndarray, scale: float = 0.0) -> list[float | None]:
    """Return numbers rounded to five significant digits; NaN becomes None.

    Numbers become 0 if they are negligible relative to the larger of ``scale`` and the largest number.
    """
    negligible = NEGLIGIBLE_SHARE * np.nan_to_num(np.abs([*values, scale])).max()
    rounded = (0 if abs(value) <= negligible else float(f"{value:.5g}") for value in values)
    return [None if np.isnan(value) else value for value in rounded]


def motions_of(result: Outcome, frames: Keyframes) -> np.ndarray:
    """Return the motions of movable blocks at each keyframe, shape (k, b, 3), in space (k, b, 6).

    Motions are scaled so that the last motion is a full motion; see ``elements.FULL_MOTION``.
    """
    assembly = result.assembly
    return np.stack([motion_of(assembly, d, frames.d[-1])[assembly.movable] for d in frames.d])


def history_marks(result: Outcome) -> list[Marks]:
    """Return the line styles and legend entries of joints that have slid and of joints that are open.

    The marks have no points, because the script of the page draws the lines along the joints.
    """
    dimension, width = result.assembly.scene.dimension, 2.3 * shrink_of(result.assembly)
    dashes, no_points = (1.6, 1.1) if dimension == 2 else (), np.empty((0, 2, dimension))
    opened = Marks("open", "is open", "line", HINGING_COLOUR, 0.7 * width, no_points, dashes=dashes)
    return [Marks("slid", "has slid", "line", SLIDING_COLOUR, width, no_points), opened]


def history_data(result: Outcome, frames: Keyframes, motions: np.ndarray) -> dict[str, Any]:
    """Return the load history as data for the script of a page, with one entry for each keyframe.

    ``motions`` are in the figure's units. The event of a keyframe is a sentence about the joints that most
    recently began to slide or to open.
    """
    assembly = result.assembly
    moves = np.stack([frames.has_slid, frames.is_open], axis=1)
    starts = moves & ~np.maximum.accumulate(np.concatenate([moves[:1], moves[:-1]]))
    events = ["under the dead load"]
    for load_factor, (sliding, opening) in zip(frames.load_factor[1:], starts[1:], strict=True):
        event = begins(assembly.pairs_of(sliding), assembly.pairs_of(opening), load_factor)
        events.append(event or events[-1])
    events[-1] = f"equilibrium is lost at λ = {numeral(result.incremental or 0.0, '.3g')}: collapse"
    u, loads = (
        [float(f"{value:.4g}") for value in values] for values in (frames.displacement, frames.load_factor)
    )
    joints = [[np.flatnonzero(row).tolist() for row in table] for table in (frames.has_slid, frames.is_open)]
    # Round lengths and scaled rotations to integers, to limit the size of pages of large scenes.
    scales = np.where(np.arange(motions.shape[-1]) < assembly.scene.dimension, 1, _ROTATION_FACTOR)
    whole = np.rint(motions * scales).astype(int).reshape(len(motions), -1)
    marks = [[style.colour, style.width, style.dashes] for style in history_marks(result)]
    data = {"displacement": u, "load_factor": loads, "incremental": result.incremental}
    data |= {"blocks": assembly.movable.tolist(), "motions": whole.tolist(), "scales": (1 / scales).tolist()}
    return data | {"marks": marks, "joints": joints, "events": events}


#: Largest number of blocks for which a notebook shows a picture. Pictures of larger scenes would make the
#: notebook's file too large. In reports, pictures of larger scenes are PNG instead of SVG.
MOST_BLOCKS_DRAWN = 2000
_NOTEBOOK_WIDTH = 560  #: Maximum width of a result in a notebook, in pixels.


def notebook_html(result: Outcome) -> str:
    """Return a self-contained HTML summary of a result: load factor, status, picture and certificate."""
    elements = result_elements(result)
    status = text(": ".join(filter(None, (result.status, message(result.reasons, result.method)))))
    lines = [f"<b>{text(elements.title)}</b>", f'<span style="font-size:1.4em">{headline(result)}</span>']
    lines += [status, load_factor_rows(result)]
    lines += [f"Warning: {text(words)}" for words in sentences(result.warnings)]
    if result.size.blocks <= MOST_BLOCKS_DRAWN:
        # The picture contains a legend, so the page adds no legend below the picture.
        source = elements_picture(elements).source()
        lines.append(f'<img alt="picture of {text(elements.title)}" style="width:100%" src="{source}">')
    lines.append(caption(elements))
    if result.certificate is not None:
        residuals = result.certificate.as_dict().items()
        unbroken = '<span style="white-space:nowrap">{}</span>'
        entries = (unbroken.format(f"{name} {numeral(value, '.1e')}") for name, value in residuals)
        lines.append(f"certificate: {' · '.join(entries)}")
    rows = "".join(f"<div>{line}</div>\n" for line in lines)
    return f'<div style="max-width:{_NOTEBOOK_WIDTH}px;overflow-wrap:break-word">\n{rows}</div>'


@cache
def three() -> str:
    """Return the text of the script three.js with its licence, taken from a page that trimesh writes.

    Raises OptionError if trimesh, of the extra "meshes", is not installed, or if its page has another form.
    """
    why = "pages of scenes in space need trimesh; install it with: pip install '.[meshes]'"
    trimesh, viewer = library("trimesh", why), library("trimesh.viewer", why)
    whole = viewer.scene_to_html(trimesh.creation.box().scene())
    script, end, _ = whole.partition("<script>")[2].partition(_END_OF_LIBRARY)
    if not end or "</script" in script:
        raise OptionError(
            f"trimesh {trimesh.__version__} contains an unknown version of three.js: install the version of "
            "trimesh that constraints.txt lists"
        )
    return f"{script}{end}"


def _figure(elements: Elements, view: ViewAngles, scale: float) -> dict[str, Any]:
    """Return the data that ``page_space.js`` draws, with coordinates in integer units of the figure.

    ``scale`` converts lengths of the case to units of the figure.
    """
    contacts, drawn = elements.assembly.joints, surface(elements)
    areas = contacts.extent[contacts.extent > 0]
    median_side = np.sqrt(np.median(areas)) if len(areas) else np.inf
    radius = min(_RADIUS * _FIGURE_SIZE, _OF_JOINT * median_side * scale)
    # Index of each distinct motion of marks.
    table: dict[tuple[float, ...], int] = {}

    def at(points: np.ndarray) -> list[int]:
        """Return the coordinates of points in integer units of the figure, as one flat list."""
        whole: list[int] = np.rint(points * scale).astype(int).ravel().tolist()
        return whole

    def in_figure(motion: np.ndarray) -> tuple[float, ...]:
        """Return a motion, shape (6,), in units of the figure, with rounded components."""
        moved = np.round(motion[:3] * scale, 1) + 0.0
        return (*moved.tolist(), *(np.round(motion[3:], 6) + 0.0).tolist())

    def drawn_as(marks: Marks) -> dict[str, Any]:
        """Convert marks to a dictionary for the page's script, with their points, style and motion."""
        motion = None
        if marks.motion is not None:
            motion = [table.setdefault(in_figure(row), len(table)) for row in marks.motion]
        half = marks.width * (_RADIUS_THROUGH * _FIGURE_SIZE if marks.through else radius)
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
        "size": _FIGURE_SIZE,
        "middle": middle.tolist(),
        "view": view,
        "block": BLOCK,
        "fixed": SUPPORT_COLOUR,
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
        "layers": {name: [drawn_as(mark_group) for mark_group in marks] for name, marks in layers.items()},
        "table": list(table),
    }
