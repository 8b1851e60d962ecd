"""Colours of pictures, pages and charts: each thing has one colour in all of them.

Colours of marks are those of Okabe & Ito (2008), which colour-blind readers can distinguish.
"""

# Colour-blind readers can distinguish the colours of Okabe and Ito. The palette's yellow is omitted, because
# it is too pale for lines on white.
BLUE = "#0072B2"
VERMILION = "#D55E00"
BLUISH_GREEN = "#009E73"
REDDISH_PURPLE = "#CC79A7"
ORANGE = "#E69F00"
SKY_BLUE = "#56B4E9"
BLACK = "#000000"

#: Colours of the data series of a chart, in this order.
SERIES = (BLUE, VERMILION, BLUISH_GREEN, REDDISH_PURPLE, ORANGE, SKY_BLUE, BLACK)

SLIDING_COLOUR = BLUE  #: Colour of joints that slide.
HINGING_COLOUR = VERMILION  #: Colour of joints that hinge.
SEPARATING_COLOUR = ORANGE  #: Colour of joints that separate.
CRUSHING_COLOUR = BLUISH_GREEN  #: Colour of joints that crush.

JOINT = BLUE  #: Colour of joints in a scene before it is solved.
GAP = VERMILION  #: Colour of small gaps between blocks, across which no joint is made.
MARKED = REDDISH_PURPLE  #: Colour of places to check, such as two corners that touch without a joint.

BLOCK = "#F2E2C4"  #: Colour of movable blocks.
SUPPORT_COLOUR = "#D9D9D9"  #: Colour of supports.
HATCH = "#8A8A8A"  #: Colour of the hatching and outlines of supports, and of auxiliary lines.
AT_REST = "#BBBBBB"  #: Colour of outlines of blocks before they move.

THRUST = BLUE  #: Colour of the resultant forces of joints and of the line of thrust.
AT_POINT = REDDISH_PURPLE  #: Colour of forces at the contact points of joints in space.
LIVE = BLACK  #: Colour of live loads, which λ multiplies.
DEAD = "#6B6B6B"  #: Colour of weights.
FURTHER_DEAD = SKY_BLUE  #: Colour of dead loads other than weights.

FILL = "#8C6B3F"  #: Colour of fill, of the road on it, and of its earth pressure.
STRUT = "#4D4D4D"  #: Colour of ties and props.
IDLE_COLOUR = "#A8A8A8"  #: Colour of joints that carry no force.

#: Colours of utilisation, one for each tenth from 0 to 1. The colours, from matplotlib's colour map
#: "viridis_r", are also distinct in grey prints and for colour-blind readers.
UTILISATION = (
    *("#FDE725", "#B5DE2B", "#6ECE58", "#35B779", "#1F9E89"),
    *("#26828E", "#31688E", "#3E4989", "#482878", "#440154"),
)
