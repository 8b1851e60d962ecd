"""
How far may a tower of scanned stones lean?
===========================================

A tower of eight sides has come to lean, and its drums with it. They are modelled in Rhino or Blender, or
scanned, and come as one OBJ file: a closed mesh a stone, lengths in metres with three decimals. At what lean
does it fall, and what is left of it before?
"""

from math import cos, pi, sin
from pathlib import Path
from tempfile import TemporaryDirectory

import masonry_opt as mo

RADIUS, HEIGHT, DRUMS, SIDES = 2.0, 12.0, 6, 8


# %%
# Such a file, of our own making: `o` begins a stone and names it (those named "fixed ..." are supports), `v`
# is a corner, and `f` a face by the numbers of its corners, which count on through the file.
def tower(lean: float) -> str:
    """Drums whose middles move to x by ``lean`` for each metre of height, on a plinth."""
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
    """From the file to a scene; live load: an earthquake towards the lean."""
    with TemporaryDirectory() as folder:
        path = Path(folder, "tower.obj")
        path.write_text(tower(lean))
        return mo.read_mesh(path, friction=0.7, unit_weight=22, live=(1, 0, 0))


# %%
# By hand: it turns about the side of its foot that it leans to, a = R cos(π/8) from the middle. The weight
# acts at half the height, h/2 · lean nearer: λ = (a − lean h/2) / (h/2), and it falls at lean = a / (h/2).
foot = RADIUS * cos(pi / SIDES)
for lean in (0.0, 0.1, 0.2):
    result = mo.solve(read(lean))
    print(f"lean {lean}: load factor {result.required():.4f}")
    assert abs(result.required() - (foot / (HEIGHT / 2) - lean)) < 3e-4
greatest = mo.most(read, 0, 0.5, samples=0, tolerance=1e-3).value
print(f"it falls from a lean of {greatest:.4f}")
assert abs(greatest - foot / (HEIGHT / 2)) < 1e-3
result.plot(view=(-70, 15))
