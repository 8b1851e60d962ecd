"""Typical sizes of masonry, and gravity, to warn about lengths in another unit than the user believes."""

#: Gravitational acceleration in metres per s².
GRAVITY = 9.81
#: Gravitational acceleration for each unit of length, in this unit per s².
GRAVITY_BY_UNIT = {"metres": GRAVITY, "centimetres": 100 * GRAVITY, "millimetres": 1000 * GRAVITY}
#: Smallest plausible size of a scene, in metres. Models in laboratories are larger. With a larger value,
#: warnings name small models.
SMALLEST_SCENE = 0.1
#: Largest plausible size of a scene, in metres. Aqueducts are smaller. With a smaller value, warnings name
#: long bridges.
LARGEST_SCENE = 1000.0
#: Largest plausible median of the smaller sides of a wall's blocks, in metres. Larger stones are rare. With a
#: smaller value, warnings name walls of large stones.
LARGEST_SMALLER_SIDE = 2.0
#: Smallest number of movable blocks in a scene whose blocks count as single stones. In a smaller scene, a
#: block may be a whole wall. With a smaller value, warnings name scenes of a few walls.
FEWEST_STONES = 10
