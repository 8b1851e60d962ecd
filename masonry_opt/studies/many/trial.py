"""Trial of the search for a threshold: a scene for one value of the varied parameter, and its answer."""

import math
from dataclasses import dataclass, field

from masonry_opt.brief import brief
from masonry_opt.reporting.load_factors import ASSOCIATIVE
from masonry_opt.result import Result
from masonry_opt.solution.answer import Certificate
from masonry_opt.studies.many.scene_answer import SceneAnswer

FALLS = -math.inf  #: Value of ``Trial.number`` for a scene that is unstable under its dead load.
UNLIMITED = math.inf  #: Value of ``Trial.number`` for a scene that carries any load.


@dataclass(frozen=True)
class Trial:
    """Scene for one value of the varied parameter, with its answer."""

    value: float  #: value of the parameter
    holds: bool  #: True if the scene carries the required load or, without a required load, is stable
    number: float  #: load factor, or margin under dead load alone; -inf if unstable, inf if unlimited
    #: result of the scene; if axles move over the scene, the answer also contains the crossing
    answer: SceneAnswer = field(repr=False)
    #: residuals of the solution that has the load factor or margin ``number``; None without such a solution
    certificate: Certificate | None = field(repr=False)

    __repr__ = brief

    @property
    def result(self) -> Result:
        """Result of the scene, with its state or mechanism.

        Under dead load alone, it is the result that has the margin. If axles move over the
        scene, it is the result at their worst position.
        """
        return self.answer.result

    @property
    def name(self) -> str:
        """Name of the kind of load factor in ``number``, such as "lowest found".

        If the method found no load factor, a finite ``number`` is the associative load factor.
        """
        return self.answer.load_factor_name or ASSOCIATIVE
