"""
How far may a tower of scanned stones lean?
===========================================

A tower of octagonal drums leans. The drums were modelled in Rhino or Blender, or scanned, and exported to one
OBJ file. The file has a closed mesh for each stone, with coordinates in metres and three decimals. At which
lean does the tower collapse, and what is its load factor at a smaller lean?
"""

from math import cos, pi, sin
from pathlib import Path
from tempfile import TemporaryDirectory

import masonry_opt as mo

RADIUS = 2.0
HEIGHT = 12.0
DRUMS = 6
SIDES = 8


# %%
# A function writes such a file. A line ``o`` begins a stone and names it, and stones named "fixed ..." are
# supports. A line ``v`` is a corner. A line ``f`` is a face, given by the numbers of its corners. Corners are
# numbered through the whole file.
def tower(lean: float) -> str:
    """Return the lines of an OBJ file: drums on a plinth, shifted along x by ``lean`` per metre of height."""
    levels = [(-1, 0), *((HEIGHT * drum / DRUMS, HEIGHT * (drum + 1) / DRUMS) for drum in range(DRUMS))]
    lines = []
    for stone, level in enumerate(levels):
        lines.append(f"o drum {stone}" if stone else "o fixed plinth")
        for z in level:
            for turn in (pi / SIDES * (2 * side + 1) for side in range(SIDES)):
                x = RADIUS * cos(turn) + lean * max(z, 0)
                lines.append(f"v {x:.3f} {RADIUS * sin(turn):.3f} {z:.3f}")
        first = 2 * SIDES * stone + 1
        low, high = list(range(first, first + SIDES)), list(range(first + SIDES, first + 2 * SIDES))
        sides = [[low[a - 1], low[a], high[a], high[a - 1]] for a in range(SIDES)]
        lines += ["f " + " ".join(map(str, face)) for face in (low[::-1], high, *sides)]
    return "\n".join(lines)


def read(lean: float) -> mo.Scene:
    """Write and read the file, and return the scene. The live load is an earthquake towards the lean."""
    with TemporaryDirectory() as folder:
        path = Path(folder, "tower.obj")
        path.write_text(tower(lean))
        return mo.read_mesh(path, friction=0.7, unit_weight=22, live=(1, 0, 0))


# %%
# By hand: the tower rotates about the side of its foot in the direction of lean, at the distance a = R
# cos(π/8) from the middle. The weight acts at half the height, and the lean shifts it by lean · h/2 towards
# this side. Hence λ = (a − lean h/2) / (h/2), and the tower collapses under its own weight at lean = a /
# (h/2).
foot = RADIUS * cos(pi / SIDES)
for lean in (0.0, 0.1, 0.2):
    result = mo.solve(read(lean))
    print(f"lean {lean}: load factor {result.required():.4f}")
    assert abs(result.required() - (foot / (HEIGHT / 2) - lean)) < 3e-4
greatest = mo.most(read, 0, 0.5, samples=0, tolerance=1e-3).value
print(f"it falls from a lean of {greatest:.4f}")
assert abs(greatest - foot / (HEIGHT / 2)) < 1e-3
result.plot(view=(-70, 15))
