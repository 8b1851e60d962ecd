"""Draws the three pictures that the README and the guide begin with: docs/arch.png, facade.png and wall.png.

    python docs/pictures.py

Arch and façade are those of two examples of the gallery, which hold their numbers; the wall is a case file.
"""

from pathlib import Path
from runpy import run_path

from matplotlib.figure import Figure

import masonry_opt as mo

HERE = Path(__file__).parent
#: Pixels for each inch: as wide as a column of three needs, sharp on fine screens too.
DPI = 160


def save(figure: Figure, name: str) -> None:
    """Write a picture beside this file, in place of the one that was there."""
    figure.savefig(HERE / f"{name}.png", dpi=DPI, bbox_inches="tight")


def main() -> None:
    """Solve and draw: half a minute."""
    loads, space = HERE / "gallery" / "loads", HERE / "gallery" / "space"
    save(run_path(str(loads / "bogie_over_an_arch.py"))["coulomb"].plot(), "arch")
    save(run_path(str(space / "facade_off_its_returns.py"))["result"].plot(view=(-50, 25)), "facade")
    save(mo.solve(HERE.parent / "cases" / "ferris_tinloi" / "wall_6.toml").plot(), "wall")


if __name__ == "__main__":
    main()
