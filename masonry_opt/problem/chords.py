"""Crushing by chords: |m| ≤ n (L/2 − n / (2 f_c)) as a polygon inside the parabola, so that linear programs
take it and λ errs on the safe side.

In x = n / (f_c L) the limit is m ≤ f_c L · L/2 · x (1 − x). Knots at equal steps of √x up to the middle, and
mirrored beyond it, let every chord miss nearly the same share of the moment, (step)² / (1 − x) or less:
twelve on each side of the middle miss 0.35 to 0.64 % of it at most. Most masonry is stressed below the first
knot: further knots there, each at a quarter of the next, let the share fall with the stress.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

#: Chords on each side of the largest moment, and those that part the first again.
_ON_EACH_SIDE, _NEAR_NOTHING = 12, 4


class Chords(NamedTuple):
    """Lines m ≤ L/2 (slope · n + constant · f_c L), the first through no force; shape (chords,) each."""

    slope: np.ndarray
    constant: np.ndarray


def _chords() -> Chords:
    rising = np.linspace(0.0, np.sqrt(0.5), _ON_EACH_SIDE + 1) ** 2
    low = rising[1] / 4.0 ** np.arange(_NEAR_NOTHING, 0, -1)
    knots = np.concatenate([[0.0], low, rising[1:], 1 - rising[-2::-1]])
    left, right = knots[:-1], knots[1:]
    return Chords(1 - left - right, left * right)


CHORDS = _chords()

#: The largest share of the moment that a chord misses: beside the middle.
MISSED = 0.0065


def chord_rates(opening: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Rates p ≥ 0 of all chords, shape (2, joints, chords), (+) and (−), that follow a motion and dissipate
    least: only the chords whose normals enclose the motion have any.

    Parameters
    ----------
    opening: negative where material is crushed, shape (joints,).
    rotation: times L/2, shape (joints,).
    """
    slope, joints, turning = CHORDS.slope, np.arange(len(opening)), np.abs(rotation)
    p = np.zeros((2, len(opening), len(slope)))
    sense = (rotation > 0).astype(int)
    # Between the chords at `after - 1` and `after`, whose slopes enclose opening over rotation.
    after = (opening[:, None] < slope * turning[:, None]).sum(axis=1)
    inner = (after > 0) & (after < len(slope))
    i, k = joints[inner], after[inner]
    share = (opening[i] - slope[k] * turning[i]) / (slope[k - 1] - slope[k])
    p[sense[i], i, k - 1], p[sense[i], i, k] = share, turning[i] - share
    # Beyond the first chord it opens more than it turns, beyond the last it crushes more than it turns.
    for end, those in ((0, joints[after == 0]), (-1, joints[after == len(slope)])):
        both = opening[those] / slope[end]
        p[:, those, end] = np.stack([both - rotation[those], both + rotation[those]]) / 2
    return p


def parabola(n: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """Largest moment over L/2 under normal forces n, shape (joints,), which the chords approach: negative
    where n exceeds ``whole``, f_c L of each joint."""
    return n * (1 - n / whole)


def crushing_energy(opening: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Energy that the parabola dissipates in a motion, over f_c L, shape (joints,): the greatest of
    |rotation| x (1 − x) − opening x over 0 ≤ x ≤ 1.

    Opening and rotation are those of :func:`chord_rates`.
    """
    turning = np.abs(rotation)
    ratio = np.divide(opening, turning, out=np.where(opening < 0, -1.0, 1.0), where=turning > 0)
    x = np.clip((1 - ratio) / 2, 0.0, 1.0)
    return turning * x * (1 - x) - opening * x
