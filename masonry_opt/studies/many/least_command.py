"""The command `masonry-opt least`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from masonry_opt.command_options import Json, LoadCaseName, OwnOptions, method_options
from masonry_opt.errors import InterruptedByUserError, OptionError
from masonry_opt.methods.registry import DEFAULT, METHODS
from masonry_opt.scene.case_file import as_scene
from masonry_opt.studies.many.least import SAMPLES, TOLERANCE, most
from masonry_opt.studies.many.least import least as least_value
from masonry_opt.studies.many.parameters import Parameters
from masonry_opt.studies.many.threshold import Trial
from masonry_opt.words.sentences import numeral
from masonry_opt.words.terminal import print_text

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


@app.command()
def least(
    case: Annotated[Path, typer.Argument(help="Case file (.toml or .json).", show_default=False)],
    vary: Annotated[
        str,
        typer.Option(
            help="The number, and between what it is sought: arch.thickness=0.05:0.3.", show_default=False
        ),
    ],
    greatest: Annotated[
        bool, typer.Option("--most", help="The greatest value instead, of what makes a scene weaker.")
    ] = False,
    load: Annotated[
        float | None,
        typer.Option(help="Load factor to be carried. Without it: the dead load alone.", show_default=False),
    ] = None,
    load_case: LoadCaseName = None,
    method: Annotated[str, typer.Option(help=f"With --load: {', '.join(METHODS)}.")] = DEFAULT,
    tolerance: Annotated[float, typer.Option(help="Of the ends of the answer, relative.")] = TOLERANCE,
    samples: Annotated[int, typer.Option(help="Values between that are tried first.")] = SAMPLES,
    option: OwnOptions = None,
    json: Json = False,
) -> None:
    """Find the least value of a number of CASE at which it stands, or carries a load.

    Exit code 0: found, with both ends solved; 1: whether the scene holds could not be decided; 2: it holds
    or fails at both ends, or the case file or an option is wrong.
    """
    name, lower, upper = _range(vary)
    parameters = Parameters(as_scene(case, load_case))
    parameters.check_names({name: lower})
    search = most if greatest else least_value
    with Console(stderr=True).status(f"{name}: {lower:g} to {upper:g}") as status:

        def progress(trial: Trial) -> None:
            does = "holds" if trial.holds else "fails"
            status.update(f"{name} = {trial.value:.9g}: {does} ({numeral(trial.number, '.9g')})")

        try:
            found = search(
                lambda value: parameters.at({name: value}),
                lower,
                upper,
                load=load,
                method=method,
                tolerance=tolerance,
                samples=samples,
                progress=progress,
                **method_options(option, search),
            )
        except KeyboardInterrupt:
            raise InterruptedByUserError("interrupted: nothing was found") from None
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
