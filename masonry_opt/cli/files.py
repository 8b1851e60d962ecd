"""Commands `masonry-opt draw`, `export` and `convert`: pictures, and files of other programs."""

import contextlib
import inspect
import os
import re
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import typer

import masonry_opt as mo
from masonry_opt.cli.command import CommandArguments, command, numbers, reader, waiting
from masonry_opt.drawing.elements import counts
from masonry_opt.drawing.figure import refuse_picture
from masonry_opt.drawing.pictures import doubts, scene_picture
from masonry_opt.drawing.solids import refuse_view
from masonry_opt.errors import CaseError, OptionError, counted, printable, rounded
from masonry_opt.exports.solid_files import SOLID_ENDS
from masonry_opt.files import refuse_replacing, refuse_unwritable, writing
from masonry_opt.problem.assembly import assemble
from masonry_opt.reporting.sentences import sentences
from masonry_opt.reporting.terminal import print_text, print_warnings
from masonry_opt.scene.blocks import Block
from masonry_opt.scene.case_file import CaseFile, MeshTable, as_scene, save
from masonry_opt.scene.drawings.dxf import DxfDrawing, read_with_layers
from masonry_opt.scene.drawings.mesh_files import MESHES
from masonry_opt.scene.tables import as_path, parse_file
from masonry_opt.solution.sense import warnings_of

#: Map from the ending of a file to the printed name of its format and the function that reads the file.
_READERS: dict[str, tuple[str, Callable[..., mo.Scene]]] = {
    ".dxf": ("a DXF drawing", mo.read_dxf),
    ".json": ("COMPAS data", mo.read_compas),
    **dict.fromkeys(MESHES, ("a mesh", mo.read_mesh)),
}

#: Names of the tolerances for reading drawings, COMPAS data and meshes, as they occur in error messages about
#: gaps and overlaps. The command ``convert`` adds the name of its option after each of them.
_TOLERANCE_NAMES = ("tolerance", "contact_tolerance", "outline_tolerance")

#: Largest number of corners of a mesh that is copied into a case file (about 1 MB). For a larger mesh, the
#: case file contains the path of the mesh file.
_MOST_CORNERS = 10_000
_METHOD = (
    "Method whose optimisation problem is exported: static (default), kinematic or global; for .nl files "
    "also mpec or mcp. For solids: method whose mechanism and forces are exported. By default, solids are "
    "exported at rest."
)
_INPUT_HELP = (
    "Drawing (.dxf), COMPAS data (.json), mesh (.obj, .ply, .stl, .glb, .gltf), or a folder of meshes."
)
_LIVE_HELP = "Live force on every movable block as a multiple of its weight, at the centroid."
_LIVE_LAYER_HELP = "DXF: Live force on the blocks of a layer, in place of --live; may be repeated."


@command(mo.draw, file=typer.Argument(metavar="FILE", help="File to write (.png, .svg, .pdf)."))
def draw(arguments: CommandArguments, case: Path, file: Path, load_case: str | None = None) -> None:
    """Write the picture to FILE, and print the numbers of blocks and joints, and warnings.

    Without --load-case the picture shows the loads of the scene itself, not those of its load cases.
    """
    force = arguments.pop("force", False)
    refuse_picture(file, force)
    scene = as_scene(case, load_case)
    refuse_view(scene, arguments.get("view"))
    assembly = assemble(scene, floating=True)
    with writing(file):
        scene_picture(assembly, **arguments).save(file, force)
    print_text(printable(f"{file}: {counts(assembly)}"))
    print_warnings(doubts(assembly))


@command(
    mo.export,
    leave="moved",
    method=typer.Option(help=_METHOD),
    file=typer.Argument(
        metavar="FILE",
        help="File to write: optimisation problem (.lp, .mps, .nl), clauses of a proof (.cnf), or solids "
        "(.obj, .glb, .gltf, .json).",
    ),
)
def export(arguments: CommandArguments, case: Path, file: Path, load_case: str | None = None) -> None:
    """Write FILE in the format of its ending, and print the names of all written files.

    For a .nl file, the names of rows and columns are written to a .row and a .col file.
    """
    exported: mo.Scene | mo.Result = as_scene(case, load_case)
    method = arguments.pop("method", None) if file.suffix.lower() in SOLID_ENDS else None
    if method:
        refuse_unwritable(file, arguments.get("force", False))
        with waiting("export", if_interrupted="no file was written") as work:
            steps: dict[str, Any] = {"phases": work.phase, "progress": work.step}
            exported = mo.solve(case, method, incremental=False, load_case=load_case, **steps)
    print_text("\n".join(printable(str(path)) for path in mo.export(exported, file, **arguments)))
    if isinstance(exported, mo.Result):
        print_warnings(exported.warning_sentences)
    elif file.suffix.lower() in SOLID_ENDS:
        print_warnings(_doubts_at_rest(exported))
    else:
        print_warnings(sentences(warnings_of(assemble(exported), None)))


