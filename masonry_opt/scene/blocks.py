"""Blocks and published values: records that are the Python interface and the schema of case files alike."""

import itertools
from collections.abc import Iterator, Mapping
from inspect import Parameter, Signature
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self, TypeVar, get_type_hints

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, Strict, ValidationError, model_validator

from masonry_opt.errors import CaseError
from masonry_opt.scene.mistakes import called, did_you_mean, wrong_values

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass as _ModelType
else:
    _ModelType = type(BaseModel)  # the same; its name is not public

_R = TypeVar("_R", bound="Record")

#: Beyond this, squares and products of lengths and forces leave what double precision can carry.
LARGEST_NUMBER = 1e30


def _bounded(value: float) -> float:
    if not abs(value) <= LARGEST_NUMBER:
        raise ValueError(f"must be a number between -{LARGEST_NUMBER:g} and {LARGEST_NUMBER:g}")
    return value + 0.0  # no minus before a zero


Number = Annotated[float, Strict(), AfterValidator(_bounded)]
NonNegative = Annotated[Number, Field(ge=0)]
Positive = Annotated[Number, Field(gt=0)]
Point = tuple[Number, Number]
YesNo = Annotated[bool, Strict()]
#: Keys of which one takes the place of the other in a record.
INSTEAD = {
    "weight": "unit_weight",
    "unit_weight": "weight",
    "friction_angle": "friction",
    "dilatancy_angle": "dilatancy",
}
SHAPES = "'box', or 'vertices' with 'faces'"  #: What gives the shape of a convex solid.
#: Control characters, line ends, and marks that turn the direction of writing round.
_UNSEEN = r"\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff"
Name = Annotated[str, Strict(), Field(min_length=1, max_length=200, pattern=rf"^[^{_UNSEEN}]*$")]
#: What a person reads about a scene; it may have several lines.
Text = Annotated[str, Strict(), Field(max_length=2000, pattern=rf"^(?:[^{_UNSEEN}]|[\t\n\r])*$")]


def _rightward(line: list[tuple[float, float]]) -> list[tuple[float, float]]:
    for (before, _), (after, _) in itertools.pairwise(line):
        if after <= before:
            raise ValueError(f"runs from left to right: x = {after:g} comes after x = {before:g}")
    return line


RoadLine = Annotated[list[Point], Field(min_length=2), AfterValidator(_rightward)]
Ring = Annotated[list[Point], Field(min_length=3)]  #: Corners of a polygon in order.


class _Shown:
    """A record's signature, made when help asks for it: keys with their types, without what checks them."""

    def __get__(self, _: object, record: "type[Record]") -> Signature:
        kinds, shown = get_type_hints(record), []
        for name, field in record.model_fields.items():
            default = Parameter.empty if field.is_required() else field.get_default(call_default_factory=True)
            shown.append(Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=kinds[name]))
        return Signature(shown)


class _RecordType(_ModelType):
    """Metaclass of records: a call with wrong values raises CaseError; those within another make none."""

    # mypy does not know that every class of this type is a Record.
    def __call__(cls: type[_R], /, *unnamed: Any, **values: Any) -> _R:  # type: ignore[misc]
        if unnamed:
            raise CaseError(f"{cls.__name__}: give every value by its name: {', '.join(cls.model_fields)}")
        try:
            return super().__call__(**values)  # type: ignore[misc]
        except ValidationError as error:
            raise wrong_values(error, cls, values) from None

    def __dir__(cls) -> list[str]:
        """What is a record's own: help and completion leave pydantic's names out."""
        return [name for name in super().__dir__() if not (name.startswith("_") or hasattr(BaseModel, name))]


