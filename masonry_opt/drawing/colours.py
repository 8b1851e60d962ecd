"""Colours of pictures, pages and charts: each thing has one colour in all of them.

Colours of marks are those of Okabe & Ito (2008), which colour-blind readers can tell apart.
"""

# Okabe and Ito's colours, under their own names. Their yellow is left out: it is too pale for lines on white.
BLUE = "#0072B2"
VERMILION = "#D55E00"
BLUISH_GREEN = "#009E73"
REDDISH_PURPLE = "#CC79A7"
ORANGE = "#E69F00"
SKY_BLUE = "#56B4E9"
BLACK = "#000000"

#: Colours of the series of a chart, in order.
SERIES = (BLUE, VERMILION, BLUISH_GREEN, REDDISH_PURPLE, ORANGE, SKY_BLUE, BLACK)

SLIDES = BLUE  #: Joints that slide.
HINGES = VERMILION  #: Joints that hinge.
SEPARATES = ORANGE  #: Joints that separate.
CRUSHES = BLUISH_GREEN  #: Joints that crush.

JOINT = BLUE  #: Joints of a scene before it is solved.
GAP = VERMILION  #: Small gaps between blocks, which are not joints.
MARKED = REDDISH_PURPLE  #: Details to which a picture draws attention, such as corners without a joint.

BLOCK = "#F2E2C4"  #: Surfaces of movable blocks.
FIXED = "#D9D9D9"  #: Surfaces of supports.
HATCH = "#8A8A8A"  #: Hatching and outlines of supports, and auxiliary lines.
AT_REST = "#BBBBBB"  #: Outlines of blocks before they move.

THRUST = BLUE  #: Resultant forces of joints, and the line of thrust.
AT_POINT = REDDISH_PURPLE  #: Forces at the contact points of joints in space.
LIVE = BLACK  #: Live loads, which λ multiplies.
DEAD = "#6B6B6B"  #: Weights.
FURTHER_DEAD = SKY_BLUE  #: Dead loads other than weights.

FILL = "#8C6B3F"  #: Fill, its road, and the pressure of earth.
STRUT = "#4D4D4D"  #: Ties and props.
IDLE = "#A8A8A8"  #: Joints that carry no force.

#: Colours of utilisation, one for each tenth from 0 to 1. They are those of matplotlib's "viridis_r", which
#: colour-blind readers can tell apart and which also works in grey prints.
UTILISATION = (
    *("#FDE725", "#B5DE2B", "#6ECE58", "#35B779", "#1F9E89"),
    *("#26828E", "#31688E", "#3E4989", "#482878", "#440154"),
)
