"""Colours of the series of a chart, in turn."""

from __future__ import annotations

from masonry_opt.drawing.colours import (
    BLACK,
    BLUE,
    BLUISH_GREEN,
    ORANGE,
    REDDISH_PURPLE,
    SKY_BLUE,
    VERMILION,
)

#: Those of pictures and pages; black last.
COLOURS = (BLUE, VERMILION, BLUISH_GREEN, REDDISH_PURPLE, ORANGE, SKY_BLUE, BLACK)
