"""The command `masonry-opt check`."""

from __future__ import annotations

import typer

from masonry_opt.cli.options import Case, LoadCaseName
from masonry_opt.cli.signatures import command
from masonry_opt.duality import check as check_duality
from masonry_opt.scene.case_file import as_scene
from masonry_opt.words.terminal import print_result


@command()
def check(case: Case, load_case: LoadCaseName = None) -> None:
    """Exit code 0: they agree; 1: they do not, or there is no load factor; 2: wrong case file."""
    report = check_duality(as_scene(case, load_case))
    print_result(str(report))
    if not report.passed:
        raise typer.Exit(1)