class Record(BaseModel, metaclass=_RecordType):
    """A frozen record that refuses unknown keys and finds aliases by either name. Raises CaseError, which
    names the class, the key and the remedy, if it is called with wrong values."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)

    #: Pydantic would read a record where a list is wanted as a list of its keys.
    __iter__ = None  # type: ignore[assignment]

    most_told: ClassVar[int] = 1  #: Mistakes that are told together.

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        cls.__signature__ = _Shown()  # type: ignore[assignment]

    def __dir__(self) -> list[str]:
        return [*dir(type(self)), *type(self).model_fields]

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if mistakes := list(itertools.islice(self._mistakes(), self.most_told)):
            raise ValueError("; ".join(mistakes))
        return self

    def _mistakes(self) -> Iterator[str]:
        """What is wrong with the values taken together, one sentence a rule."""
        yield from ()

    def replace(self, **changes: Any) -> Self:
        """A record with other values, checked as a call checks them; this one stays as it is.

        A mapping changes the keys of a record, or the records of a list, that it names; all else is replaced
        whole. A key that one record in it alone has needs no mapping. A value takes the place of one that it
        excludes, as ``unit_weight`` that of ``weight``.

        Raises CaseError if a call with these values would.
        """
        return type(self)(**self._with(changes))

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """A copy; with ``update`` that of :meth:`replace`."""
        copied = super().model_copy(deep=deep)
        return copied.replace(**update) if update else copied

    #: Pydantic's older name, which would check nothing.
    copy = model_copy  # type: ignore[assignment, pydantic-field]

    def _with(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """The values that were given, with changes: what a call of its class is given, by aliases."""
        fields = type(self).model_fields
        names = {field.alias: name for name, field in fields.items()}
        values = {name: getattr(self, name) for name in self.model_fields_set}
        for name, change in self._nested({names.get(key, key): changes[key] for key in changes}).items():
            other = INSTEAD.get(name, "")
            if change is not None and other not in changes:
                values.pop(other, None)
            values[name] = self._changed(name, change)
        return {(name in fields and fields[name].alias) or name: value for name, value in values.items()}

    def _nested(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Changes, those of keys that one of its records alone has within that record."""
        fields, me = type(self).model_fields, called(type(self), vars(self))
        if changes.keys() <= fields.keys():
            return changes
        within = {name: _keys(getattr(self, name)) for name in fields}
        for key in [key for key in changes if key not in fields]:
            holders = [name for name, keys in within.items() if not keys.isdisjoint({key, INSTEAD.get(key)})]
            given = changes.get(holders[0], {}) if len(holders) == 1 else None
            held = isinstance(getattr(self, holders[0]), Record) if holders else False
            if held and isinstance(given, Mapping) and key not in given:
                changes[holders[0]] = {**given, key: changes.pop(key)}
            elif holders:
                raise CaseError(f"{me}: '{key}' is a key of {' and '.join(holders)}: change it there")
            elif near := did_you_mean(key, [*fields, *itertools.chain(*within.values())]):
                raise CaseError(f"{me}: unknown key '{key}'{near}")
        return changes

    def _changed(self, name: str, change: Any) -> Any:
        """What takes the place of a value: of a mapping what it leaves of a record, or a list of them."""
        old = getattr(self, name, None)
        if not isinstance(change, Mapping):
            return change
        if isinstance(old, Record):
            return old._with(change)
        entries = old if isinstance(old, list) else []
        named = [entry.name for entry in entries if getattr(entry, "name", None)]
        if not named:
            return change
        if unknown := [key for key in change if key not in named]:
            near = did_you_mean(unknown[0], named)
            raise CaseError(f"{called(type(self), vars(self))}: '{name}' has none named '{unknown[0]}'{near}")
        new = [(entry, change.get(entry.name, entry)) for entry in entries]
        return [entry._with(own) if isinstance(own, Mapping) else own for entry, own in new]

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_"):
            raise self._stays(name, "set")
        super().__setattr__(name, value)

    def __delattr__(self, name: str) -> None:
        raise self._stays(name, "deleted")

    def _stays(self, name: str, how: str) -> CaseError:
        why = f"'{name}' cannot be {how}, a record stays as it was made"
        instead = f"replace({name}=...) makes another, and replace of a scene one with that in it"
        return CaseError(f"{called(type(self), vars(self))}: {why}: {instead}")


