"""What a scene is made of: blocks, joint properties and published reference values.

The same classes are the Python interface and the schema of the case file, so that an
unknown key or a wrong type is refused alike in both.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainSerializer,
    Strict,
    StringConstraints,
    ValidationError,
    model_validator,
)

from masonry_opt.errors import CaseError
from masonry_opt.scene.angles import InDegrees
from masonry_opt.scene.mistakes import wrong_call

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass as _ModelType
else:
    _ModelType = type(BaseModel)  # the same; its name is not public

_R = TypeVar("_R", bound="Record")

#: Beyond this, squares and products of lengths and forces leave what double precision can carry.
LARGEST_NUMBER = 1e30

#: Blocks, openings and gaps that a generator builds: more than can be solved, and soon built.
MOST_BLOCKS = 100_000

#: Beyond this a friction row is nothing but rounding.
LARGEST_FRICTION = 1e6


def _bounded(value: float) -> float:
    if not abs(value) <= LARGEST_NUMBER:
        raise ValueError(f"must be a number between -{LARGEST_NUMBER:g} and {LARGEST_NUMBER:g}")
    return value + 0.0  # no minus before a zero


def _unlimited(value: object) -> object:
    return math.inf if isinstance(value, str) and value == "inf" else value


def _friction(value: float) -> float:
    if not value >= 0:
        raise ValueError("must be zero or more")
    if LARGEST_FRICTION < value < math.inf:
        raise ValueError("is too large to be a friction: write inf for a joint that cannot slide")
    return value + 0.0


Number = Annotated[float, Strict(), AfterValidator(_bounded)]
NonNegative = Annotated[Number, Field(ge=0)]
Positive = Annotated[Number, Field(gt=0)]
Point = tuple[Number, Number]
Stresses = tuple[NonNegative, NonNegative]
#: tan φ; ``inf`` (in JSON the string "inf") for a joint that cannot slide.
Friction = Annotated[
    float,
    Strict(),
    BeforeValidator(_unlimited),
    AfterValidator(_friction),
    PlainSerializer(lambda v: "inf" if math.isinf(v) else v, when_used="json"),
]
#: Control characters, line ends, and marks that turn the direction of writing round.
_UNSEEN = r"\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff"
Name = Annotated[str, Strict(), StringConstraints(min_length=1, max_length=200, pattern=rf"^[^{_UNSEEN}]*$")]
#: What a person reads about a scene; it may have several lines.
Text = Annotated[str, Strict(), StringConstraints(max_length=2000, pattern=rf"^(?:[^{_UNSEEN}]|[\t\n\r])*$")]


#: Corners of a polygon in order.
Ring = Annotated[list[Point], Field(min_length=3)]


class _RecordType(_ModelType):
    """The class of records, which tells what is wrong when one is called in Python.

    Records inside another, or in a case file, are validated by pydantic, which does not call them: what is
    wrong with them is told once, with the whole.
    """

    # mypy does not know that every class of this type is a Record.
    def __call__(cls: type[_R], /, *unnamed: Any, **values: Any) -> _R:  # type: ignore[misc]
        if unnamed:
            raise CaseError(f"{cls.__name__}: give every value by its name: {', '.join(cls.model_fields)}")
        try:
            return super().__call__(**values)  # type: ignore[misc]
        except ValidationError as error:
            raise wrong_call(error, cls, values) from None


class Record(BaseModel, metaclass=_RecordType):
    """A frozen record that refuses unknown keys and finds aliases by either name.

    Raises
    ------
    CaseError
        If it is called with values that are wrong; the message names the class, the key and the remedy.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)


