"""What is wrong in a case file, or with the values a record is called with: one line a mistake."""

import difflib
import reprlib
from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from typing import Any, get_args

from pydantic import BaseModel, Tag, ValidationError
from pydantic.fields import FieldInfo

from masonry_opt.errors import CaseError, printable

#: Plainer words than pydantic's for what users meet most.
_MESSAGES = {
    "model_type": "must be a table of keys",
    "dict_type": "must be a table of keys",
    "list_type": "must be a list",
    "tuple_type": "must be a list of two",
    "too_short": "needs at least {min_length} entries, has {actual_length}",
    "too_long": "takes at most {max_length} entries, has {actual_length}",
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "bool_type": "must be true or false",
    "string_type": "must be text",
    "string_too_short": "must not be empty",
    "string_too_long": "must have at most {max_length} characters",
    "string_pattern_mismatch": "must not hold control characters",
    "greater_than": "must be greater than {gt}",
    "greater_than_equal": "must be {ge} or more",
    "less_than": "must be less than {lt}",
    "less_than_equal": "must be {le} or less",
    "string_unicode": "must be text of whole characters",
    "missing": "needs two numbers, [x, y]",  # of an entry; a missing key has a sentence of its own
}

#: What Python calls by other names than a case file.
_PYTHON_MESSAGES = _MESSAGES | {
    "model_type": "must be a {class_name}, or a dict of its keys",
    "dict_type": "must be a dict",
    "bool_type": "must be True or False",
    "missing": "needs two entries",
}

_MOST_LINES = 20  #: Lines of one message: more mistakes than these usually repeat the same one.
_LONGEST = 500  #: Characters of a message that quotes names.
_SHOWN = 60  #: Of one key or value.
_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = _SHOWN
#: Tags of keys that take either of two types, which pydantic names beside the keys.
_TAGS = ("<one>", "<several>", "<plane>", "<space>", "<block>", "<solid>")


def wrong_values(
    error: ValidationError, record: type[BaseModel], values: Mapping[str, Any], head: str = ""
) -> CaseError:
    """The error of wrong values, a line a mistake: a head (default: what errors call the record), and why."""
    head, mistakes = head or called(record, values), error.errors(include_url=False)
    named = _MOST_LINES - 1  # and a last line that counts the others
    lines = [_line(dict(item), record, values) for item in mistakes[:named]]
    if more := len(mistakes) - len(lines):
        lines.append(f"and {more} more mistakes")
    return CaseError("\n".join(f"{head}: {text}" for text in lines))


def called(record: type[BaseModel], values: Mapping[str, Any]) -> str:
    """What errors call a record: its title or class, and its name."""
    return f"{record.model_config.get('title') or record.__name__} {_name(values)}".rstrip()


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """What an error on an unknown name ends with, if there is one like it."""
    close = difflib.get_close_matches(name, list(known), n=1)
    return f"; did you mean '{close[0]}'?" if close else ""


def repeated(names: Iterable[str]) -> list[str]:
    """Names that there are more than once, each once."""
    return [name for name, count in Counter(names).items() if count > 1]


def _line(item: dict[str, Any], record: type[BaseModel], values: Mapping[str, Any]) -> str:
    """A mistake, with the table or the entry of a list that it is in."""
    in_file = not record.model_config.get("populate_by_name")
    loc = [part for number, part in enumerate(item["loc"]) if not number or part not in _TAGS]
    key, where = str(loc[0]) if loc else "", []
    field = _fields(record).get(key)
    alias, held = (field.alias, _held(field, item["loc"])) if field else (None, None)
    if held and len(loc) > 1 and isinstance(loc[1], int) and (in_file or alias):
        # In a file a generator may be one table or several.
        several = not in_file or isinstance(values.get(key), list)
        where, loc = [_entry(alias or key, loc[1], values.get(key)) if several else f"[{key}]"], loc[2:]
    elif in_file and (len(loc) > 1 or held):
        where, loc = [f"[{_one_line(key)}]"], loc[1:]
    elif loc:
        loc[0] = next((name for name, own in record.model_fields.items() if own.alias == key), key)
    if in_file and item["type"] == "list_type" and held and not loc:
        return f"[{key}]: write [[{key}]], with double brackets, once for each {key}"
    return ": ".join([*where, _sentence(item, loc, held or record, in_file)])


