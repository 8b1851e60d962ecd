"""The resultants that joints carry, and where they act."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_opt.answer.result import Result

#: Normal forces below this share of the scene's largest are nothing, as for ``utilisation``.
_NOTHING = 1e-6


@dataclass(frozen=True)
class Thrust:
    """What each joint carries, in the order of ``Result.joints``; NaN of a result without forces.

    Attributes
    ----------
    force: resultant on the joint's first block (on the second it is the opposite), in the case's unit of
        force, shape (c, 2).
    point: where it acts, in the case's coordinates; NaN where nothing presses the joint together, shape
        (c, 2).
    """

    force: np.ndarray
    point: np.ndarray


def thrust(result: Result) -> Thrust:
    """Resultants n, s at m / n from the joint's middle: together they do what n, s, m do in eq. (1)."""
    joints, frame = result.assembly.joints, result.joints
    n, s, m = (frame[name].to_numpy() for name in ("n", "s", "m"))
    # The direction of s. Where a joint has length it runs from start to end.
    along = np.column_stack([joints.normal[:, 1], -joints.normal[:, 0]])
    force = n[:, None] * joints.normal + s[:, None] * along
    pressed = n > _NOTHING * np.abs(n).max(initial=0.0)
    off = np.divide(m, n, out=np.full_like(n, np.nan), where=pressed)
    return Thrust(force, frame[["x", "y"]].to_numpy() + off[:, None] * along)
