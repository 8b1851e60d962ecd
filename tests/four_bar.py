"""Three bodies between four hinges at finite rotations: their geometry by circles, λ by virtual work.

Independent of the package: bodies are bars A–B, B–C, C–D from ground to ground; the first one's rotation is
given, C follows as a point of two circles, and velocities from those of B and C.
"""

from dataclasses import dataclass

import numpy as np


@dataclass
class Body:
    """Dead and live forces on one of the bodies, and where they act, as complex numbers."""

    at: np.ndarray
    dead: np.ndarray
    live: np.ndarray


def load_factors(hinges: np.ndarray, bodies: list[Body], rotations: np.ndarray) -> np.ndarray:
    """λ at rotations of the first body, shape (n,), of hinges A, B, C, D at rest, complex."""
    A, B, C, D = hinges
    found = []
    for rotation in rotations:
        b = A + np.exp(1j * rotation) * (B - A)
        # C lies on a circle about b, and on one about D, on the side where it lies at rest.
        line, r, s = D - b, abs(C - B), abs(C - D)
        along = (r**2 - s**2 + abs(line) ** 2) / (2 * abs(line))
        aside = np.sqrt(r**2 - along**2) * np.sign(((C - B) * np.conj(D - B)).imag)
        c = b + (along + 1j * aside) * line / abs(line)
        # Velocities: that of b from A, that of c from b and from D alike.
        v_b = 1j * (b - A)
        spans = np.array([1j * (c - b), -1j * (c - D)])
        w2, w3 = np.linalg.solve(np.array([spans.real, spans.imag]), -np.array([v_b.real, v_b.imag]))
        turned = [np.exp(1j * rotation), (c - b) / (C - B), (c - D) / (C - D)]
        starts, speeds = (A, B, D), ((0, 1.0), (v_b, w2), (0, w3))
        dead = live = 0.0
        for body, turn, start, (v, w) in zip(bodies, turned, starts, speeds, strict=True):
            velocity = v + 1j * w * turn * (body.at - start)
            dead += (velocity * np.conj(body.dead)).real.sum()
            live += (velocity * np.conj(body.live)).real.sum()
        found.append(-dead / live)
    return np.array(found)
