"""Write the errors of wrong values in case files and in Python, one line for each mistake."""

import difflib
import functools
import inspect
import reprlib
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any, ParamSpec, TypeVar, get_args

from pydantic import BaseModel, Tag, ValidationError
from pydantic.fields import FieldInfo

from masonry_opt.errors import CaseError, OptionError, printable, remainder

P = ParamSpec("P")
R = TypeVar("R")

#: Messages for the most frequent mistakes, by pydantic's error type. They replace pydantic's own messages,
#: which are harder to understand.
_MESSAGES = {
    "model_type": "must be a table of keys",
    "dict_type": "must be a table of keys",
    "list_type": "must be a list",
    "tuple_type": "must be a list of two",
    "too_short": "must have at least {min_length} entries, but has {actual_length}",
    "too_long": "must have at most {max_length} entries, but has {actual_length}",
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "bool_type": "must be true or false",
    "string_type": "must be text",
    "string_too_short": "must not be empty",
    "string_too_long": "must have at most {max_length} characters",
    "string_pattern_mismatch": "must not contain control characters",
    "greater_than": "must be greater than {gt}",
    "greater_than_equal": "must be {ge} or more",
    "less_than": "must be less than {lt}",
    "less_than_equal": "must be {le} or less",
    "string_unicode": "must be text of whole characters",
    # Message for a list that lacks an entry. A missing key has a different message.
    "missing": "needs two numbers, [x, y]",
}

#: Messages for values passed in Python, whose types have other names than in a case file.
_PYTHON_MESSAGES = _MESSAGES | {
    "model_type": "must be a {class_name}, or a dict with the keys of a {class_name}",
    "dict_type": "must be a dict",
    "bool_type": "must be True or False",
    "missing": "needs two entries",
}

#: Largest number of lines in one error message. The last line counts the mistakes that are left out, which
#: usually repeat earlier mistakes.
_MOST_MESSAGE_LINES = 20

#: Largest number of characters of an error message that quotes names. A longer message is cut off.
_LONGEST_MESSAGE = 500

#: Largest number of characters of a quoted key or value in an error message. The middle of a longer
#: quotation is left out.
_LONGEST_QUOTE = 60

#: Formatter that shortens the text representation of long values.
_SHORT_REPR = reprlib.Repr()
_SHORT_REPR.maxstring = _LONGEST_QUOTE
_SHORT_REPR.maxother = _LONGEST_QUOTE
_SHORT_REPR.maxlong = _LONGEST_QUOTE

#: Tags that pydantic adds to the location of an error if a value may have several types. Error messages omit
#: the tags.
_TAGS = ("<one>", "<several>", "<plane>", "<space>", "<block>", "<solid>")


def wrong_values(
    error: ValidationError, record: type[BaseModel], values: Mapping[str, Any], head: str = ""
) -> CaseError:
    """Return the CaseError for invalid values, with one line for each mistake.

    Each line begins with ``head``. The default is the name of the record.
    """
    head, mistakes = head or called(record, values), _drop_misspelt(error.errors(include_url=False))
    most_mistakes = _MOST_MESSAGE_LINES - 1  # the last line counts the others
    lines = [_line(dict(item), record, values) for item in mistakes[:most_mistakes]]
    lines += filter(None, [remainder(len(mistakes), most_mistakes, "mistake")])
    return CaseError("\n".join(f"{head}: {text}" for text in lines))


def _drop_misspelt(mistakes: Sequence[Any]) -> list[Any]:
    """Return all mistakes, except missing keys that the file probably contains with a misspelt name.

    A missing key is probably misspelt if its table has an unknown key with a similar name. The message about
    the unknown key suggests the missing key.
    """
    unknown_keys = [item["loc"] for item in mistakes if item["type"] == "extra_forbidden"]

    def is_misspelt(loc: tuple[str | int, ...]) -> bool:
        """Return True if the table of a missing key has an unknown key with a similar name."""
        names = [str(key_path[-1]) for key_path in unknown_keys if key_path[:-1] == loc[:-1]]
        return bool(loc) and any(did_you_mean(name, [str(loc[-1])]) for name in names)

    return [item for item in mistakes if item["type"] != "missing" or not is_misspelt(item["loc"])]


