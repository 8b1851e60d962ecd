"""Typical sizes of masonry, and gravity, to warn about lengths in another unit than the user believes."""

#: Gravitational acceleration in m/s².
GRAVITY = 9.81
#: Gravitational acceleration for each unit of length, for example in mm/s² for millimetres.
GRAVITY_BY_UNIT = {"metres": GRAVITY, "centimetres": 100 * GRAVITY, "millimetres": 1000 * GRAVITY}
#: Smallest plausible size of a scene, in metres. Laboratory models are larger. With a larger value, correct
#: drawings of small models would cause warnings.
SMALLEST_SCENE = 0.1
#: Largest plausible size of a scene, in metres. Aqueducts are smaller. With a smaller value, correct drawings
#: of long bridges would cause warnings.
LARGEST_SCENE = 1000.0
#: Largest plausible size of a typical stone, in metres. A drawing causes a warning if half of its movable
#: blocks are both wider and higher than this value. With a smaller value, correct drawings of walls of large
#: stones would cause warnings.
LARGEST_SMALLER_SIDE = 2.0
#: Smallest number of movable blocks at which each block is assumed to be a single stone. In a scene with
#: fewer blocks, a block may be a whole wall. With a smaller value, scenes of a few wall-sized blocks would
#: cause warnings.
FEWEST_STONES = 10
