"""Collapse load of a hemispherical dome under rotationally symmetric loads: a linear program of one sector.

The program does not use the package. By symmetry, nothing slides across a meridian, and the forces on the two
sides of a voussoir are mirror images. The program works in the vertical plane through the middle of a sector.
Its coordinates are the distance from the axis and the height. A normal force and a shear act at each end of a
bed. At the corners of the sides, the two hoop forces have an outward resultant, 2 sin(π/n) times one of them.
"""

import numpy as np
from scipy.optimize import linprog


def load_on_key(
    radius: float, thickness: float, rings: int, voussoirs: int, friction: float, hoops: bool = True
) -> float | None:
    """Return the greatest load on the key of a dome, in units of the weight per volume.

    All joints have the same friction. The load is None if the dome is unstable under its weight. Without
    ``hoops``, hoop forces are zero, so that the sectors act as independent arches ("slices of an orange").
    """
    inner, outer = radius - thickness / 2, radius + thickness / 2
    half = np.pi / voussoirs
    step = np.pi / (2 * rings + 1)

    def corner(distance: float, bed: int) -> np.ndarray:
        return distance * np.array([np.cos(half) * np.cos(step * bed), np.sin(step * bed)])

    # Volumes: a section that turns about the axis sweeps 2 π ρ. A sector with flat faces sweeps sin(2π/n) ρ,
    # with ρ measured to its corners.
    swept = np.sin(2 * half) * (outer**3 - inner**3) / 3 * np.sin(step) * np.cos(step / 2)
    weight = [swept * np.cos((ring + 0.5) * step) for ring in range(rings)]
    # Centroids, ∫∫ ρ² over ∫∫ ρ, by cubature of each section, whose sides are chords, in polar coordinates.
    sections = [_moments(inner, outer, ring * step, step) for ring in range(rings)]
    low, high = (d * np.array([np.cos(rings * step), np.sin(rings * step)]) for d in (inner, outer))
    swell = (low[0] ** 2 + low[0] * high[0] + high[0] ** 2) / 3
    key = np.sin(2 * half) / 2 * swell * (high[1] - low[1])

    # Columns: n and s at the inner and outer end of each bed, four hoop forces of each ring, and the load.
    beds, columns = 4 * (rings + 1), 4 * (rings + 1) + 4 * rings + 1
    A, b = np.zeros((3 * rings + 1, columns)), np.zeros(3 * rings + 1)
    for ring in range(rings):
        rows = slice(3 * ring, 3 * ring + 3)
        for bed, sign in ((ring, 1.0), (ring + 1, -1.0)):
            up, along = _bed_axes(corner(1.0, bed), half, step * bed)
            for end, distance in enumerate((inner, outer)):
                for kind, direction in enumerate((up, along)):
                    A[rows, 4 * bed + 2 * end + kind] = _wrench(corner(distance, bed), sign * direction)
        for number, (distance, bed) in enumerate((d, j) for d in (inner, outer) for j in (ring, ring + 1)):
            outwards = 2 * np.sin(half) * np.array([1.0, 0.0])
            A[rows, beds + 4 * ring + number] = _wrench(corner(distance, bed), outwards) * hoops
        b[rows] = -_wrench(sections[ring] * [np.cos(half), 1.0], np.array([0.0, -weight[ring]]))
    # Vertical equilibrium of the key; its other equations hold by symmetry.
    up, along = _bed_axes(corner(1.0, rings), half, step * rings)
    A[-1, 4 * rings : 4 * rings + 4] = [up[1], along[1]] * 2
    A[-1, -1], b[-1] = -1.0 / voussoirs, key
    sliding = np.zeros((2 * beds // 2, columns))
    for slider in range(beds // 2):
        sliding[2 * slider, 2 * slider : 2 * slider + 2] = -friction, 1.0
        sliding[2 * slider + 1, 2 * slider : 2 * slider + 2] = -friction, -1.0
    bounds = [(0, None), (None, None)] * (beds // 2) + [(0, None)] * (4 * rings) + [(0, None)]
    found = linprog(-np.eye(columns)[-1], sliding, np.zeros(len(sliding)), A, b, bounds)
    return float(found.x[-1]) if found.status == 0 else None


def _bed_axes(direction: np.ndarray, half: float, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the upward unit normal of a bed, and the outward unit vector along the bed."""
    along = direction / np.linalg.norm(direction)
    return np.array([-along[1], along[0]]), along


def _wrench(at: np.ndarray, force: np.ndarray) -> np.ndarray:
    return np.array([*force, at[0] * force[1] - at[1] * force[0]])


def _moments(inner: float, outer: float, start: float, step: float) -> np.ndarray:
    """Return the mean of (ρ, z), weighted by ρ, over the quadrilateral between two chords."""
    ends = [np.array([np.cos(angle), np.sin(angle)]) for angle in (start, start + step)]
    nodes, weights = np.polynomial.legendre.leggauss(4)
    distance = inner + (nodes + 1) / 2 * (outer - inner)
    along = ends[0] + (nodes[:, None] + 1) / 2 * (ends[1] - ends[0])
    point = distance[:, None, None] * along
    share = np.outer(weights * distance, weights) * point[..., 0]
    return np.tensordot(share, point) / share.sum()
