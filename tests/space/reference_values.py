"""Load factors of walls in space by programs that are independent of the package; blocks are pushed along −y.

The program of `associative` computed contact points and equilibrium of boxes itself, and passed the cones to
Clarabel without scaling. The program of `carried` was contact dynamics with implicit, viscous time steps. The
explicit program `contact_dynamics` reproduces its values on walls of up to 20 blocks.
"""

from collections.abc import Callable
from dataclasses import dataclass

from scenes_in_space import corner_wall, facade

import masonry_opt as mo


@dataclass(frozen=True)
class Reference:
    """A wall, its friction and its load factors; a load factor that nobody has computed is None.

    Attributes
    ----------
    associative: associative load factor by cones, which agrees with its dual to 1e-8.
    carried: load factor carried in contact dynamics, with stiffness proportional to area, and half of it in
        shear. The wall falls at 6.25e-4 more.
    lmgc90: load factor at which the wall begins to move in LMGC90 (rigid blocks). It falls slightly below.
    incremental: incremental load factor by another program with elastic contacts of equal stiffness and
        friction polygons of 12 sides. The package has stiffness proportional to area, and cones. Contact
        dynamics carries 0.3475 and 0.313125 with equal stiffness, 0.35125 and 0.3125 with stiffness by area.
    least: lowest exact state that other programs found, with polygons of 16 sides.
    """

    wall: Callable[..., mo.Scene]
    size: tuple[int, int, int]
    blocks: int
    points: int
    friction: float
    associative: float
    carried: float | None = None
    lmgc90: float | None = None
    least: float | None = None
    incremental: float | None = None

    @property
    def scene(self) -> mo.Scene:
        return self.wall(*self.size, self.friction)

    def __str__(self) -> str:
        return f"{self.wall.__name__}_{self.blocks}_{self.friction}"


REFERENCES = [
    Reference(corner_wall, (3, 2, 4), 20, 192, 0.6, 0.427603, 0.35125, 0.3504, 0.24494, 0.3460),
    Reference(corner_wall, (3, 2, 4), 20, 192, 0.4, 0.374450, 0.3125, 0.3172, 0.24494, 0.3128),
    Reference(facade, (4, 3, 3), 13, 120, 0.6, 0.566580, 0.548125, 0.5578),
    Reference(facade, (4, 3, 3), 13, 120, 0.4, 0.400000, 0.4),
    Reference(facade, (8, 3, 4), 26, 256, 0.6, 0.425325, 0.37875),
    Reference(facade, (6, 3, 6), 33, 328, 0.6, 0.323460, 0.3025, 0.3078),
    Reference(facade, (6, 3, 6), 33, 328, 0.4, 0.311266, 0.3025, 0.3082),
    Reference(corner_wall, (4, 3, 6), 42, 432, 0.6, 0.346086, 0.28125, 0.2722, 0.19077),
    Reference(corner_wall, (4, 3, 6), 42, 432, 0.4, 0.288056, 0.244375, 0.2424, 0.18124),
    Reference(facade, (8, 5, 8), 68, 720, 0.6, 0.342287, 0.319375, 0.3238),
    Reference(facade, (8, 5, 8), 68, 720, 0.4, 0.327263, 0.300625, 0.2916),
    Reference(corner_wall, (6, 4, 10), 100, 1084, 0.6, 0.235854, 0.19375),
    Reference(corner_wall, (6, 4, 10), 100, 1084, 0.4, 0.192150, 0.1725),
    Reference(facade, (16, 9, 14), 231, 2596, 0.6, 0.277692, 0.256875),
    Reference(facade, (16, 9, 14), 231, 2596, 0.4, 0.242850),
]
