"""A load that grows until blocks do not come to rest under it, where a path is too long to be followed.

Contacts remember slip. The live load's displacement grows by steps as long as λ does. Where it would not, as
at the edge of a jump, the load grows, and blocks move until they come to rest under it, or on for ever:

    B (q - η k Bᵀd) + λ f + f_D = 0

in steps d from where they are, of a damping η that falls (a proximal point method, by Newton's steps).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from masonry_opt.methods.push.path import Curve

#: First step, in motions of a contact under the mean force; how many times as long each is as the one before;
#: how many times shorter one becomes that does not succeed, and how often; and steps at most.
_FIRST, _LONGER, _SHORTER, _TRIES, _MOST = 0.3, 2.0, 4.0, 2, 600

#: By how much a load grows that blocks are to come to rest under, over it; and by how much more it grows with
#: motions of ``_FAR`` where joints press ever harder.
_APART, _JAMS = 2e-3, 0.25

#: Damping at first, what it falls by after a step, and rises by where one fails; and steps at most.
_DAMPING, _LESS, _MORE, _DAMPED = 1.0, 0.25, 4.0, 300

#: Force out of balance, in mean forces, from which on rest is looked for; motion from which on blocks move
#: for ever; and share of λ that is no growth.
_RESTS, _FAR, _STAYS = 1e-4, 1e3, 1e-6

#: Roundings by which contacts are made sharp, over those of a load that grew; and by how much lower loads are
#: at most that these carry, over it.
_SHARPER, _LOWEST = (1.0, 0.1, 0.01), 0.1


@dataclass(frozen=True)
class Growth:
    """How far a load grew."""

    carried: float  #: the largest load under which blocks come to rest, in units of forces
    beyond: float | None  #: one under which they do not; None where λ stays as they move on
    before: Curve  #: contacts before the last step
    at: np.ndarray  #: displacements in it, and that load, shape (3b + 1,)


def grown(curve: Curve, follow: Callable[[float, float], None]) -> Growth | None:
    """How far the load grows from rest, each displacement and load that is come to being told; None if it
    grows on, as where joints press ever harder, or nothing rests without it."""
    rest = come_to_rest(curve, 0.0)
    if rest is None:
        return None
    (before, at), load = rest, 0.0
    here, u = before.slipped(at), before.u(at)
    way, length, tries = _ahead(here), _FIRST, 0
    for _ in range(_MOST):
        near = here.still(load) + length * way
        found = here.state(near, here.u(near))
        least = load - (_STAYS * abs(load) if length > _FAR else 0.0)
        if found is not None and found[-1] >= least:
            at = found
            moved, grows = here.moves(at), at[-1] - load
            if moved > _FAR and grows > _JAMS * abs(load):
                return None
            if moved > _FAR**2 and grows < _STAYS * abs(load):
                return Growth(float(at[-1]), None, here, at)
            way, length, tries = np.append(at[:-1], grows) / moved, _LONGER * moved, 0
        elif tries < _TRIES:
            length, tries = length / _SHORTER, tries + 1
            continue
        else:
            more = load + _APART * max(abs(load), _APART * curve.unit)
            rest = come_to_rest(here, more)
            if rest is None:
                return Growth(load, float(more), before, at)
            here, at = rest
            way, length, tries = _ahead(here.slipped(at)), _FIRST, 0
        before, here, load, u = here, here.slipped(at), float(at[-1]), u + here.u(at)
        follow(u, load)
    return None


def sharp_steps(growth: Growth) -> Iterator[tuple[Curve, np.ndarray]]:
    """The same as :func:`come_to_rest` of contacts made sharp, which carry less where rounder ones hold by a
    corner, under lower and lower loads."""
    apart = _APART
    while apart <= _LOWEST and growth.carried > 0:
        here = growth.before.slipped(growth.at)
        for rounding in _SHARPER:
            sharp = here.rounded_by(rounding * growth.before.rounding)
            rest = come_to_rest(sharp, (1 - apart) * growth.carried)
            if rest is None:
                break
            here = rest[0].slipped(rest[1])
        else:
            rest = come_to_rest(here, (1 - apart / 2) * growth.carried)
            if rest is not None:
                yield rest
        apart *= 2


def _ahead(curve: Curve) -> np.ndarray:
    """d' and λ', shape (3b + 1,), of a motion of one, as the load grows."""
    along = curve.along(curve.still(0.0))
    found: np.ndarray = along / np.copysign(curve.moves(along) or 1.0, along[-1])
    return found


def come_to_rest(curve: Curve, load: float) -> tuple[Curve, np.ndarray] | None:
    """Contacts before the last step to where blocks come to rest under a load, displacements in it, and the
    load; None if they do not."""
    still = curve.still(load)
    damping, eased, rests, gone = _DAMPING, True, np.inf, 0.0
    size = curve.unbalanced(still)
    for _ in range(_DAMPED):
        if size < rests:
            found = curve.state(still, None)
            if found is not None:
                return curve, found
            rests = min(_RESTS, size / 10)
        found = replace(curve, damping=damping).state(still, None)
        if found is not None:
            size, gone = curve.unbalanced(found), gone + curve.moves(found)
            curve = curve.slipped(found)
            damping *= _LESS if eased else 1.0
        elif gone > _FAR:
            return None
        else:
            damping *= _MORE
        eased = found is not None
    return None