def _sentence(item: dict[str, Any], loc: list[Any], record: type[BaseModel], in_file: bool) -> str:
    """The key at ``loc`` and what is wrong with it; ``record`` has the keys to suggest."""
    kind, key, messages = item["type"], _dotted(loc), _MESSAGES if in_file else _PYTHON_MESSAGES
    if kind == "extra_forbidden":
        known = [*_fields(record)]
        near = did_you_mean(key.rsplit(".", 1)[-1], known) or f"; known: {', '.join(known)}"
        return f"unknown key '{key}'{near}"
    if kind == "missing" and len(loc) > 1 and loc[-2] == "between":
        return "key 'between': needs the names of two blocks"
    if kind == "missing" and loc and isinstance(loc[-1], int):
        of_numbers = not any(isinstance(one, str | list | tuple) for one in item["input"])
        needed = (messages if of_numbers else _PYTHON_MESSAGES)["missing"]
        return f"key '{_dotted(loc[:-1])}': {needed}"
    if kind == "missing":
        return f"missing key '{key}'" if key else "missing table"
    if kind in messages:
        message = messages[kind].format(**item.get("ctx", {}))
        if callable(getattr(item["input"], "blocks", None)):  # of a generator
            message += f": write {'*' * (kind == 'model_type')}{type(item['input']).__name__}(...).blocks()"
    else:
        message = item["msg"].removeprefix("Value error, ")
        message = message[:1].lower() + message[1:_LONGEST]
    if kind != "value_error" or key:
        message += f" (found {_shown(item['input'])})"
    return f"key '{key}': {message}" if key else message


def _entry(table: str, index: int, entries: Any) -> str:
    """An entry of a list of tables by its number and its name."""
    listed = isinstance(entries, list | tuple) and index < len(entries)
    name = _name(entries[index]) if listed else ""
    return f"{table} no. {index + 1}" + (f" ({name})" if name else "")


def _name(entry: Any) -> str:
    """The name of a block, or of the blocks of a joint or load, as it is shown; empty if there is none."""
    named = entry if isinstance(entry, Mapping) else {}
    block = named.get("block")  # of a load; elsewhere it is no text
    name = named.get("name", named.get("between", block if isinstance(block, str) else None))
    # Arrays are neither true nor false.
    return _shown(name) if not hasattr(name, "shape") and name else ""


def _shown(value: Any) -> str:
    """A value in one short line, however large or deep it is."""
    try:
        return _one_line(_SHORT.repr(value).replace("\n", " "))
    except ValueError:  # Python writes out no whole number of thousands of digits
        return "a number of thousands of digits"


def _one_line(text: str) -> str:
    """A key or value as it is shown: these are a user's own, of any length."""
    text = printable(text).replace("\n", "\\n")
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."


def _dotted(loc: list[Any]) -> str:
    parts = [f"[{part}]" if isinstance(part, int) else f".{part}" for part in loc]
    return _one_line("".join(parts).removeprefix("."))


def _fields(record: type[BaseModel]) -> dict[str, FieldInfo]:
    """A record's fields by what it is filled by: names and aliases, in a case file aliases alone."""
    by_name, fields = record.model_config.get("populate_by_name"), record.model_fields.items()
    own = {name if by_name else field.alias or name: field for name, field in fields}
    return own | {field.alias: field for _, field in fields if field.alias}


def _held(field: FieldInfo, loc: Collection[str | int]) -> type[BaseModel] | None:
    """The class of the records that a field holds, of several the one of an error's place; else None."""
    waiting: list[Any] = [field.annotation]
    found: list[tuple[bool, type[BaseModel]]] = []
    for annotation in waiting:  # which grows by the parts of each
        kind, *marks = get_args(annotation) or (annotation,)
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            found.append((any(isinstance(mark, Tag) and mark.tag in loc for mark in marks), kind))
        elif get_args(annotation):
            waiting += [kind, *marks]
    return max(found, key=lambda one: one[0])[1] if found else None
