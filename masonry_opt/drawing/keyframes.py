"""Keyframes of a load history from rest to collapse, for the slider of a page."""

from dataclasses import dataclass

import numpy as np

from masonry_opt.solution.motion import joint_motion, joints_that_move
from masonry_opt.solution.outcome import Outcome

#: Number of keyframes from rest to the incremental load factor. A larger value makes larger pages. A smaller
#: value omits more steps of a long load history.
KEYFRAMES = 45
#: Number of keyframes of the collapse, which follow the load history. A larger value makes larger pages.
COLLAPSE_FRAMES = 15
#: Largest displacement at the end of the animated collapse, relative to the largest displacement before the
#: collapse. With a larger value, displacements before the collapse are drawn smaller.
COLLAPSE_LENGTH = 3.0
#: The animated collapse is scaled by the largest displacement before the collapse, or by this value if this
#: value is larger. Without the lower limit, the collapse would be invisible if no block moves before the
#: collapse. The unit is that of ``Keyframes.displacement``.
_LEAST_DISPLACEMENT = 1e-2


@dataclass(frozen=True, eq=False)
class Keyframes:
    """Displacements of the blocks and motions of the joints at k instants of an animation, up to collapse."""

    load_factor: np.ndarray  #: load factor λ, shape (k,)
    #: Displacement of the live load at each keyframe, shape (k,): the work of the live load divided by the
    #: sum of the magnitudes of the live forces. The unit is the distance by which an elastic joint of mean
    #: length closes under the mean contact force of the dead load.
    displacement: np.ndarray
    #: Displacements of the blocks at each keyframe from their state under dead load, shape (k, 3b).
    d: np.ndarray
    #: True for joints that slide at this keyframe or at an earlier keyframe, shape (k, joints).
    has_slid: np.ndarray
    is_open: np.ndarray  #: True for joints that are open at one end or both, shape (k, joints)


def keyframes_of(result: Outcome) -> Keyframes | None:
    """Return keyframes of the load history of a result, or None if no incremental load factor is known."""
    state = result.at_incremental
    if state is None or state.load_factor is None or state.solution.load_history is None:
        return None
    history, problem = state.solution.load_history, result.assembly.problem
    if len(history.steps) < 2:
        return None
    step_number = _evenly_along(history.displacements, history.load_factors)
    before = np.minimum(step_number.astype(int), len(history.steps) - 2)
    share = (step_number - before)[:, None]
    all_d = np.stack([step.d for step in history.steps])
    d = (1 - share) * all_d[before] + share * all_d[before + 1]
    load_factor = np.interp(step_number, np.arange(len(history.steps)), history.load_factors)
    # The states of joints are known only at load steps. Between two load steps, use the states of the earlier
    # step.
    sliding, are_open = (
        joints[step_number.astype(int)] for joints in joints_that_move(result.assembly, history.steps)
    )
    if state.solution.d is not None:
        collapse = _collapse(d, state.solution.d)
        mechanism = joint_motion(result.assembly, state.solution)
        d = np.concatenate([d, collapse])
        load_factor = np.append(load_factor, np.full(COLLAPSE_FRAMES, state.load_factor))
        slides, opens = mechanism.slides, mechanism.hinges | mechanism.separates
        sliding = np.concatenate([sliding, np.tile(sliding[-1] | slides, (COLLAPSE_FRAMES, 1))])
        are_open = np.concatenate([are_open, np.tile(are_open[-1] | opens, (COLLAPSE_FRAMES, 1))])
    displacement = d @ problem.live * (problem.live_displacement / problem.live_norm)
    return Keyframes(load_factor, displacement, d, np.maximum.accumulate(sliding), are_open)


def _collapse(d: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """Return displacements, shape (frames, 3b), that continue the last keyframe along a mechanism."""
    size = max(float(np.abs(d).max()), _LEAST_DISPLACEMENT)
    step = motion * ((COLLAPSE_LENGTH - 1) * size / np.abs(motion).max())
    shares = np.linspace(0.0, 1.0, COLLAPSE_FRAMES + 1)[1:]
    displacements: np.ndarray = d[-1] + shares[:, None] * step
    return displacements


def _evenly_along(displacement: np.ndarray, load_factor: np.ndarray) -> np.ndarray:
    """Return k points evenly spaced along the load–displacement curve, as fractional indices of load steps.

    The point nearest to each load step is moved to the load step, so that its index is whole.
    """
    steps = np.hypot(
        np.diff(displacement) / (np.ptp(displacement) or 1.0),
        np.diff(load_factor) / (np.ptp(load_factor) or 1.0),
    )
    length = np.append(0.0, steps.cumsum())
    at = np.linspace(0.0, length[-1], KEYFRAMES)
    at[np.rint(length / at[1]).astype(int)] = length
    at[[0, -1]] = length[[0, -1]]
    numbers: np.ndarray = np.interp(at, length, np.arange(len(length)))
    return numbers
