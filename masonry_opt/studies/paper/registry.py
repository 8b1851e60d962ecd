"""The examples that ``reproduce`` can rebuild; a new one is added as an entry here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from masonry_opt.errors import OptionError
from masonry_opt.studies.paper.arch import fig9
from masonry_opt.studies.paper.bracket import bracket
from masonry_opt.studies.paper.convergence import fig11
from masonry_opt.studies.paper.dilatancy import dilatancy
from masonry_opt.studies.paper.energy import fig12
from masonry_opt.studies.paper.example import ProgressLine, Report
from masonry_opt.studies.paper.facades import facades
from masonry_opt.studies.paper.livesley import fig8
from masonry_opt.studies.paper.rib import rib
from masonry_opt.studies.paper.stability import stability
from masonry_opt.studies.paper.table1 import table1
from masonry_opt.studies.paper.two_blocks import fig6
from masonry_opt.studies.paper.two_blocks_loop import fig7
from masonry_opt.studies.paper.variants import variants
from masonry_opt.studies.paper.walls import fig10, fig13


@dataclass(frozen=True)
class Example:
    """A result that can be rebuilt.

    Attributes
    ----------
    title: what it shows.
    run: rebuilds it, given the folder of case files and what is called with a line before each solve; raises
        CaseError if a case file is missing or wrong.
    also: further names, such as those of figures that it holds beside the one that names it.
    in_paper: whether it is one of the paper's, which ``all`` rebuilds.
    mpec: whether it solves the MPEC, which needs the extra of that name.
    """

    title: str
    run: Callable[[Path, ProgressLine], Report]
    also: tuple[str, ...] = ()
    in_paper: bool = True
    mpec: bool = False


#: In the order of the paper.
EXAMPLES: dict[str, Example] = {
    "fig6": Example("Fig. 6: two blocks, load factor against dilatancy", fig6),
    "fig7": Example("Fig. 7: two blocks, forces at each iteration", fig7),
    "fig8": Example("Fig. 8: Livesley's wedges", fig8),
    "fig9": Example("Fig. 9: least thickness of a semicircular arch", fig9),
    "rib": Example("Section 5.2: arch rib of Pippard & Ashby", rib),
    "table1": Example("Table 1: walls of Ferris & Tin-Loi", table1, mpec=True),
    "fig10": Example("Fig. 10: mechanisms of the walls of Ferris & Tin-Loi", fig10),
    "fig11": Example("Fig. 11: convergence, wall 6", fig11),
    "fig12": Example("Fig. 12: energy, wall 6", fig12),
    "fig13": Example("Fig. 13: wall of Orduña & Lourenço", fig13),
    "facades": Example("Figs 14 to 16: façades", facades, also=("fig14", "fig15", "fig16")),
    "variants": Example("Section 6.4: variants of the loop", variants),
    "dilatancy": Example("Section 6.5: dilatancy that falls with normal stress", dilatancy),
    "bracket": Example("Least load factor of the walls, from above and below", bracket, in_paper=False),
    "stability": Example("Where methods fail, and what happens then", stability, in_paper=False, mpec=True),
}


def find_examples(name: str) -> list[str]:
    """Names of the examples that a user means: one, or ``all`` of the paper. Raises OptionError if there is
    none."""
    if name == "all":
        return [known for known, example in EXAMPLES.items() if example.in_paper]
    for known, example in EXAMPLES.items():
        if name == known or name in example.also:
            return [known]
    raise OptionError(f"nothing to reproduce is named '{name}'; choose from: {', '.join(EXAMPLES)}, all")
