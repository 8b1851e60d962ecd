"""Short texts of records for the prompt of Python: at most one line, whatever a record contains."""

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import MISSING, fields, is_dataclass
from typing import Any

#: Largest number of characters of a value in the text of a record. Longer strings are cut. Other long values
#: are replaced by their class and size.
_LONGEST_VALUE = 60

#: Largest number of characters of all values together in the text of a record. Values beyond this limit are
#: replaced by "...".
_LONGEST_TEXT = 240


def brief(record: Any) -> str:
    """Return one short line of text with the class of an object and its values.

    Values that equal their defaults are left out. Arrays, tables and long lists are shown by their sizes,
    records within a record by their class. A class uses this function by ``__repr__ = brief``.
    """
    shown, length = [], 0
    for name, value in _values(record):
        text = f"{name}={_short(value)}"
        length += len(text)
        if length > _LONGEST_TEXT:
            shown.append("...")
            break
        shown.append(text)
    return f"{type(record).__name__}({', '.join(shown)})"


def _values(record: Any) -> Iterator[tuple[str, Any]]:
    """Iterate over the names and values of the fields of a record.

    Fields that have their default value, and hidden fields, are omitted.
    """
    if is_dataclass(record):
        for field in fields(record):
            value = getattr(record, field.name, None)
            is_default = field.default is not MISSING and value is field.default
            if field.repr and not is_default:
                yield field.name, value
        return
    model = getattr(type(record), "model_fields", None)
    if model is None:
        yield from ((name, value) for name, value in vars(record).items() if not name.startswith("_"))
        return
    for name in model:
        if name in record.model_fields_set and model[name].repr:
            yield name, getattr(record, name)


def _short(value: Any) -> str:
    """Return a value as text that is shortened to at most ``_LONGEST_VALUE`` characters.

    A longer string is cut. Other long values are replaced by their class and size.
    """
    shape = getattr(value, "shape", None)
    if shape:
        return f"<{type(value).__name__} of shape {shape}>"
    if is_dataclass(value) or hasattr(value, "model_fields"):
        return f"<{type(value).__name__}>"
    if isinstance(value, str):
        whole = repr(value)
        return whole if len(whole) <= _LONGEST_VALUE else repr(value[: _LONGEST_VALUE - 5] + "...")
    if isinstance(value, Sequence | Mapping | Set):
        # Only short collections of plain values are converted to text. The text of other collections, such as
        # lists of arrays, may be too long, so their class and length are shown instead.
        text = repr(value) if len(value) <= _LONGEST_VALUE and _is_plain(value) else ""
        return text if 0 < len(text) <= _LONGEST_VALUE else f"<{type(value).__name__} of {len(value)}>"
    text = repr(value)
    if len(text) > _LONGEST_VALUE or "\n" in text:
        return f"<{type(value).__name__}>"
    return text


def _is_plain(values: Any) -> bool:
    """Return True if a value, at all levels of nesting, contains only numbers, strings, booleans and None."""
    if isinstance(values, Mapping):
        return _is_plain(list(values.values()))
    if isinstance(values, list | tuple):
        return all(_is_plain(value) for value in values)
    return values is None or isinstance(values, str | int | float)
