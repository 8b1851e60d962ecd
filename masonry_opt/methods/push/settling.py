"""Forces under the dead load from rest: contacts are bonded, and their bonds fall to nothing."""

from __future__ import annotations

import numpy as np

from masonry_opt.methods.push.blocks import Blocks
from masonry_opt.methods.push.laws import Law
from masonry_opt.methods.push.path import Path
from masonry_opt.problem.problem import Problem


def settling(problem: Problem, law: Law) -> Path:
    """The path that begins where bonds hold everything, and contacts are elastic."""
    rest, still = np.zeros_like(law.stiffness), np.zeros(problem.dead.size)
    path = Path(law, Blocks(problem, law, None), rest, problem.dead, None, law.inside, still)
    path.drive = _needed(law, path.trial)
    return path


def _needed(law: Law, forces: np.ndarray) -> float:
    """A tension of bonds that holds forces, shape (3, m): twice the least."""
    beyond = np.stack([forces[2], -forces[2]]) - law.limits - law.friction * forces[:2].sum(axis=0)
    crushed = -np.einsum("fpm,pm->fm", law.normals, forces[:2]) - law.room
    short = np.concatenate([np.where(np.isfinite(beyond), beyond, 0.0), crushed])
    held = np.concatenate([2 * [2 * law.friction + law.bond], law.normals.sum(axis=1) + law.widened])
    return 2 * float(np.divide(short, held, out=np.zeros_like(short), where=held > 0).max(initial=0.0))