def _keys(value: Any) -> set[str]:
    """Keys of a record, or of records in a list those that were given."""
    if isinstance(value, Record):
        return set(type(value).model_fields)
    records = value if isinstance(value, list) and value and isinstance(value[0], Record) else []
    return {key for record in records for key in record.model_fields_set}


class Body(Record):
    """What blocks in the plane and in space have in common; the fields are those of the records below it."""

    #: Keys of its loads: what a fixed block has none of, and what does not tilt.
    LOADS: ClassVar[tuple[str, ...]] = ("live", "live_per_weight", "dead")
    dimension: ClassVar[Literal[2, 3]] = 2  #: Numbers of its points.

    if TYPE_CHECKING:
        name: str
        weight: float | None
        unit_weight: float | None
        weight_at: tuple[float, ...] | None
        live_per_weight: tuple[float, ...]
        live_at: tuple[float, ...] | None
        dead_at: tuple[float, ...] | None
        fixed: bool

    def _mistakes(self) -> Iterator[str]:
        weights = (self.weight is not None) + (self.unit_weight is not None)
        if self.fixed and any(any(getattr(self, load)) for load in self.LOADS):
            *keys, last = [f"'{load}'" for load in self.LOADS]
            yield f"a fixed block carries no load: take {', '.join(keys)} and {last} away"
        if weights == 2:
            yield "give 'weight' or 'unit_weight', not both"
        if not self.fixed and not weights:
            yield "give 'weight' or 'unit_weight' (or 'fixed = true' for a support)"
        if self.weight_at is not None and not weights:
            yield "'weight_at' needs a 'weight' or 'unit_weight'"
        for force, at in (("live", self.live_at), ("dead", self.dead_at)):
            if at is not None and not any(getattr(self, force)):
                yield f"'{force}_at' needs a force '{force}'"

    def weight_of(self, size: float) -> float:
        """Weight of the block, 0 if it has none, given what ``unit_weight`` refers to: its area or volume."""
        return (self.weight or 0.0) if self.unit_weight is None else self.unit_weight * size


class Block(Body):
    """One rigid block, or a fixed support.

    Lengths and forces are in any consistent units.

    Raises CaseError if a key is unknown, a value no finite number, or shape or weight missing or doubled.

    Parameters
    ----------
    name: Unique within the scene.
    vertices: Corners of a polygon in order, ``[[x, y], ...]``, in either direction. It may have notches.
    parts: In place of ``vertices``, several polygons that are one rigid block, each as there.
    holes: Polygons that are cut out of the block.
    weight: Dead weight, acting along the scene's gravity.
    unit_weight: In place of ``weight``: per unit area, per unit volume where the scene has a ``thickness``.
    weight_at: The point where the weight acts (default: the centroid).
    live, live_at: Live force ``[fx, fy]``, scaled by the load factor, and its point (default: the centroid).
    live_per_weight: Beside it, a live force ``[fx, fy]`` as a multiple of the weight, where the weight acts.
    dead, dead_at: Further dead force beside the weight, and the point where it acts (default: the centroid).
    fixed: A support: it does not move and needs no weight.
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
    fixed: YesNo = False

    def _mistakes(self) -> Iterator[str]:
        if (self.vertices is None) == (self.parts is None):
            yield f"give 'vertices', or 'parts' for a block of several polygons (of a solid: {SHAPES})"
        yield from super()._mistakes()

    @property
    def rings(self) -> list[list[Point]]:
        """Outlines of its parts."""
        return self.parts or [self.vertices or []]

    def corners(self) -> np.ndarray:
        """Corners of its parts, shape (corners, 2)."""
        return np.array([point for ring in self.rings for point in ring], dtype=float)


class Reference(Record):
    """A known number, with its source and the relative tolerance a computed one must meet. Reports show it as
    published, unless the source begins "by hand" or "by an independent" (computation)."""

    value: Number
    source: Text
    tolerance: Positive | None = None


def rectangle(left: float, right: float, bottom: float, top: float) -> list[tuple[float, float]]:
    """Corners of an upright rectangle, counter-clockwise from the lower left."""
    return [(left, bottom), (right, bottom), (right, top), (left, top)]
