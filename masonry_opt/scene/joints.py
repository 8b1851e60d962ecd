"""Define joint properties: defaults for all joints of a scene, and exceptions for pairs of blocks."""

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Field, PlainSerializer, Strict, model_validator

from masonry_opt.scene.blocks import Name, NonNegative, Number, Positive, Record

#: Largest finite friction coefficient. A larger finite coefficient is refused, because rounding errors would
#: dominate the friction conditions.
LARGEST_FRICTION = 1e6


def _check_friction(value: float) -> float:
    if not value >= 0:
        raise ValueError("must be zero or more")
    if LARGEST_FRICTION < value < math.inf:
        raise ValueError("is too large for a friction coefficient: write inf for a joint that cannot slide")
    return value + 0.0


Stresses = tuple[NonNegative, NonNegative]
Angle = Annotated[float, Strict(), Field(ge=0, lt=90)]
#: Friction coefficient tan φ; ``inf`` (in JSON the string "inf") for a joint that cannot slide.
Friction = Annotated[
    float,
    Strict(),
    BeforeValidator(lambda value: math.inf if isinstance(value, str) and value == "inf" else value),
    AfterValidator(_check_friction),
    PlainSerializer(lambda value: "inf" if math.isinf(value) else value, when_used="json"),
]


class _InDegrees(Record):
    """Base class of joint properties: converts friction and dilatancy angles to their tangents."""

    friction_angle: Angle | None = Field(default=None, exclude=True, repr=False)
    dilatancy_angle: Angle | None = Field(default=None, exclude=True, repr=False)

    @model_validator(mode="before")
    @classmethod
    def _convert_angles(cls, data: Any) -> Any:
        if not isinstance(data, Mapping):
            return data
        keys = dict(data)
        for tangent in ("friction", "dilatancy"):
            angle = f"{tangent}_angle"
            degrees = keys.get(angle)
            if degrees is None:
                continue
            if keys.get(tangent) is not None:
                raise ValueError(f"give '{tangent}' or '{angle}', not both")
            # Placeholder, so that an error message about a wrong angle does not also report a missing
            # tangent.
            keys[tangent] = 0.0
            if type(degrees) in (int, float) and 0 <= degrees < 90:
                keys[tangent] = math.tan(math.radians(keys.pop(angle)))
        return keys


class JointDefaults(_InDegrees):
    """Default properties of the joints of a scene; a :class:`Joint` record overrides them for one joint.

    Parameters
    ----------
    friction: Friction coefficient μ = tan φ; ``inf`` for joints that cannot slide.
    cohesion: Force per unit length of joint, or per unit area if the scene has a ``thickness``.
    dilatancy: tan φ₀, the opening per unit slip. 0 is Coulomb's law; the largest value, ``friction``, is the
        associative law.
    friction_angle, dilatancy_angle: φ and φ₀ in degrees, from 0 to below 90, in place of their tangents. The
        record stores the tangents.
    dilatancy_stress: Two rising mean normal stresses ``[full, none]``, in the units of ``strength`` (section
        6.5 of the paper). Up to the first stress the dilatancy is full, then it decreases linearly to zero at
        the second stress. Default: dilatancy does not depend on stress.
    strength: Compressive strength f_c, a force per unit length, or per unit area, as ``cohesion``: |m| ≤ n
        (L/2 − n / (2 f_c)). Default: unlimited. The contact of a corner with an edge, which has no length,
        also has unlimited strength.

    Raises
    ------
    CaseError
        If a value is out of range.
    """

    friction: Friction
    cohesion: NonNegative = 0.0
    dilatancy: Number = 0.0
    dilatancy_stress: Stresses | None = None
    strength: Positive | None = None

    def _mistakes(self) -> Iterator[str]:
        if self.dilatancy > self.friction:
            yield "'dilatancy' must not exceed 'friction', because sliding would create energy"
        if self.dilatancy_stress and not self.dilatancy_stress[0] < self.dilatancy_stress[1]:
            yield (
                "'dilatancy_stress' must be two increasing stresses: "
                "the dilatancy is full up to the first stress and zero above the second stress"
            )


class Joint(_InDegrees):
    """Properties that override the defaults for the joint between two named blocks.

    Parameters
    ----------
    between: Names of the two blocks; they must touch.
    friction, cohesion, dilatancy, dilatancy_stress, strength, friction_angle, dilatancy_angle: As in
        :class:`JointDefaults`. A property that is not given has the default value of the scene.

    Raises
    ------
    CaseError
        If a value is out of range.
    """

    between: tuple[Name, Name]
    friction: Friction | None = None
    cohesion: NonNegative | None = None
    dilatancy: Number | None = None
    dilatancy_stress: Stresses | None = None
    strength: Positive | None = None

    def over(self, defaults: JointDefaults) -> JointDefaults:
        """Return ``defaults``, overridden by the properties that this joint sets.

        Parameters
        ----------
        defaults: Properties of the joints of the scene.

        Returns
        -------
        JointDefaults
            The properties of this joint.

        Raises
        ------
        CaseError
            If the resulting properties are inconsistent.
        """
        overrides = self.model_dump(exclude={"between"}, exclude_none=True)
        return JointDefaults(**(defaults.model_dump() | overrides))
