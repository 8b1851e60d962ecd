"""The way of a push: keyframes along its path."""

from itertools import pairwise

import numpy as np

from masonry_opt.answer.acceptance import SMALLEST
from masonry_opt.answer.solution import Way
from masonry_opt.answer.thresholds import PLATEAU
from masonry_opt.methods.push.push import Elastic
from masonry_opt.methods.push.pushed import Pushed

KEYFRAMES, _AGAIN = 60, 3.0  #: Keyframes, and how many times as far a path is shown as up to where λ stays.


def way(elastic: Elastic, pushed: Pushed) -> Way | None:
    """Keyframes of a push, on the tangents of its points; None of one that did not begin."""
    points, unit = pushed.points, elastic.problem.live_norm
    if len(points) < 2:
        return None
    curve = elastic.curve.rounded_by(pushed.rounding)
    path = [np.append(points[0].d, points[0].load_factor)]
    for before, after in pairwise(points):
        path += [curve.corner(before, after)] if len(points) < KEYFRAMES else []
        path += [np.append(after.d, after.load_factor)]
    u, load = np.array([(curve.live @ each[:-1], each[-1] / unit) for each in path]).T
    at = keyframes(u - u[0], load)
    first = np.minimum(at.astype(int), len(path) - 2)
    states = np.stack(path[: first[-1] + 2])
    states = states[first] + (at - first)[:, None] * np.diff(states, axis=0)[first]
    q = np.stack([curve.law.of_problem(curve.forces(each[:-1])) for each in states])
    d, load = states[:, :-1] - states[0, :-1], (states[:, -1] - states[0, -1]) / unit
    return Way(elastic.giving(1.0), d @ curve.live, load, d, q, pushed.rounding)


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
