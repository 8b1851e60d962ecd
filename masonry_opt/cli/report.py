"""The command `masonry-opt report`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

import masonry_opt as mo
from masonry_opt.cli.command import Case, Given, LoadCaseName, command, interrupts, waiting, writing
from masonry_opt.errors import InterruptedByUserError, printable
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.report.report import refuse_report
from masonry_opt.words.terminal import print_text

_OUT = typer.Option("--out", metavar="FILE", help="The page (.html). Default: CASE_report.html, here.")


@command(mo.solve, mo.report, leave="answer")
def report(
    given: Given, case: Case, load_case: LoadCaseName = None, out: Annotated[Path | None, _OUT] = None
) -> None:
    """Solves all load cases unless one is named, and moves the axles, if there are any.

    Exit code 0: there are load factors; 1: one is missing, and the page says why; 2: wrong case file or
    option; 130: interrupted, and no page written.
    """
    page, writes = out or Path(f"{case.stem}_report.html"), given.take(mo.report)
    refuse_report(page, **writes)
    with waiting("report") as show, interrupts() as check_interrupt:
        try:
            answers = _answers(as_scene(case, load_case), show, given.rest())
            check_interrupt()  # a search that it ended has an answer: the lowest state by then
        except KeyboardInterrupt:
            raise InterruptedByUserError("interrupted: no page written") from None
        with writing(page):
            mo.report(answers, page, **writes)
    print_text(printable("\n\n".join([*map(str, answers), str(page)])))
    crossed = (one for one in answers if isinstance(one, mo.Crossing))
    if any(one.load_factor is None for one in crossed) or not all(
        getattr(one, "usable", True) for one in answers
    ):
        raise typer.Exit(1)


def _answers(scene: Scene, show: Callable[[str], None], options: dict[str, Any]) -> list[Any]:
    """What a report is of: load cases, those in which axles cross, or the scene itself."""
    cases = scene.load_cases if scene.load_case is None else []
    answers: list[Any] = []
    if cases and not all(one.moves for one in cases):
        answers.append(mo.solve_cases(scene, phases=show, **options))
    scenes = [scene.in_case(one.name) for one in cases] or [scene]
    for crossed in (one for one in scenes if one.axles and one.factor_of_axles):
        answers.append(mo.crossing(crossed, progress=lambda x, _: show(f"first axle at {x:.4g}"), **options))
        if answers[-1].interrupted:
            raise KeyboardInterrupt
    return answers or [mo.solve(scene, phases=show, **options)]