class Block(Record):
    """One rigid block, or a fixed support.

    Lengths and forces are in any consistent units.

    Parameters
    ----------
    name:
        Unique within the scene.
    vertices:
        Corners of a polygon in order, ``[[x, y], ...]``; clockwise order is turned round. It may have
        notches.
    parts:
        In place of ``vertices``, several polygons that are one rigid block, each as there.
    holes:
        Polygons that are cut out of the block.
    weight:
        Dead weight, acting along the scene's gravity.
    unit_weight:
        Weight per unit area, in place of ``weight``; per unit volume where the scene has a ``thickness``.
    weight_at:
        The point where the weight acts (default: the centroid).
    live, live_at:
        Live force ``[fx, fy]`` (scaled by the load factor) and the point where it acts
        (default: the centroid).
    live_per_weight:
        Beside it, a live force as a multiple of the block's weight, ``[fx, fy]``, where the weight acts.
    dead, dead_at:
        Further dead force beside the weight, and the point where it acts (default: the centroid).
    fixed:
        A support: it does not move and needs no weight.

    Raises
    ------
    CaseError
        If a key is unknown, a value is no finite number, or shape or weight are missing or doubled.
    """

    name: Name
    vertices: Ring | None = None
    parts: Annotated[list[Ring], Field(min_length=1)] | None = None
    holes: list[Ring] = []
    weight: NonNegative | None = None
    unit_weight: NonNegative | None = None
    weight_at: Point | None = None
    live: Point = (0.0, 0.0)
    live_at: Point | None = None
    live_per_weight: Point = (0.0, 0.0)
    dead: Point = (0.0, 0.0)
    dead_at: Point | None = None
    fixed: Annotated[bool, Strict()] = False

    @model_validator(mode="after")
    def _one_shape(self) -> Block:
        if (self.vertices is None) == (self.parts is None):
            raise ValueError("give 'vertices', or 'parts' for a block of several polygons")
        return self

    @model_validator(mode="after")
    def _one_weight(self) -> Block:
        if self.fixed and any(map(any, (self.live, self.live_per_weight, self.dead))):
            raise ValueError("a fixed block carries no load: take 'live', 'live_per_weight' and 'dead' away")
        if self.weight is not None and self.unit_weight is not None:
            raise ValueError("give 'weight' or 'unit_weight', not both")
        if not self.fixed and self.weight is None and self.unit_weight is None:
            raise ValueError("give 'weight' or 'unit_weight' (or 'fixed = true' for a support)")
        if self.weight_at is not None and self.weight is None and self.unit_weight is None:
            raise ValueError("'weight_at' needs a 'weight' or 'unit_weight'")
        for force, at in (("live", self.live_at), ("dead", self.dead_at)):
            if at is not None and not any(getattr(self, force)):
                raise ValueError(f"'{force}_at' needs a force '{force}'")
        return self

    def weight_of(self, size: float) -> float:
        """Weight of the block, given what ``unit_weight`` is the weight of: the area of its polygon, or its
        volume; 0 for a support without one."""
        if self.unit_weight is not None:
            return self.unit_weight * size
        return 0.0 if self.weight is None else self.weight

    @property
    def rings(self) -> list[list[Point]]:
        """Outlines of its parts."""
        return self.parts or [self.vertices or []]

    def corners(self) -> np.ndarray:
        """Corners of its parts, shape (corners, 2)."""
        return np.array([point for ring in self.rings for point in ring], dtype=float)


class JointDefaults(InDegrees, Record):
    """Properties of every joint found, unless an exception names it.

    Parameters
    ----------
    friction:
        μ = tan φ; ``inf`` for joints that cannot slide.
    cohesion:
        Force per unit length of joint; per unit area where the scene has a ``thickness``.
    dilatancy:
        tan φ₀, the opening per unit slip; 0 is Coulomb's law, ``friction`` the associative one.
    friction_angle, dilatancy_angle:
        φ and φ₀ in degrees, in place of their tangents, which are what is kept.
    dilatancy_stress:
        Mean normal stresses ``[full, none]`` (force per unit length, or area, as cohesion): up to the
        first the dilatancy is whole, from the second there is none, in between it falls linearly
        (section 6.5). Default: the dilatancy does not depend on stress.
    strength:
        Compressive strength f_c, as force per unit length, or area, as cohesion: |m| ≤ n (L/2 − n / (2 f_c)).
        Default: joints carry any pressure. (A corner on an edge has no length for it to act on, and carries
        any.)

    Raises
    ------
    CaseError
        If friction or cohesion is negative, dilatancy exceeds friction, or the stresses do not rise.
    """

    friction: Friction
    cohesion: NonNegative = 0.0
    dilatancy: Number = 0.0
    dilatancy_stress: Stresses | None = None
    strength: Positive | None = None

    @model_validator(mode="after")
    def _dissipative(self) -> JointDefaults:
        if self.dilatancy > self.friction:
            raise ValueError("'dilatancy' must not exceed 'friction': sliding would create energy")
        if self.dilatancy_stress and not self.dilatancy_stress[0] < self.dilatancy_stress[1]:
            raise ValueError("'dilatancy_stress' needs two rising stresses: [full up to, none from]")
        return self


class Joint(InDegrees, Record):
    """An exception: the properties of the joint between two named blocks.

    Parameters
    ----------
    between:
        Names of the two blocks; they must touch.
    friction, cohesion, dilatancy, dilatancy_stress, strength, friction_angle, dilatancy_angle:
        As in :class:`JointDefaults`; those not given keep the scene's defaults.

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
        """The joint's properties: those given here, the rest from ``defaults``.

        Raises CaseError if the two together are not admissible.
        """
        given = self.model_dump(exclude={"between"}, exclude_none=True)
        return JointDefaults(**(defaults.model_dump() | given))


class Reference(Record):
    """A known number, with its source and the relative tolerance a computed one must meet.

    Reports show it as published, unless the source begins "by hand" or "by an independent" (computation).
    """

    value: Number
    source: Text
    tolerance: Positive | None = None


def rectangle(left: float, right: float, bottom: float, top: float) -> list[tuple[float, float]]:
    """Corners of an upright rectangle, counter-clockwise from the lower left."""
    return [(left, bottom), (right, bottom), (right, top), (left, top)]