def _forces(option: str) -> Any:
    """Return a function that parses the components of a force from text such as "1,0"."""
    return numbers(f"{option} '{{}}': write numbers separated by commas, such as 1,0")


@partial(reader, refusal="--live-layer '{}': write it as LAYER=X,Y, such as parapet=1,0")
def _of_layer(text: str) -> tuple[str, tuple[float, ...]]:
    """Split text such as "parapet=1,0" into the name of a layer and the live force on each of its blocks."""
    layer, force = text.rsplit("=", 1)
    return layer, _forces("--live-layer")(force)


def _direction(text: str) -> str | tuple[float, ...]:
    """Parse a direction, which is the name of an axis or a list of components."""
    return _forces("--along")(text) if "," in text else text


@command(
    mo.read_dxf,
    mo.read_compas,
    mo.read_mesh,
    labels=("DXF", "COMPAS", "meshes"),
    live=typer.Option(metavar="X,Y[,Z]", help=_LIVE_HELP, parser=_forces("--live")),
    live_layers=typer.Option(metavar="LAYER=X,Y[,Z]", help=_LIVE_LAYER_HELP, parser=_of_layer),
    along=typer.Option(metavar="x|y|z|X,Y,Z", parser=_direction),
    space=typer.Option(
        "--space/--plane",
        help="COMPAS: read blocks as solids (--space), or as outlines seen along a direction (--plane).",
    ),
    up=typer.Option(metavar="x|y|z"),
    layers=typer.Option(metavar="NAME"),
    without_layers=typer.Option(metavar="NAME"),
    fixed_layers=typer.Option(metavar="WORD"),
    window_layers=typer.Option(metavar="WORD"),
    fixed=typer.Option(metavar="NAME"),
    drawing=typer.Argument(metavar="IN", help=_INPUT_HELP),
    out=typer.Argument(metavar="OUT", help="Case file (.toml or .json)."),
)
def convert(arguments: CommandArguments, drawing: Path, out: Path, force: bool = False) -> None:
    """Read the drawing IN, and write the case file OUT.

    The page docs/drawings.md explains layers, names, arcs, COMPAS data and meshes.

    If IN is a case file and OUT is a .dxf file, the blocks are drawn. A mesh of more than 10,000 corners is
    not copied: the case file contains its path instead.
    """
    if out.suffix.lower() == ".dxf":
        refuse_replacing(out, force)
        _refuse(arguments, {}, f"{out}: the drawing of a case file")
        scene = mo.load(drawing)
        mo.write_dxf(scene, out, force)
        _print_counts(scene, out)
        print_warnings(_doubts_at_rest(scene))
        return
    as_path(out, "a case file", ".toml", ".json")
    refuse_replacing(out, force)
    # A folder is read as a folder of meshes, even if its name has an ending.
    suffix = MESHES[0] if drawing.is_dir() else drawing.suffix.lower()
    data = parse_file(drawing) if suffix == ".json" else None
    if suffix == ".toml" or (isinstance(data, dict) and "joints" in data):
        raise OptionError(_case_file_message(drawing))
    if suffix not in _READERS:
        if not drawing.exists():
            raise CaseError(f"{drawing}: no such file or folder")
        raise OptionError(
            f"{drawing}: only drawings (.dxf), meshes ({', '.join(MESHES)}), COMPAS data (.json) and folders "
            "of meshes can be converted: use a file of one of these types"
        )
    missing = [arguments.called[name] for name in ("friction", "unit_weight") if name not in arguments]
    if missing:
        raise OptionError(
            f"{drawing}: a drawing does not contain friction and unit weight: specify {' and '.join(missing)}"
        )
    kind, read = _READERS[suffix]
    _refuse(arguments, inspect.signature(read).parameters, f"{drawing}: {kind}")
    if "live_layers" in arguments:
        arguments["live_layers"] = dict(arguments["live_layers"])
    reading = f"convert: reading {printable(str(drawing))}"
    with waiting(reading, if_interrupted="no file was written") as work, _options_named(arguments.called):
        layers: list[str] = []
        unit, metres = "", None
        if read is mo.read_dxf:
            scene, layers, unit, metres = read_with_layers(drawing, DxfDrawing.of(arguments))
        else:
            scene = read(drawing, **arguments)
        # Find the joints before the case file is written. If the geometry is wrong, CaseError is raised, and
        # no file is written.
        work.show("convert: finding joints")
        assembly = assemble(scene)
    corners = sum(len(block.corners()) for block in scene.blocks) if read is mo.read_mesh else 0
    by_name = corners > _MOST_CORNERS
    save(_case_of_mesh(drawing, out, scene, arguments) if by_name else scene, out, force)
    joints = counted(len(assembly.joints.first), "joint")
    _print_counts(scene, out, f", {joints}" + (f", in {drawing}" if by_name else ""))
    print_text(_size(assembly.geometry.extent_of(~scene.fixed), unit, metres))
    if layers:
        print_text(printable("\n".join(layers)))
    print_warnings(doubts(assembly))


