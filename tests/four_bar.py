"""Load factors of a four-bar linkage at finite rotations, by geometry and virtual work.

The computation is independent of the package. The bodies are the bars A–B, B–C and C–D, and A and D are
fixed. For a given rotation of the first bar, C is an intersection of two circles. The velocities of the bars
follow from the velocities of B and C.
"""

from dataclasses import dataclass

import numpy as np


@dataclass
class Body:
    """Dead and live forces on a body, and their points of action, as complex numbers."""

    at: np.ndarray
    dead: np.ndarray
    live: np.ndarray


def load_factors(hinges: np.ndarray, bodies: list[Body], rotations: np.ndarray) -> np.ndarray:
    """Return λ for each rotation of the first body, shape (n,); hinges A, B, C, D at rest are complex."""
    A, B, C, D = hinges
    found = []
    for rotation in rotations:
        b = A + np.exp(1j * rotation) * (B - A)
        # C is the intersection of circles about b and D on the side on which C lies at rest.
        line, r, s = D - b, abs(C - B), abs(C - D)
        along = (r**2 - s**2 + abs(line) ** 2) / (2 * abs(line))
        aside = np.sqrt(r**2 - along**2) * np.sign(((C - B) * np.conj(D - B)).imag)
        c = b + (along + 1j * aside) * line / abs(line)
        # The velocity of b follows from A. The velocity of c from b equals its velocity from D.
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
