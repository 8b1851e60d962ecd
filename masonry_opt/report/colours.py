"""Colours of pictures and pages: the same thing has the same colour in each.

Those of marks are Okabe & Ito's (2008), told apart by colour-blind readers.
"""

from __future__ import annotations

#: Joints by how they move.
SLIDES, HINGES, SEPARATES, CRUSHES = "#0072B2", "#D55E00", "#E69F00", "#009E73"

#: Joints that a picture points out, and what a scene warns of.
MARKED = "#CC79A7"

#: Blocks, supports and their hatching, outlines at rest.
BLOCK, FIXED, HATCH, AT_REST = "#F2E2C4", "#D9D9D9", "#8A8A8A", "#BBBBBB"

#: Forces: what joints carry, what λ scales, weights, and dead loads beside them.
THRUST, LIVE, DEAD, FURTHER_DEAD = "#0072B2", "#000000", "#6B6B6B", "#56B4E9"

#: Joints that carry nothing.
IDLE = "#A8A8A8"