def _doubts_at_rest(scene: mo.Scene) -> Iterable[str]:
    """Return warnings about a scene whose blocks were written as shapes, without an analysis.

    The shapes are also written if the scene cannot be assembled, for example because blocks overlap. The
    error of the assembly is then the only warning.
    """
    try:
        return doubts(assemble(scene, floating=True))
    except CaseError as error:
        return [str(error)]


@contextlib.contextmanager
def _options_named(called: Mapping[str, str]) -> Iterator[None]:
    """Name command-line options in the messages of errors that are raised in the ``with`` block.

    In these messages, the name of each tolerance is followed by its option. For example,
    'contact_tolerance' becomes 'contact_tolerance' (--contact-tolerance). ``called`` maps the names of
    parameters to options.
    """
    try:
        yield
    except CaseError as error:
        message = str(error)
        for name in _TOLERANCE_NAMES:
            message = re.sub(rf"'{name}'(?! \()", f"'{name}' ({called[name]})", message)
        raise CaseError(message) from None


def _case_file_message(path: Path) -> str:
    """Return the error message for an input that is already a case file, with commands to use instead."""
    advice = f"write its solids to a mesh file (masonry-opt export {path} OUT.obj)"
    if mo.load(path).dimension == 2:
        advice = f"write its blocks to a drawing (masonry-opt convert {path} OUT.dxf)"
    return f"{path} is a case file already: solve it (masonry-opt solve {path}), or {advice}"


def _case_of_mesh(drawing: Path, out: Path, scene: mo.Scene, options: dict[str, Any]) -> CaseFile:
    """Return a case file that contains the path of a mesh file, relative to the folder of the case file."""
    keys = {key: options[key] for key in MeshTable.model_fields if key in options}
    mesh = {"file": os.path.relpath(drawing, out.parent), "live_per_weight": options.get("live", (0.0,) * 3)}
    own = ("source", "joints", "tolerance", "contact_tolerance")
    return CaseFile(mesh=MeshTable(**mesh, **keys), **{key: getattr(scene, key) for key in own})


def _print_counts(scene: mo.Scene, out: Path, more: str = "") -> None:
    """Print the path of a written file, and its numbers of blocks, fixed blocks and holes."""
    holes = counted(sum(len(block.holes) for block in scene.blocks if isinstance(block, Block)), "hole")
    blocks, supports = counted(len(scene.blocks), "block"), sum(block.fixed for block in scene.blocks)
    print_text(f"{out}: {blocks} ({supports} fixed), {holes}{more}")


def _size(sides: np.ndarray, unit: str, metres: float | None) -> str:
    """Return a line of text with the dimensions of the movable blocks and their unit of length.

    ``metres`` is the length of the unit in metres, or None if the unit is unknown. If the unit is known and
    is not the metre, the dimensions follow in metres too.
    """
    size = f"size without supports: {' × '.join(rounded(side, 4) for side in sides)}"
    if metres is None:
        return f"{size} (unit of length not known)"
    if metres == 1:
        return f"{size} m"
    return f"{size} {unit} = {' × '.join(rounded(side * metres, 4) for side in sides)} m"


def _refuse(arguments: CommandArguments, known: Container[str], what: str) -> None:
    """Raise OptionError if the user typed an option that does not apply to the input."""
    for name in arguments:
        if name not in known:
            option = arguments.called[name]
            remedy = f"omit {option}"
            if name == "fixed" and "fixed_layers" in known:
                remedy = "draw supports on a layer with 'fixed' in its name, or use --fixed-layer"
            raise OptionError(f"{what} does not take {option}: {remedy}")
