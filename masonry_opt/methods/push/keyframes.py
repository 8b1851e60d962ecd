"""Keyframes of a push: where along its path it is shown."""

from __future__ import annotations

import numpy as np

from masonry_opt.answer.acceptance import SMALLEST
from masonry_opt.answer.thresholds import PLATEAU

#: Keyframes, and how many times as far a path is shown as up to where λ stays.
KEYFRAMES, _AGAIN = 60, 3.0


def keyframes(u: np.ndarray, load_factor: np.ndarray) -> np.ndarray:
    """Places of keyframes in a path of displacements u and λ, shape (points,) each, as fractional numbers of
    its points, shape (k,): as far apart as the curve of λ over u is long, u beyond where λ is half its
    highest by its logarithm; but at points of the path, first of all at folds and turns, if any are near."""
    away = np.abs(load_factor - load_factor[-1]) > PLATEAU * np.abs(load_factor).max()
    stays, numbers = int(np.flatnonzero(away).max(initial=0)) + 1, np.arange(len(u))
    goal, end = _AGAIN * u[: stays + 1].max(), len(u) - 1.0
    beyond = stays + np.flatnonzero(u[stays:] >= goal)
    if goal > 0 and len(beyond):
        last = beyond[0] - 1 + np.arange(2)
        end = float(np.interp(goal, u[last], last))
    places = np.append(numbers[numbers < end], end)
    half = max(abs(u[(np.abs(load_factor) >= np.abs(load_factor).max() / 2).argmax()]), SMALLEST)
    shown = np.sign(u) * np.log1p(np.abs(u) / half), load_factor
    steps = np.stack([np.diff(np.interp(places, numbers, of)) for of in shown])
    sizes = np.maximum(np.abs(steps.cumsum(axis=1)).max(axis=1, keepdims=True), SMALLEST)
    far = np.append(0.0, np.hypot.reduce(steps / sizes, axis=0).cumsum())
    turns = 1 + np.flatnonzero((steps[:, 1:] * steps[:, :-1] < 0).any(axis=0))
    at, apart = np.linspace(0.0, far[-1], KEYFRAMES, retstep=True)
    for kept in (numbers[1 : len(places) - 1], turns):
        at[np.rint(far[kept] / apart).astype(int)] = far[kept]
    at[[0, -1]] = far[[0, -1]]
    found: np.ndarray = np.interp(at, far, places)
    return found
