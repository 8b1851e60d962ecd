"""Forces under the dead load from rest: contacts are bonded, and their bonds fall to nothing."""

from __future__ import annotations

import numpy as np

from masonry_opt.methods.push.laws import Law
from masonry_opt.methods.push.path import Blocks, Path
from masonry_opt.problem.problem import Problem


def settling(problem: Problem, law: Law, noise: np.ndarray) -> Path:
    """The path that begins where bonds hold everything, and contacts are elastic.

    Parameters
    ----------
    noise: forces that contacts give from, shape (3c + t,), small and random: no two events coincide.
    """
    blocks, still = Blocks(problem.matrices, None), np.zeros(problem.dead.size)
    path = Path(law, blocks, noise, problem.dead, None, law.holds_all, still, 0.0, 0.0)
    path.drive = _needed(law, path.trial(path.d))
    return path


def _needed(law: Law, q: np.ndarray) -> float:
    """A tension of bonds that holds forces, shape (3c + t,): twice the least."""
    normal, shear, T = law.parts(q)
    tension = 2 * law.friction + law.bond
    beyond = np.abs(shear) - law.cohesion - law.friction * normal.sum(axis=0)
    slides = beyond[law.sliding] / tension[law.sliding]
    return 2 * max(0.0, *(of.max(initial=0.0) for of in (-normal, slides, law.lowest - T, T - law.highest)))
