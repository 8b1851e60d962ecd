"""Records of joint properties: those of all joints of a scene, and exceptions between two blocks."""

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Field, PlainSerializer, Strict, model_validator

from masonry_opt.scene.blocks import Name, NonNegative, Number, Positive, Record

LARGEST_FRICTION = 1e6  #: Beyond this a friction row is nothing but rounding.


def _friction(value: float) -> float:
    if not value >= 0:
        raise ValueError("must be zero or more")
    if LARGEST_FRICTION < value < math.inf:
        raise ValueError("is too large to be a friction: write inf for a joint that cannot slide")
    return value + 0.0


Stresses = tuple[NonNegative, NonNegative]
Angle = Annotated[float, Strict(), Field(ge=0, lt=90)]
#: tan φ; ``inf`` (in JSON the string "inf") for a joint that cannot slide.
Friction = Annotated[
    float,
    Strict(),
    BeforeValidator(lambda value: math.inf if isinstance(value, str) and value == "inf" else value),
    AfterValidator(_friction),
    PlainSerializer(lambda value: "inf" if math.isinf(value) else value, when_used="json"),
]


class _InDegrees(Record):
    """Angles in degrees: taken in place of their tangents, which are kept."""

    friction_angle: Angle | None = Field(default=None, exclude=True, repr=False)
    dilatancy_angle: Angle | None = Field(default=None, exclude=True, repr=False)

    @model_validator(mode="before")
    @classmethod
    def _as_tangents(cls, given: Any) -> Any:
        if not isinstance(given, Mapping):
            return given
        keys = dict(given)
        for tangent in ("friction", "dilatancy"):
            angle = f"{tangent}_angle"
            degrees = keys.get(angle)
            if degrees is None:
                continue
            if keys.get(tangent) is not None:
                raise ValueError(f"give '{tangent}' or '{angle}', not both")
            keys[tangent] = 0.0  # beside a wrong angle, of which its field tells
            if type(degrees) in (int, float) and 0 <= degrees < 90:
                keys[tangent] = math.tan(math.radians(keys.pop(angle)))
        return keys


class JointDefaults(_InDegrees):
    """Properties of every joint found, unless an exception names it.

    Raises CaseError if a value is out of range.

    Parameters
    ----------
    friction: μ = tan φ; ``inf`` for joints that cannot slide.
    cohesion: Force per unit length of joint; per unit area where the scene has a ``thickness``.
    dilatancy: tan φ₀, the opening per unit slip: 0 is Coulomb's law, ``friction`` at most, the associative.
    friction_angle, dilatancy_angle: φ and φ₀ in degrees, 0 to below 90, in place of their tangents, which are
        kept.
    dilatancy_stress: Two rising mean normal stresses ``[full, none]``, as ``strength``: up to the first the
        dilatancy is whole, then it falls linearly, to none at the second (section 6.5). Default: stress does
        not change it.
    strength: Compressive strength f_c, a force per unit length, or area, as ``cohesion``: |m| ≤ n (L/2 − n /
        (2 f_c)). Default: joints carry any pressure. (So does a corner on an edge, which has no length.)
    """

    friction: Friction
    cohesion: NonNegative = 0.0
    dilatancy: Number = 0.0
    dilatancy_stress: Stresses | None = None
    strength: Positive | None = None

    def _mistakes(self) -> Iterator[str]:
        if self.dilatancy > self.friction:
            yield "'dilatancy' must not exceed 'friction': sliding would create energy"
        if self.dilatancy_stress and not self.dilatancy_stress[0] < self.dilatancy_stress[1]:
            yield "'dilatancy_stress' needs two rising stresses: [full up to, none from]"


class Joint(_InDegrees):
    """An exception: the properties of the joint between two named blocks.

    Raises CaseError if a value is out of range.

    Parameters
    ----------
    between: Names of the two blocks; they must touch.
    friction, cohesion, dilatancy, dilatancy_stress, strength, friction_angle, dilatancy_angle: As in
        :class:`JointDefaults`; those not given keep the scene's defaults.
    """

    between: tuple[Name, Name]
    friction: Friction | None = None
    cohesion: NonNegative | None = None
    dilatancy: Number | None = None
    dilatancy_stress: Stresses | None = None
    strength: Positive | None = None

    def over(self, defaults: JointDefaults) -> JointDefaults:
        """Its properties, the rest from ``defaults``. Raises CaseError if they do not go together."""
        given = self.model_dump(exclude={"between"}, exclude_none=True)
        return JointDefaults(**(defaults.model_dump() | given))
