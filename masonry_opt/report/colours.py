"""Colours of pictures and pages: the same thing has the same colour in each.

Those of marks are Okabe & Ito's (2008), told apart by colour-blind readers; charts take theirs from here too.
"""

from __future__ import annotations

#: Okabe & Ito's, by the names they gave them. (Their yellow is too pale for lines on white.)
BLUE, VERMILION, BLUISH_GREEN = "#0072B2", "#D55E00", "#009E73"
REDDISH_PURPLE, ORANGE, SKY_BLUE, BLACK = "#CC79A7", "#E69F00", "#56B4E9", "#000000"

#: Joints by how they move.
SLIDES, HINGES, SEPARATES, CRUSHES = BLUE, VERMILION, ORANGE, BLUISH_GREEN

#: Joints that a picture points out, and what a scene warns of.
MARKED = REDDISH_PURPLE

#: Blocks, supports and their hatching, outlines at rest.
BLOCK, FIXED, HATCH, AT_REST = "#F2E2C4", "#D9D9D9", "#8A8A8A", "#BBBBBB"

#: Forces: what joints carry, what λ scales, weights, and dead loads beside them.
THRUST, LIVE, DEAD, FURTHER_DEAD = BLUE, BLACK, "#6B6B6B", SKY_BLUE

#: Joints that carry nothing.
IDLE = "#A8A8A8"
