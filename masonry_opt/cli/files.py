"""The commands `masonry-opt draw` and `export`: what a case file holds, in files of others."""

from pathlib import Path
from typing import Annotated

import typer

import masonry_opt as mo
from masonry_opt.cli.command import Case, Given, LoadCaseName, command, writing
from masonry_opt.drawing.elements import counts
from masonry_opt.drawing.figure import refuse_picture
from masonry_opt.drawing.pictures import doubts, scene_picture
from masonry_opt.drawing.view import refuse_view
from masonry_opt.errors import printable
from masonry_opt.exports.solid_files import SOLID_ENDS
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.case_file import as_scene
from masonry_opt.words.terminal import print_text

_PICTURE = typer.Argument(help="File to write (.png, .svg, .pdf).")
_FILE = typer.Argument(help="File to write (.lp, .mps, .nl; of solids .obj, .glb, .gltf, .json).")
_METHOD = typer.Option(
    help="Of programs static (default), kinematic or global (any file), mpec or mcp (.nl); of solids the one "
    "whose mechanism and forces to write (default: blocks at rest)."
)


@command(mo.draw)
def draw(given: Given, case: Case, file: Annotated[Path, _PICTURE], load_case: LoadCaseName = None) -> None:
    """Prints how many there are, and what looks unintended. Without --load-case loads are drawn as given."""
    force = given.pop("force", False)
    refuse_picture(file, force)
    scene = as_scene(case, load_case)
    refuse_view(scene, given.get("view"))
    assembly = assemble(scene, floating=True)
    with writing(file):
        scene_picture(assembly, **given).save(file, force)
    warnings = [f"warning: {sentence}" for sentence in doubts(assembly)]
    print_text(printable("\n".join([f"{file}: {counts(assembly)}", *warnings])))


@command(mo.export, leave="moved", method=_METHOD)
def export(given: Given, case: Case, file: Annotated[Path, _FILE], load_case: LoadCaseName = None) -> None:
    """Beside a .nl file stand the names of its rows and columns (.row, .col). Prints the files written."""
    what: mo.Scene | mo.Result = as_scene(case, load_case)
    if file.suffix.lower() in SOLID_ENDS and (method := given.pop("method", None)):
        what = mo.solve(case, method, expected=False, load_case=load_case)
    print_text("\n".join(printable(str(path)) for path in mo.export(what, file, **given)))
