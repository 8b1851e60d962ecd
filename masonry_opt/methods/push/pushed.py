"""How a push ends, and what it went through."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from masonry_opt.answer.answer import Answer
from masonry_opt.methods.push.growth import Growth
from masonry_opt.methods.push.path import Point

#: Share by which λ falls and rises again from which it is told: of 83 random scenes that do, a growing load
#: brings three down in contact dynamics at less than .92 of the highest λ; of 31 others none. And share of
#: the largest λ below which no fall is.
_DEEP, _TRIFLE = 0.1, 1e-2


class Ended(StrEnum):
    """How a push ends: on a ray on which the scene collapses, or friction jams, or the live load is drawn
    back; without a state under the dead load; before an end is found."""

    RAY = "ray"
    JAM = "jam"
    BACK = "the live load is drawn back"
    NOT_SETTLED = "its contacts do not come to carry the dead load"
    STOPPED = "no end was found"


@dataclass(frozen=True)
class PushStep:
    """A point of the push."""

    iteration: int  #: counted from 1
    displacement: float  #: u, in motions of a contact of mean size under the mean force
    load_factor: float  #: λ
    corrections: int  #: Newton's steps from the tangent onto the path


@dataclass(frozen=True)
class Pushed:
    """A push from rest."""

    ended: Ended
    steps: tuple[PushStep, ...] = ()
    points: tuple[Point, ...] = ()
    answer: Answer | None = None  #: the exact state at the ray
    #: Largest λ on the way, to which a load comes that grows, if it is above the end by more than load
    #: factors that are the same differ by, else λ there; None without a load factor.
    peak: float | None = None
    rounding: float = 0.0  #: of the law, in mean forces
    growth: Growth | None = None  #: of a load, where the path came to no end
    growth_steps: tuple[PushStep, ...] = ()

    @property
    def folds(self) -> int:
        """How often the displacement turned."""
        moves = np.diff([step.displacement for step in self.steps])
        way = np.sign(moves[moves != 0])
        return int((way[1:] != way[:-1]).sum())

    @property
    def deep_fall(self) -> tuple[float, float] | None:
        """λ from which it first falls deep, to come higher later, and the largest share by which it does."""
        path = np.array([0.0, *(step.load_factor for step in self.steps)])
        path = path[: path.argmax() + 1]
        path = path[np.maximum.accumulate(path) > _TRIFLE * path[-1]]
        highest = np.maximum.accumulate(path)
        deep = 1 - path / highest > _DEEP
        return (float(highest[deep.argmax()]), float((1 - path / highest).max())) if deep.any() else None
