"""Draw the pictures of the README and of the guide that no page computes.

    python docs/pictures.py            # all of them; solves their scenes
    python docs/pictures.py diagram    # docs/how_it_works.png and docs/no_picture.png alone

The README and the first page of the guide show arch.png, facade.png and wall.png. The arch and the façade are
examples of the gallery, whose assertions check their numbers. The wall is a case file. fig10.png, on the page
"The paper's examples", is also an example of the gallery. The diagram belongs to the page "How it works". The
gallery shows no_picture.png for examples that the guide does not run.
"""

import sys
from pathlib import Path
from runpy import run_path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

import masonry_opt as mo

HERE = Path(__file__).parent
#: Pixels per inch: enough for a sharp picture on high-resolution screens, if three pictures share the page
#: width.
DPI = 160


def save(figure: Figure, name: str) -> None:
    """Write a picture to the folder of this file, and replace an existing file."""
    figure.savefig(HERE / f"{name}.png", dpi=DPI, bbox_inches="tight")


#: Boxes of the diagram from top to bottom: title, contents, and the folders that make these data.
DATA = (
    ("Case file, drawing, mesh", "or a scene made in Python", ""),
    ("Scene", "blocks, joints, loads", "scene/ reads files, runs\ngenerators, finds joints"),
    (
        "Problem",
        "equilibrium matrix B, loads,\nyield conditions, flow rule",
        "problem/ writes the scene\nas matrices",
    ),
    (
        "Solution",
        "forces, mechanism, λ,\ncertificate, status, log",
        "stability/ decides stability,\nmethods/ runs the method,\nmodels/ declares programs,\n"
        "solvers/ solves them",
    ),
    (
        "Result",
        "load factors and tables\nof blocks and joints",
        "analysis.py and result.py\nput the parts together",
    ),
    (
        "Text, picture, page, file",
        "for a user or a program",
        "reporting/, drawing/, exports/\nwrite what the user wants",
    ),
)

BOX_WIDTH = 2.75  # in inches
BOX_HEIGHT = 0.78  # in inches
ROW_HEIGHT = 1.2  # distance between the middles of two boxes, in inches
DATA_COLOUR = "#dfe9f3"
TEXT_COLOUR = "#1f2d3a"


def diagram() -> Figure:
    """Return the diagram of the data that the package makes from a scene, legible at 400 pixels width."""
    width, height = 5.9, ROW_HEIGHT * (len(DATA) - 1) + BOX_HEIGHT + 0.1
    figure = Figure(figsize=(width, height))
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, width), ylim=(0, height))
    axes.set_axis_off()
    middle = height - BOX_HEIGHT / 2 - 0.05
    for title, contents, folders in DATA:
        if folders:
            _draw_step(axes, middle, folders)
        _draw_box(axes, middle, title, contents)
        middle -= ROW_HEIGHT
    return figure


def _draw_box(axes: Axes, middle: float, title: str, contents: str) -> None:
    """Draw the box of one kind of data: its title above its contents."""
    bottom = (0.15, middle - BOX_HEIGHT / 2 + 0.05)
    style = "round,pad=0,rounding_size=0.08"
    box = FancyBboxPatch(
        bottom, BOX_WIDTH, BOX_HEIGHT - 0.1, style, facecolor=DATA_COLOUR, edgecolor=TEXT_COLOUR
    )
    axes.add_patch(box)
    centre = 0.15 + BOX_WIDTH / 2
    axes.text(centre, middle + 0.26, title, ha="center", va="top", size=12, weight="bold", color=TEXT_COLOUR)
    axes.text(
        centre, middle + 0.02, contents, ha="center", va="top", size=10, color=TEXT_COLOUR, linespacing=1.05
    )


def _draw_step(axes: Axes, middle: float, folders: str) -> None:
    """Draw the arrow that leads to a box, with the folders that make the box's data on its right."""
    end = (0.15 + BOX_WIDTH / 2, middle + BOX_HEIGHT / 2 - 0.05)
    start = (end[0], middle + ROW_HEIGHT - BOX_HEIGHT / 2 + 0.05)
    axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": TEXT_COLOUR, "lw": 1.5})
    axes.text(3.15, middle + ROW_HEIGHT / 2, folders, ha="left", va="center", size=10.5, color=TEXT_COLOUR)


def no_picture() -> Figure:
    """Return the small picture that the gallery shows for an example that the guide does not run."""
    figure = Figure(figsize=(2.5, 1.75))
    text = "not run\nin the guide"
    figure.text(0.5, 0.5, text, ha="center", va="center", size=12, color=TEXT_COLOUR)
    return figure


def main() -> None:
    """Solve and draw; the argument "diagram" draws only the two pictures that need no solver."""
    save(diagram(), "how_it_works")
    no_picture().savefig(HERE / "no_picture.png", dpi=DPI)
    if sys.argv[1:] == ["diagram"]:
        return
    loads, space, paper = (HERE / "gallery" / name for name in ("loads", "space", "paper"))
    save(run_path(str(loads / "bogie_over_an_arch.py"))["coulomb"].plot(), "arch")
    save(run_path(str(space / "facade_off_its_returns.py"))["result"].plot(view=(-50, 25)), "facade")
    save(run_path(str(paper / "fig10.py"))["figure"], "fig10")
    save(mo.solve(HERE.parent / "cases" / "ferris_tinloi" / "wall_6.toml").plot(), "wall")


if __name__ == "__main__":
    main()