def called(record: type[BaseModel], values: Mapping[str, Any]) -> str:
    """Return the name of a record for error messages: the title or name of its class, and its own name."""
    return f"{record.model_config.get('title') or record.__name__} {_entry_name(values)}".rstrip()


def did_you_mean(name: str, known_names: Iterable[str]) -> str:
    """Return a clause that suggests a known name similar to an unknown name, or an empty text.

    The comparison ignores upper and lower case.
    """
    by_lower_case = {entry.lower(): entry for entry in known_names}
    matches = difflib.get_close_matches(name.lower(), by_lower_case, n=1)
    return f"; did you mean '{by_lower_case[matches[0]]}'?" if matches else ""


def keyword_arguments(function: Callable[..., object]) -> tuple[str, ...]:
    """Return the names of all arguments that a function accepts by name, without its ``**options``."""
    parameters = inspect.signature(function).parameters.values()
    return tuple(parameter.name for parameter in parameters if parameter.kind is not parameter.VAR_KEYWORD)


def suggests_arguments(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate a function: a call with an unknown argument raises OptionError and suggests a similar name."""
    known_names = [name for name in keyword_arguments(function) if name != "self"]

    @functools.wraps(function)
    def checked(*args: P.args, **kwargs: P.kwargs) -> R:
        for name in kwargs:
            if name not in known_names:
                suggestion = did_you_mean(name, known_names) or f"; it has: {', '.join(known_names)}"
                raise OptionError(f"'{function.__name__}' has no argument '{name}'{suggestion}")
        return function(*args, **kwargs)

    return checked


def instead_of(name: object, known_names: Iterable[str]) -> str:
    """Return a clause that suggests a valid name similar to ``name``, if any, and lists all valid names."""
    names = [*known_names]
    suggestion = did_you_mean(str(name), names)
    name_list = ", ".join(names)
    return f"{suggestion} Choose from: {name_list}" if suggestion else f"; choose from: {name_list}"


def repeated(names: Iterable[str]) -> list[str]:
    """Return the names that occur more than once, each name once."""
    return [name for name, count in Counter(names).items() if count > 1]


def _line(item: dict[str, Any], record: type[BaseModel], values: Mapping[str, Any]) -> str:
    """Return the message about one mistake. It begins with the name of the table or list entry."""
    in_file = not record.model_config.get("populate_by_name")
    loc = [part for number, part in enumerate(item["loc"]) if not number or part not in _TAGS]
    key = str(loc[0]) if loc else ""
    labels: list[str] = []
    field = _fields(record).get(key)
    alias = field.alias if field else None
    nested_record = _record_class(field, item["loc"]) if field else None
    if nested_record and len(loc) > 1 and isinstance(loc[1], int) and (in_file or alias):
        # In a case file, a generator may be a single table instead of a list of tables. The message then has
        # no entry number.
        is_list = not in_file or isinstance(values.get(key), list)
        labels = [_entry(alias or key, loc[1], values.get(key)) if is_list else f"[{key}]"]
        loc = loc[2:]
    elif in_file and (len(loc) > 1 or nested_record):
        labels = [f"[{one_line(key)}]"]
        loc = loc[1:]
    elif loc:
        loc[0] = next(
            (name for name, field_info in record.model_fields.items() if field_info.alias == key), key
        )
    if in_file and item["type"] == "list_type" and nested_record and not loc:
        return f"[{key}] needs double brackets: write [[{key}]] once for each {key}"
    return ": ".join([*labels, _sentence(item, loc, nested_record or record, in_file)])


def _sentence(item: dict[str, Any], loc: list[Any], record: type[BaseModel], in_file: bool) -> str:
    """Return the message about one mistake; ``loc`` is the path of the wrong key.

    ``record`` is the class whose keys the message may suggest.
    """
    kind = item["type"]
    key = _dotted_path(loc)
    messages = _MESSAGES if in_file else _PYTHON_MESSAGES
    if kind == "extra_forbidden":
        known_keys = [*_fields(record)]
        suggestion = did_you_mean(key.rsplit(".", 1)[-1], known_keys) or f"; known: {', '.join(known_keys)}"
        return f"unknown key '{key}'{suggestion}"
    if kind == "missing" and len(loc) > 1 and loc[-2] == "between":
        return "key 'between': needs the names of two blocks"
    if kind == "missing" and loc and isinstance(loc[-1], int):
        is_numeric = not any(isinstance(entry, str | list | tuple) for entry in item["input"])
        requirement = (messages if is_numeric else _PYTHON_MESSAGES)["missing"]
        return f"key '{_dotted_path(loc[:-1])}': {requirement}"
    if kind == "missing":
        return f"missing key '{key}'" if key else "missing table"
    if kind in messages:
        message = messages[kind].format(**item.get("ctx", {}))
        if callable(getattr(item["input"], "blocks", None)):  # the value is a generator
            message += f": write {'*' * (kind == 'model_type')}{type(item['input']).__name__}(...).blocks()"
    else:
        message = item["msg"].removeprefix("Value error, ")
        message = message[:1].lower() + message[1:_LONGEST_MESSAGE]
    if kind != "value_error" or key:
        message += f" (found {_short_text(item['input'])})"
    return f"key '{key}': {message}" if key else message


def _entry(table: str, index: int, entries: Any) -> str:
    """Return the number and the name of an entry in a list of tables, for an error message."""
    has_entry = isinstance(entries, list | tuple) and index < len(entries)
    name = _entry_name(entries[index]) if has_entry else ""
    return f"{table} no. {index + 1}" + (f" ({name})" if name else "")


def _entry_name(entry: Any) -> str:
    """Return the text that identifies an entry: its name or the names of its blocks, or an empty text."""
    keys = entry if isinstance(entry, Mapping) else {}
    # In a load, the value of "block" is the name of the loaded block. A value that is not text is not a name.
    block = keys.get("block")
    name = keys.get("name", keys.get("between", block if isinstance(block, str) else None))
    # Test for arrays first, because the truth value of an array is ambiguous.
    return _short_text(name) if not hasattr(name, "shape") and name else ""


def _short_text(value: Any) -> str:
    """Return a value as one short line of text, however large or nested the value is."""
    try:
        return one_line(_SHORT_REPR.repr(value).replace("\n", " "))
    except ValueError:  # Python refuses to print integers with thousands of digits
        return "a number with thousands of digits"


def one_line(text: str) -> str:
    """Return a key, value or path as one short line of text, without its middle if it is long.

    Keys and values of users can have any length.
    """
    text = printable(text).replace("\n", "\\n")
    if len(text) <= _LONGEST_QUOTE:
        return text
    length = (_LONGEST_QUOTE - 3) // 2
    start, end = text[:length], text[length + 3 - _LONGEST_QUOTE :]
    return f"{start}...{end}"


def _dotted_path(loc: list[Any]) -> str:
    """Return the path of a key with dots between its parts, such as ``blocks[2].name``."""
    parts = [f"[{part}]" if isinstance(part, int) else f".{part}" for part in loc]
    return one_line("".join(parts).removeprefix("."))


def _fields(record: type[BaseModel]) -> dict[str, FieldInfo]:
    """Return a map from the keys of a record to its fields.

    In Python, a field with an alias has two keys: its name and its alias. In a case file, it has only the
    alias.
    """
    by_name, fields = record.model_config.get("populate_by_name"), record.model_fields.items()
    fields_by_key = {name if by_name else field.alias or name: field for name, field in fields}
    return fields_by_key | {field.alias: field for _, field in fields if field.alias}


def _record_class(field: FieldInfo, loc: Collection[str | int]) -> type[BaseModel] | None:
    """Return the class of the records that a field contains, or None if the field contains no records.

    If several classes are possible, the location of the error selects the class.
    """
    annotations: list[Any] = [field.annotation]
    candidates: list[tuple[bool, type[BaseModel]]] = []
    for annotation in annotations:  # the loop appends the parts of nested annotations to this list
        kind, *marks = get_args(annotation) or (annotation,)
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            is_tagged = any(isinstance(mark, Tag) and mark.tag in loc for mark in marks)
            candidates.append((is_tagged, kind))
        elif get_args(annotation):
            annotations += [kind, *marks]
    if not candidates:
        return None
    return max(candidates, key=lambda candidate: candidate[0])[1]
