"""The command `masonry-opt convert`: drawings and meshes to case files, case files to drawings."""

from __future__ import annotations

import os
from collections.abc import Collection
from pathlib import Path
from typing import Annotated, Any

import typer

from masonry_opt.command_options import Force
from masonry_opt.errors import OptionError, OutputError, counted
from masonry_opt.scene.blocks import Block
from masonry_opt.scene.case_file import CaseFile, MeshTable, load, save
from masonry_opt.scene.contacts.find import find_joints
from masonry_opt.scene.drawings.compas import read_compas
from masonry_opt.scene.drawings.dxf import read_dxf, write_dxf
from masonry_opt.scene.drawings.mesh_files import MESHES, read_mesh
from masonry_opt.scene.drawings.supports import FIXED
from masonry_opt.scene.geometry import geometry
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.space.shapes import shapes
from masonry_opt.scene.tables import parse_file
from masonry_opt.words.terminal import print_text

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)

#: Options beside friction, unit weight, live load and tolerance that each kind takes.
_OF_DXF = ("live_layers", "layers", "fixed_layers", "outline_tolerance", "sagitta", "to_metres", "thickness")
_OF_COMPAS = ("fixed", "fixed_below", "along", "space", "contact_tolerance")
_OF_MESH = ("fixed", "fixed_layers", "fixed_below", "up", "scale", "contact_tolerance")

#: Corners of a mesh above which the case file names its file instead of writing them out, some 1 MB.
_MOST_CORNERS = 10_000


@app.command()
def convert(
    drawing: Annotated[
        Path,
        typer.Argument(
            metavar="IN",
            help="Drawing (.dxf), COMPAS data (.json), or mesh (.obj, .ply, .stl).",
            show_default=False,
        ),
    ],
    out: Annotated[
        Path, typer.Argument(metavar="OUT", help="Case file (.toml or .json).", show_default=False)
    ],
    friction: Annotated[float | None, typer.Option(help="Of every joint, tan φ; needed.")] = None,
    unit_weight: Annotated[
        float | None, typer.Option(help="Weight per unit area (of solids: volume); needed.")
    ] = None,
    live: Annotated[
        str | None,
        typer.Option(metavar="X,Y[,Z]", help="Live load on every block, as a multiple of its weight."),
    ] = None,
    live_layer: Annotated[
        list[str] | None,
        typer.Option(metavar="LAYER=X,Y[,Z]", help="DXF: in place of it, of the blocks on a layer."),
    ] = None,
    layer: Annotated[
        list[str] | None, typer.Option(metavar="LAYER", help="DXF: read this layer (default: all).")
    ] = None,
    fixed_layer: Annotated[
        list[str] | None,
        typer.Option(
            metavar="WORD", help=f"In names of layers or objects of supports (default: {', '.join(FIXED)})."
        ),
    ] = None,
    fixed: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="COMPAS, meshes: this block is a support too.")
    ] = None,
    fixed_below: Annotated[
        float | None,
        typer.Option(metavar="Z", help="COMPAS, meshes: blocks that reach down to this height are supports."),
    ] = None,
    along: Annotated[
        str | None, typer.Option(metavar="x|y|z|X,Y,Z", help="COMPAS: direction of the prisms.")
    ] = None,
    space: Annotated[
        bool | None, typer.Option("--space/--plane", help="COMPAS: blocks whole, or seen along a direction.")
    ] = None,
    up: Annotated[
        str | None, typer.Option(metavar="x|y|z", help="Meshes: the axis that points upwards (default: z).")
    ] = None,
    scale: Annotated[float | None, typer.Option(help="Meshes: times all lengths, such as 0.001.")] = None,
    thickness: Annotated[
        float | None, typer.Option(help="DXF: blocks in space of this thickness, out of the drawing.")
    ] = None,
    tolerance: Annotated[
        float | None,
        typer.Option(help="Length below which gaps between blocks are nothing.", show_default=False),
    ] = None,
    outline_tolerance: Annotated[
        float | None,
        typer.Option(help="DXF: gap up to which ends of lines meet (default: the tolerance)."),
    ] = None,
    contact_tolerance: Annotated[
        float | None,
        typer.Option(
            help="COMPAS, meshes: gap or overlap of faces up to which blocks touch.", show_default=False
        ),
    ] = None,
    sagitta: Annotated[
        float | None, typer.Option(help="DXF: rise of arcs over their chords.", show_default=False)
    ] = None,
    to_metres: Annotated[
        bool, typer.Option("--to-metres", help="DXF: scale from the drawing's own unit.")
    ] = False,
    force: Force = False,
) -> None:
    """Make a case file of a drawing: blocks, supports, friction, weights, live loads.

    Layers, names, arcs, COMPAS data and meshes: docs/drawings.md. From a case file to OUT.dxf it draws the
    blocks. Of a mesh of more than 10,000 corners the case file names the file.
    """
    given: dict[str, Any] = {
        "friction": friction,
        "unit_weight": unit_weight,
        "live": _numbers("--live", live) if live else None,
        "live_layers": dict(_of_layer(text) for text in live_layer or []) or None,
        "layers": layer or None,
        "fixed_layers": fixed_layer or None,
        "fixed": fixed or None,
        "fixed_below": fixed_below,
        "space": space,
        "up": up,
        "scale": scale,
        "thickness": thickness,
        "along": _numbers("--along", along) if along and "," in along else along,
        "tolerance": tolerance,
        "contact_tolerance": contact_tolerance,
        "outline_tolerance": outline_tolerance,
        "sagitta": sagitta,
        "to_metres": to_metres or None,
    }
    options = {name: value for name, value in given.items() if value is not None}
    if out.suffix.lower() == ".dxf":
        _refuse(options, options, f"{out}: a drawing is written of a case file as it stands")
        scene = load(drawing)
        write_dxf(scene, out, force)
        _tell(scene, out)
        return
    if out.suffix.lower() not in (".toml", ".json"):
        raise OutputError(f"{out}: a case file's name ends in .toml or .json")
    _refuse_case_file(drawing)
    for name in ("friction", "unit_weight"):
        if name not in options:
            raise OptionError(f"a drawing says nothing of it: give {_option(name)}")
    match drawing.suffix.lower():
        case ".dxf":
            _refuse_others(options, _OF_DXF, f"{drawing}: a DXF drawing")
            scene = read_dxf(drawing, **options)
        case ".json":
            _refuse_others(options, _OF_COMPAS, f"{drawing}: COMPAS data")
            scene = read_compas(drawing, **options)
        case suffix if suffix in MESHES:
            _refuse_others(options, _OF_MESH, f"{drawing}: a mesh")
            scene = read_mesh(drawing, **options)
        case _:
            raise OptionError(
                f"{drawing}: what is converted ends in .dxf, {', '.join(MESHES)}, or .json for COMPAS data"
            )
    # What is written can be solved as far as its geometry goes.
    joints = _joints(scene)
    large = sum(len(block.corners()) for block in scene.blocks) > _MOST_CORNERS
    beside = large and drawing.suffix.lower() in MESHES
    save(_beside(drawing, out, scene, options) if beside else scene, out, force)
    _tell(scene, out, f", {counted(joints, 'joint')}" + (f", in {drawing}" if beside else ""))


