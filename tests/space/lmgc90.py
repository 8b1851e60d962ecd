"""Blocks in space pushed from rest in LMGC90: non-smooth dynamics, rigid contacts, large displacements.

Needs compas_lmgc90 (0.1.11), no dependency of the tests. ``python -m space.lmgc90 corner_wall_20_0.6 …`` in
tests/ prints what `reference_values` holds.
"""

import sys

import numpy as np
from space.boxes import Boxes
from space.reference_values import OUTWARDS, REFERENCES

#: Time without a live load, then over which it grows, and of a step, in seconds. Blocks creep by an error of
#: each step: with steps of .01 s over 40 s by 5 to 60 mm, and fall at less.
SETTLES, GROWS, STEP = 1.0, 20.0, 2e-3
#: Speeds in m/s, over a tenth of a second, of blocks that begin to leave and have left.
LEAVING, LEFT = 5e-3, 5e-2

_FACES = [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
_CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])


def departs(
    boxes: Boxes, direction: tuple[float, float, float], friction: float, most: float
) -> tuple[float, float]:
    """Load factors, growing from 0 to the most, at which the fastest block leaves and has left."""
    from compas_lmgc90.solver import Solver

    density, gravity = 1000.0, 9.81
    solver = Solver(dt=STEP, density=density)
    for low, high in zip(boxes.low, boxes.high, strict=True):
        vertices = low + _CORNERS * (high - low)
        solver.geometry_from_v_f({"vertices": vertices.tolist(), "faces": _FACES})
    solver.set_supports(z_threshold=0.0)
    times = [0.0, SETTLES, SETTLES + GROWS]
    for block in np.flatnonzero(~boxes.fixed):
        for name, share in zip(("Fx", "Fy", "Fz"), direction, strict=True):
            force = most * share * density * gravity * boxes.volume[block]
            solver.apply_force(int(block), name, np.array([times, [0.0, 0.0, force]]))
    solver.contact_law("IQS_CLB_g0", friction, alert=1e-2)
    solver.preprocess()
    window = round(0.1 / STEP)
    before = solver.lmgc90.compute_one_step().bodies
    leaving = most
    for number in range(1, round(GROWS / 0.1 + SETTLES / 0.1)):
        for _ in range(window):
            now = solver.lmgc90.compute_one_step().bodies
        speed = np.linalg.norm(np.subtract(now, before), axis=1).max() / 0.1
        load_factor = max(0.0, most * (0.1 * number - SETTLES) / GROWS)
        leaving = most if speed < LEAVING else min(leaving, load_factor)
        if speed > LEFT:
            return leaving, load_factor
        before = now
    raise ArithmeticError("stands under the most")


if __name__ == "__main__":
    for reference in REFERENCES:
        if str(reference) in sys.argv[1:]:
            found = departs(reference.boxes, OUTWARDS, reference.friction, 1.1 * reference.associative)
            print(reference, *(round(value, 4) for value in found), flush=True)
