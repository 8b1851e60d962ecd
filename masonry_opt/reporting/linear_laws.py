"""Describe the linear laws by which linear programs replace the friction cone and the crushing parabola."""

from masonry_opt.problem.faces import CHORDS, LARGEST_CHORD_ERROR, Layout

#: Description of the crushing law in linear programs, where chords replace the parabola.
BY_CHORDS = (
    f"{len(CHORDS.slope)} chords inside the crushing parabola, "
    f"at most {100 * LARGEST_CHORD_ERROR:.2f} % below it"
)
#: Remark on a load factor that was computed with chords of the crushing parabola: how the parabola itself
#: would change the result, and which method uses the parabola.
PARABOLA_REMARK = (
    "the parabola permits larger moments than the chords, and so a larger associative λ; method 'static' "
    "with Clarabel computes this λ"
)


def by_sides(layout: Layout) -> str:
    """Return a description of the polygons that replace friction cones in linear programs in space."""
    missed = 100 * (1 - layout.factor)
    return (
        f"by a polygon of {len(layout.senses)} sides, which is inside the friction cone and neglects up to "
        f"{missed:.2g} % of the friction"
    )