def _joints(scene: Scene) -> int:
    return len(find_joints(scene, geometry(scene) if scene.dimension == 2 else shapes(scene)).first)


def _beside(drawing: Path, out: Path, scene: Scene, options: dict[str, Any]) -> CaseFile:
    """The case file that names the mesh it was made of."""
    keys = {key: options[key] for key in MeshTable.model_fields if key in options}
    mesh = {"file": os.path.relpath(drawing, out.parent), "live_per_weight": options.get("live", (0.0,) * 3)}
    return CaseFile(
        source=scene.source,
        joints=scene.joints,
        tolerance=scene.tolerance,
        contact_tolerance=scene.contact_tolerance,
        mesh=MeshTable(**mesh, **keys),
    )


def _refuse_case_file(path: Path) -> None:
    """Raise OptionError if what is given for a drawing is a case file."""
    suffix = path.suffix.lower()
    data = parse_file(path) if suffix == ".json" else None
    if suffix == ".toml" or (isinstance(data, dict) and "joints" in data):
        raise OptionError(
            f"{path}: a case file already, and no drawing (.dxf), mesh or COMPAS data (.json): solve it as "
            f"it is (masonry-opt solve {path}), or draw its blocks to an OUT that ends in .dxf"
        )


def _tell(scene: Scene, out: Path, more: str = "") -> None:
    holes = sum(len(block.holes) for block in scene.blocks if isinstance(block, Block))
    supports = sum(block.fixed for block in scene.blocks)
    blocks = counted(len(scene.blocks), "block")
    print_text(f"{out}: {blocks} ({supports} fixed), {counted(holes, 'hole')}{more}")


def _refuse_others(options: dict[str, Any], taken: Collection[str], what: str) -> None:
    """Raise OptionError for an option that a kind does not take."""
    every = {*_OF_DXF, *_OF_COMPAS, *_OF_MESH}
    _refuse(options, [name for name in options if name in every and name not in taken], what)


def _refuse(options: dict[str, Any], names: Any, what: str) -> None:
    for name in names:
        if name in options:
            raise OptionError(f"{what} does not take {_option(name)}")


def _option(name: str) -> str:
    """The option of the command line that gives an argument."""
    plural = ("live_layers", "layers", "fixed_layers")
    return "--" + (name.removesuffix("s") if name in plural else name).replace("_", "-")


def _of_layer(text: str) -> tuple[str, tuple[float, ...]]:
    layer, equals, force = text.rpartition("=")
    if not equals:
        raise OptionError(f"--live-layer '{text}': write it as LAYER=X,Y, such as parapet=1,0")
    return layer, _numbers("--live-layer", force)


def _numbers(option: str, text: str) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise OptionError(f"{option} '{text}': write numbers with commas between, such as 1,0") from None
