"""Joints stressed too highly to dilate: the check of section 6.5 of the paper."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.motion import fastest
from masonry_opt.answer.outcome import Outcome
from masonry_opt.answer.thresholds import SLIDES
from masonry_opt.errors import OptionError

if TYPE_CHECKING:
    import pandas as pd


def stressed_joints(result: Outcome, above: float | None = None) -> pd.DataFrame:
    """Joints that slide with dilation in an associative answer, stressed too highly to dilate.

    Real joints dilate little under high normal stress (section 6.5). Where such joints slide, the associative
    load factor may be too high, the more so the more energy goes into them.

    Parameters
    ----------
    result:
        Of method "static" or "kinematic".
    above:
        Mean normal stress (force per unit length of joint) above which dilatancy is not credible.
        Default: from where on the scene's own ``dilatancy_stress`` leaves none, joint by joint.

    Returns
    -------
    pandas.DataFrame
        One row a joint, by its number in ``result.joints``: ``first``, ``second`` (blocks), ``x``,
        ``y`` (middle), ``stress`` (mean normal stress), ``slip`` (its rate), ``dilation`` (the rate
        at which sliding opens the joint) and ``energy`` (what the live load spends on that dilation
        against the normal force, in units of λ).

    Raises
    ------
    OptionError
        If the result is of another method or of a scene in space, or has no mechanism, ``above`` is
        not a number from zero on, or neither it nor the scene says what stress is too high.
    """
    if getattr(result, "kind", None) is not Kind.ASSOCIATIVE:
        method = getattr(result, "method", type(result).__name__)
        raise OptionError(
            f"stressed_joints: takes an associative result (method 'static' or 'kinematic'), not one of "
            f"'{method}'"
        )
    result.assembly.scene.in_plane()
    answer, problem = result.solution.answer, result.assembly.problem
    if answer is None:
        raise OptionError(f"stressed_joints: the result has no mechanism: {result.status}")
    n, slip = problem.normal_forces(answer.q), problem.slip_speed(answer.d)
    friction = np.zeros(problem.joints)
    friction[problem.sliding] = problem.friction
    frame = result.joints[["first", "second", "x", "y"]].assign(
        stress=result.joints["n"] / result.joints["length"],
        slip=result.joints["slip"],
        dilation=friction * slip,
    )
    frame["energy"] = frame["dilation"] * n / problem.live_norm
    dilates = (frame["dilation"] > 0) & (slip > SLIDES * fastest(result.assembly, answer.d))
    return frame[dilates & (n > _least_force(result, above))]


def _least_force(result: Outcome, above: float | None) -> np.ndarray:
    """Normal forces above which dilatancy is not credible, in the problem's unit, shape (c,)."""
    problem = result.assembly.problem
    if above is None:
        none = problem.dilatancy_force[:, 1]
        if not np.isfinite(none).any():
            raise OptionError(
                "stressed_joints: say 'above' which stress dilatancy is not credible, or give the scene's "
                "joints 'dilatancy_stress'"
            )
        least = np.full(problem.joints, np.inf)
        least[problem.sliding] = none
        return least
    if not (isinstance(above, (int, float)) and math.isfinite(above) and above >= 0):
        raise OptionError(f"stressed_joints: 'above' must be a number from 0 on (found {above!r})")
    return above * result.assembly.joints.extent / problem.force_unit
