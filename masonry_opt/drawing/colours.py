"""Colours of pictures, pages and charts: the same thing has the same colour in each.

Those of marks are Okabe & Ito's (2008), which colour-blind readers can tell apart.
"""

#: Okabe & Ito's, by the names they gave them. (Their yellow is too pale for lines on white.)
BLUE, VERMILION, BLUISH_GREEN = "#0072B2", "#D55E00", "#009E73"
REDDISH_PURPLE, ORANGE, SKY_BLUE, BLACK = "#CC79A7", "#E69F00", "#56B4E9", "#000000"

#: Series of a chart, in turn.
SERIES = (BLUE, VERMILION, BLUISH_GREEN, REDDISH_PURPLE, ORANGE, SKY_BLUE, BLACK)

SLIDES, HINGES, SEPARATES, CRUSHES = BLUE, VERMILION, ORANGE, BLUISH_GREEN  #: Joints by how they move.

#: Joints of a scene before it is solved, gaps that are none, and what a picture points out.
JOINT, GAP, MARKED = BLUE, VERMILION, REDDISH_PURPLE

#: Blocks, supports and their hatching, outlines at rest.
BLOCK, FIXED, HATCH, AT_REST = "#F2E2C4", "#D9D9D9", "#8A8A8A", "#BBBBBB"

#: Forces: of joints, in space of their contact points too; what λ scales, weights, dead loads beside them.
THRUST, AT_POINT, LIVE, DEAD, FURTHER_DEAD = BLUE, REDDISH_PURPLE, BLACK, "#6B6B6B", SKY_BLUE

FILL, STRUT = "#8C6B3F", "#4D4D4D"  #: Earth; ties and props.
IDLE = "#A8A8A8"  #: Joints that carry nothing.

#: Utilisation from 0 to 1 in tenths: matplotlib's "viridis_r", for the colour-blind and for grey prints too.
UTILISATION = (
    *("#FDE725", "#B5DE2B", "#6ECE58", "#35B779", "#1F9E89"),
    *("#26828E", "#31688E", "#3E4989", "#482878", "#440154"),
)
