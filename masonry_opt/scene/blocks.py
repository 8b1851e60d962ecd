"""Define blocks and published values: records of the Python interface and of case files."""

import itertools
from collections.abc import Iterator, Mapping
from inspect import Parameter, Signature
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self, TypeVar, get_type_hints

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, Strict, ValidationError, model_validator

from masonry_opt.brief import brief
from masonry_opt.errors import CaseError
from masonry_opt.scene.mistakes import called, did_you_mean, wrong_values

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass as _ModelType
else:
    _ModelType = type(BaseModel)  # the metaclass of pydantic's models, which pydantic does not export

_R = TypeVar("_R", bound="Record")

#: Largest magnitude of a number in a scene. Larger numbers raise an error, because a product of several such
#: numbers could overflow.
LARGEST_NUMBER = 1e30


def _check_bounds(value: float) -> float:
    if not abs(value) <= LARGEST_NUMBER:
        raise ValueError(f"must be a number between -{LARGEST_NUMBER:g} and {LARGEST_NUMBER:g}")
    return value + 0.0  # turns -0.0 into 0.0


Number = Annotated[float, Strict(), AfterValidator(_check_bounds)]
NonNegative = Annotated[Number, Field(ge=0)]
Positive = Annotated[Number, Field(gt=0)]
Point = tuple[Number, Number]
YesNo = Annotated[bool, Strict()]
#: Map from a key to the key that is removed when the first key is set, because both describe the same
#: property. Angles are stored as tangents, so no angle is ever removed.
EXCLUSIVE_KEYS = {
    "weight": "unit_weight",
    "unit_weight": "weight",
    "friction_angle": "friction",
    "dilatancy_angle": "dilatancy",
}
#: Keys that define the shape of a convex solid, as a phrase of error messages.
SHAPES = "'box', or 'vertices' with 'faces'"
#: Characters that names must not contain, as a character class of a regular expression: control characters,
#: line ends, and marks that change the direction of writing. In a ``Text``, only tabs and line ends among
#: these characters are allowed.
_INVISIBLE = r"\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff"
Name = Annotated[str, Strict(), Field(min_length=1, max_length=200, pattern=rf"^[^{_INVISIBLE}]*$")]
#: Type of a text that may have several lines, such as the title of a scene.
Text = Annotated[str, Strict(), Field(max_length=2000, pattern=rf"^(?:[^{_INVISIBLE}]|[\t\n\r])*$")]


def _check_left_to_right(line: list[tuple[float, float]]) -> list[tuple[float, float]]:
    for (previous_x, _), (next_x, _) in itertools.pairwise(line):
        if next_x <= previous_x:
            raise ValueError(f"must run from left to right, but x = {next_x:g} follows x = {previous_x:g}")
    return line


RoadLine = Annotated[list[Point], Field(min_length=2), AfterValidator(_check_left_to_right)]
Ring = Annotated[list[Point], Field(min_length=3)]  #: Corners of a polygon in order.


class _SignatureDescriptor:
    """Descriptor that returns the call signature of a record class: its keys, their types and defaults.

    The signature omits the validators of the types. It is built only when it is requested, for example by
    ``help``.
    """

    def __get__(self, _: object, record: "type[Record]") -> Signature:
        kinds = get_type_hints(record)
        parameters = []
        for name, field in record.model_fields.items():
            default = Parameter.empty if field.is_required() else field.get_default(call_default_factory=True)
            parameters.append(
                Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=kinds[name])
            )
        return Signature(parameters)


class _RecordType(_ModelType):
    """Metaclass that raises CaseError if a record is created with invalid values.

    If pydantic creates a record inside another record, only the outer record raises the error.
    """

    # Ignore the type error: mypy does not know that this metaclass creates only Record and its subclasses.
    def __call__(cls: type[_R], /, *arguments: Any, **values: Any) -> _R:  # type: ignore[misc]
        if arguments:
            names = ", ".join(cls.model_fields)
            raise CaseError(f"{cls.__name__}: every argument must be given by its name, one of: {names}")
        try:
            return super().__call__(**values)  # type: ignore[misc]
        except ValidationError as error:
            raise wrong_values(error, cls, values) from None

    def __dir__(cls) -> list[str]:
        """List the attributes of a record class for help and completion, without attributes of pydantic."""
        return [name for name in super().__dir__() if not (name.startswith("_") or hasattr(BaseModel, name))]


