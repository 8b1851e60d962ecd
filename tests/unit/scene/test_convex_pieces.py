"""Polygons cut into convex pieces: the whole is kept, every piece is convex, and there are few."""

import numpy as np
import pytest
import shapely

from masonry_opt.scene.outlines import convex_pieces

L_SHAPE = shapely.Polygon([(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)])
PLUS = shapely.union_all([shapely.box(1, 0, 2, 3), shapely.box(0, 1, 3, 2)])
FRAME = shapely.box(0, 0, 3, 3).difference(shapely.box(1, 1, 2, 2))


def star(points, seed):
    """A polygon with random notches, convex nowhere near."""
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi, points))
    radius = rng.uniform(0.2, 1, points)
    return shapely.Polygon(np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]))


#: A polygon and the most pieces: the fewest there are, or what Hertel and Mehlhorn's bound gives, one more
#: than twice the corners that turn inwards; those of a hole with one more cut.
POLYGONS = {
    "triangle": (shapely.Polygon([(0, 0), (1, 0), (0, 1)]), 1),
    "a convex one": (shapely.Point(0, 0).buffer(1), 1),
    "L": (L_SHAPE, 2),
    "plus": (PLUS, 5),
    "frame": (FRAME, 8),
    "turned L": (shapely.affinity.rotate(L_SHAPE, 33.3), 2),
    "apart": (shapely.union_all([shapely.box(0, 0, 1, 1), shapely.box(2, 0, 3, 1)]), 2),
    **{f"star {seed}": (star(25, seed), 2 * 25) for seed in range(4)},
}


@pytest.mark.parametrize("name", POLYGONS)
def test_pieces_are_convex_and_make_up_the_whole(name):
    polygon, most = POLYGONS[name]
    pieces = convex_pieces(polygon, 1e-9)
    assert len(pieces) <= most
    drawn = shapely.polygons([shapely.linearrings(piece) for piece in pieces])
    assert shapely.is_ccw(shapely.get_exterior_ring(drawn)).all()
    assert shapely.area(drawn).sum() == pytest.approx(polygon.area, rel=1e-12)
    assert shapely.union_all(drawn).symmetric_difference(polygon).area < 1e-12
    for piece in pieces:
        side = np.roll(piece, -1, axis=0) - piece
        following = np.roll(side, -1, axis=0)
        turn = side[:, 0] * following[:, 1] - side[:, 1] * following[:, 0]
        assert (turn > -1e-9).all()
    own = {tuple(corner) for corner in shapely.get_coordinates(polygon)}
    assert {tuple(corner) for piece in pieces for corner in piece} <= own


def test_what_is_thinner_than_the_tolerance_is_no_piece():
    """A flag on a pole of width 1e-4."""
    flag = shapely.union_all([shapely.box(0, 0, 1e-4, 2), shapely.box(1e-4, 1, 1, 2)])
    assert len(convex_pieces(flag, 1e-6)) == 2
    (piece,) = convex_pieces(flag, 1e-3)
    assert shapely.Polygon(piece).area == pytest.approx(1, rel=1e-3)
