"""Describe the linear laws by which linear programs replace the friction cone and the crushing parabola."""

from masonry_opt.problem.faces import CHORDS, MISSED, Layout

#: Description of the crushing law in linear programs, where chords replace the parabola.
BY_CHORDS = f"{len(CHORDS.slope)} chords inside the crushing parabola, at most {100 * MISSED:.2f} % below it"
#: Remark on load factors by chords: the effect of the chords, and the method that uses the parabola.
PARABOLA_REMARK = (
    "the parabola permits larger moments than its chords, and a larger associative λ, which method 'static' "
    "with Clarabel computes"
)


def by_sides(layout: Layout) -> str:
    """Return a description of the polygons that replace friction cones in linear programs in space."""
    missed = 100 * (1 - layout.factor)
    return (
        f"by a polygon of {len(layout.senses)} sides, which is inside the friction cone and neglects up to "
        f"{missed:.2g} % of the friction"
    )
