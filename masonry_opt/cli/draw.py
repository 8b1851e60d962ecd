"""The command `masonry-opt draw`."""

from __future__ import annotations

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
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.case_file import as_scene
from masonry_opt.words.terminal import print_text


@command(mo.draw)
def draw(
    given: Given,
    case: Case,
    file: Annotated[Path, typer.Argument(help="File to write (.png, .svg, .pdf).")],
    load_case: LoadCaseName = None,
) -> None:
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
