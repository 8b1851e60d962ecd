"""The picture of a result, for the examples."""

from __future__ import annotations

from matplotlib.figure import Figure

import masonry_opt as mo
from masonry_opt.report.mechanism_plot import draw_mechanism


def mechanism_of(result: mo.Result) -> Figure:
    """A result's mechanism as a figure."""
    figure = Figure()
    draw_mechanism(result, figure.add_subplot())
    return figure