class Record(BaseModel, metaclass=_RecordType):
    """Immutable record that rejects unknown keys and accepts each key by its name or its alias.

    A call with invalid values raises CaseError. The message names the class, the key and the remedy.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)

    #: Records are not iterable, because pydantic would accept an iterable record in place of a list.
    __iter__ = None  # type: ignore[assignment]

    most_listed_mistakes: ClassVar[int] = 1  #: Largest number of mistakes that one error message lists.

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        cls.__signature__ = _SignatureDescriptor()  # type: ignore[assignment]

    __repr__ = brief
    __str__ = brief

    def __dir__(self) -> list[str]:
        return [*dir(type(self)), *type(self).model_fields]

    @model_validator(mode="after")
    def _check_consistency(self) -> Self:
        mistakes = list(itertools.islice(self._mistakes(), self.most_listed_mistakes))
        if mistakes:
            raise ValueError("; ".join(mistakes))
        return self

    def _mistakes(self) -> Iterator[str]:
        """Generate an error message for each violated rule that involves several keys."""
        yield from ()

    def replace(self, **changes: Any) -> Self:
        """Return a copy of the record with changed values, which are validated.

        A mapping changes only the keys of a record, or the records of a list, that it names. Any other value
        replaces the whole old value. A key that only one nested record has can be given without a mapping. A
        new value removes the value that it excludes: ``unit_weight`` removes ``weight``.

        Returns
        -------
        Record
            A new record of the same class.

        Raises
        ------
        CaseError
            If a key is unknown or ambiguous, or if a value is not valid.
        """
        return type(self)(**self._values_with(changes))

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy of the record with the changes in ``update``, as :meth:`replace` does."""
        record = super().model_copy(deep=deep)
        return record.replace(**update) if update else record

    #: Override pydantic's older method ``copy``, because it does not validate changed values.
    copy = model_copy  # type: ignore[assignment, pydantic-field]

    def _values_with(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """Apply changes to the values of the record, and return all values as keyword arguments.

        A field that has an alias is named by its alias.
        """
        fields = type(self).model_fields
        names = {field.alias: name for name, field in fields.items()}
        values = {name: getattr(self, name) for name in self.model_fields_set}
        for name, change in self._nest_changes(
            {names.get(key, key): changes[key] for key in changes}
        ).items():
            excluded_key = EXCLUSIVE_KEYS.get(name, "")
            if change is not None and excluded_key not in changes:
                values.pop(excluded_key, None)
            values[name] = self._changed_value(name, change)
        return {(name in fields and fields[name].alias) or name: value for name, value in values.items()}

    def _nest_changes(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the changes, with the keys of each nested record collected in one mapping.

        For example, ``friction=0.6`` becomes ``joints={"friction": 0.6}`` in a scene. Raises CaseError in
        these cases:

        - The key belongs to several records or to a list of records.
        - The changes replace the nested record, or already change its key.
        - An unknown key resembles a known key.
        """
        fields = type(self).model_fields
        own_name = called(type(self), vars(self))
        if changes.keys() <= fields.keys():
            return changes
        nested_keys = {name: _record_keys(getattr(self, name)) for name in fields}
        for key in [key for key in changes if key not in fields]:
            holders = [
                name
                for name, keys in nested_keys.items()
                if not keys.isdisjoint({key, EXCLUSIVE_KEYS.get(key)})
            ]
            nested_changes = changes.get(holders[0], {}) if len(holders) == 1 else None
            in_record = isinstance(getattr(self, holders[0]), Record) if holders else False
            if in_record and isinstance(nested_changes, Mapping) and key not in nested_changes:
                changes[holders[0]] = {**nested_changes, key: changes.pop(key)}
            elif holders:
                owners = " and ".join(holders)
                raise CaseError(
                    f"{own_name}: '{key}' is a key of {owners}: "
                    "change it in a mapping, such as joints={'friction': 0.6} or blocks={'A': {'weight': 3}}"
                )
            else:
                suggestion = did_you_mean(key, [*fields, *itertools.chain(*nested_keys.values())])
                if suggestion:
                    raise CaseError(f"{own_name}: unknown key '{key}'{suggestion}")
        return changes

    def _changed_value(self, name: str, change: Any) -> Any:
        """Return the new value of a key.

        If the old value is a record or a list of named records, a mapping changes only the keys or records
        that it names.
        """
        old_value = getattr(self, name, None)
        if not isinstance(change, Mapping):
            return change
        if isinstance(old_value, Record):
            return old_value._values_with(change)
        entries = old_value if isinstance(old_value, list) else []
        names = [entry.name for entry in entries if getattr(entry, "name", None)]
        if not names:
            return change
        unknown_names = [key for key in change if key not in names]
        if unknown_names:
            suggestion = did_you_mean(unknown_names[0], names)
            own_name = called(type(self), vars(self))
            raise CaseError(f"{own_name}: '{name}' has no record named '{unknown_names[0]}'{suggestion}")
        entry_changes = [(entry, change.get(entry.name, entry)) for entry in entries]
        return [
            entry._values_with(entry_change) if isinstance(entry_change, Mapping) else entry_change
            for entry, entry_change in entry_changes
        ]

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_"):
            raise self._immutability_error(name, "set")
        super().__setattr__(name, value)

    def __delattr__(self, name: str) -> None:
        raise self._immutability_error(name, "deleted")

    def _immutability_error(self, name: str, action: str) -> CaseError:
        """Return the error for an attempt to change an attribute of a record, which is immutable."""
        own_name = called(type(self), vars(self))
        return CaseError(
            f"{own_name}: '{name}' cannot be {action}, because records are immutable: "
            f"use replace({name}=...), which returns a changed copy"
        )


def _record_keys(value: Any) -> set[str]:
    """Return all keys of a record or, for a list of records, the keys that are set in at least one of them.

    The set is empty for any other value.
    """
    if isinstance(value, Record):
        return set(type(value).model_fields)
    records = value if isinstance(value, list) and value and isinstance(value[0], Record) else []
    return {key for record in records for key in record.model_fields_set}


class Body(Record):
    """Base class of blocks in the plane and in space, with the fields and rules that both share."""

    #: Keys of the loads on a block. Fixed blocks and blocks of a tilted scene must not have these keys.
    LOADS: ClassVar[tuple[str, ...]] = ("live", "live_per_weight", "dead")
    dimension: ClassVar[Literal[2, 3]] = 2  #: Number of coordinates of a point.

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
            yield f"a fixed block must have no loads: remove {', '.join(keys)} and {last}"
        if weights == 2:
            yield "a block cannot have both 'weight' and 'unit_weight': remove one of the two keys"
        if not self.fixed and not weights:
            yield "a movable block needs 'weight' or 'unit_weight' (a support needs 'fixed = true')"
        if self.weight_at is not None and not weights:
            yield "'weight_at' needs a 'weight' or 'unit_weight'"
        for force, at in (("live", self.live_at), ("dead", self.dead_at)):
            if at is not None and not any(getattr(self, force)):
                yield f"'{force}_at' needs a force '{force}'"

    def weight_of(self, size: float) -> float:
        """Return the weight of the block, or 0 if it has no weight.

        ``size`` is the area or volume to which ``unit_weight`` refers.
        """
        if self.unit_weight is not None:
            return self.unit_weight * size
        return self.weight or 0.0


class Block(Body):
    """Rigid block in the plane, or a fixed support.

    Lengths and forces are in any consistent units.

    Parameters
    ----------
    name: Name of the block, unique within the scene.
    vertices: Corners of a polygon in order, ``[[x, y], ...]``, clockwise or counter-clockwise. The polygon
        may have notches.
    parts: In place of ``vertices``, several such polygons that are one rigid block.
    holes: Polygons that are cut out of the block.
    weight: Weight of the block, a dead load along the scene's gravity.
    unit_weight: In place of ``weight``: weight per unit area, or per unit volume if the scene has a
        ``thickness``.
    weight_at: Point of application of the weight (default: the centroid).
    live, live_at: Live force ``[fx, fy]``, which the load factor multiplies, and its point of application
        (default: the centroid).
    live_per_weight: Further live force ``[fx, fy]`` as a multiple of the weight, applied at the same point as
        the weight.
    dead, dead_at: Dead force in addition to the weight, and its point of application (default: the centroid).
    fixed: True for a support, which does not move and needs no weight.

    Raises
    ------
    CaseError
        If a key is unknown, if a value is not a finite number, or if the shape or the weight is missing or
        given twice.
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
            yield f"a block needs 'vertices', or 'parts' if it has several polygons (a solid needs {SHAPES})"
        yield from super()._mistakes()

    @property
    def rings(self) -> list[list[Point]]:
        """Return the outlines of the parts of the block."""
        return self.parts or [self.vertices or []]

    def corners(self) -> np.ndarray:
        """Return the corners of all parts of the block, shape (corners, 2)."""
        return np.array([point for ring in self.rings for point in ring], dtype=float)


class Reference(Record):
    """Published load factor with its source.

    A computed load factor agrees with the published value if their relative difference is within
    ``tolerance``. Reports call the value published, unless its source begins with "by hand" or "by an
    independent" (computation).

    Parameters
    ----------
    value: The published load factor.
    source: Publication or computation from which the value is taken.
    tolerance: Largest relative difference of a load factor that agrees with the value.

    Raises
    ------
    CaseError
        If a value is not a finite number, or if the tolerance is not positive.
    """

    value: Number
    source: Text
    tolerance: Positive | None = None


def rectangle(left: float, right: float, bottom: float, top: float) -> list[tuple[float, float]]:
    """Return the corners of a rectangle with sides along the axes, counter-clockwise from the lower left."""
    return [(left, bottom), (right, bottom), (right, top), (left, top)]
