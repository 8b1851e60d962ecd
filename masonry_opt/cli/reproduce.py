"""The command `masonry-opt reproduce`."""

from __future__ import annotations

from typing import Annotated

import typer

from masonry_opt.cli.signatures import Given, command
from masonry_opt.studies.reproduce import reproduce as rebuild

_EXAMPLE = "One of those that are listed if none is named; or all of the paper's."


@command(rebuild)
def reproduce(given: Given, example: Annotated[str, typer.Argument(help=_EXAMPLE)] = "") -> None:
    """Exit code 0: every value is as near to the published one as the example says; 1: one is not; 2: wrong
    example or folder, or an extra is missing.
    """
    if not rebuild(example, **given):
        raise typer.Exit(1)
