"""The command `masonry-opt least`."""

from __future__ import annotations

from typing import Annotated

import typer

from masonry_opt.cli.options import Case, Json, LoadCaseName
from masonry_opt.cli.running import waiting
from masonry_opt.cli.signatures import Given, command
from masonry_opt.errors import OptionError
from masonry_opt.scene.case_file import as_scene
from masonry_opt.studies.many.least import least as least_value
from masonry_opt.studies.many.least import most
from masonry_opt.studies.many.parameters import Parameters
from masonry_opt.studies.many.threshold import Trial
from masonry_opt.words.sentences import numeral
from masonry_opt.words.terminal import print_text

_VARY = "The number, and between what it is sought: arch.thickness=0.05:0.3."
_MOST = "The greatest value instead, of what makes a scene weaker."


@command(least_value, leave="lower upper")
def least(
    given: Given,
    case: Case,
    vary: Annotated[str, typer.Option(help=_VARY, show_default=False)],
    greatest: Annotated[bool, typer.Option("--most", help=_MOST)] = False,
    load_case: LoadCaseName = None,
    json: Json = False,
) -> None:
    """Exit code 0: found, with both ends solved; 1: whether the scene holds could not be decided; 2: it holds
    or fails at both ends, or the case file or an option is wrong.
    """
    name, lower, upper = _range(vary)
    parameters = Parameters(as_scene(case, load_case))
    parameters.check_names({name: lower})
    search = most if greatest else least_value
    with waiting(f"{name}: {lower:g} to {upper:g}") as show:

        def progress(trial: Trial) -> None:
            does = "holds" if trial.holds else "fails"
            show(f"{name} = {trial.value:.9g}: {does} ({numeral(trial.number, '.9g')})")

        found = search(
            lambda value: parameters.at({name: value}), lower, upper, progress=progress, **given.rest()
        )
    print_text(found.to_json() if json else f"{'number':<16} {name}\n{found}")


def _range(text: str) -> tuple[str, float, float]:
    """Name and ends of a text such as ``arch.thickness=0.05:0.3``."""
    name, _, ends = text.partition("=")
    try:
        lower, upper = map(float, ends.split(":"))
    except ValueError:
        raise OptionError(
            f"--vary {text}: write it as NAME=LOWER:UPPER, such as arch.thickness=0.05:0.3"
        ) from None
    return name.strip(), lower, upper
