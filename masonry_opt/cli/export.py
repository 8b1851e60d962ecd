"""The command `masonry-opt export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import masonry_opt as mo
from masonry_opt.cli.command import Case, Given, LoadCaseName, command
from masonry_opt.errors import printable
from masonry_opt.exports.solid_files import SOLID_ENDS
from masonry_opt.scene.case_file import as_scene
from masonry_opt.words.terminal import print_text

_FILE = typer.Argument(help="File to write (.lp, .mps, .nl; of solids .obj, .glb, .gltf, .json).")
_METHOD = typer.Option(
    help="Of programs static (default), kinematic or global (any file), mpec or mcp (.nl); of solids the one "
    "whose mechanism and forces to write (default: blocks at rest)."
)


@command(mo.export, leave="moved", method=_METHOD)
def export(given: Given, case: Case, file: Annotated[Path, _FILE], load_case: LoadCaseName = None) -> None:
    """Beside a .nl file stand the names of its rows and columns (.row, .col). Prints the files written."""
    what: mo.Scene | mo.Result = as_scene(case, load_case)
    if file.suffix.lower() in SOLID_ENDS and (method := given.pop("method", None)):
        what = mo.solve(case, method, expected=False, load_case=load_case)
    print_text("\n".join(printable(str(path)) for path in mo.export(what, file, **given)))
