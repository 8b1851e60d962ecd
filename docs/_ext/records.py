"""Sphinx extension that shows the fields of records with types and defaults, without pydantic's own fields.

Docstrings of this package write ``name: text`` on one line, or ``name:`` with the text below it. One entry
may describe several names. Napoleon supports neither form, so this extension rewrites sections of fields.
Fields of pydantic classes and dataclasses get the types of the class, and those of pydantic classes also its
defaults. The types of returned objects become links if the reference describes them.
"""

import dataclasses
import inspect
import math
import re
import typing
from collections.abc import Iterator
from enum import Enum
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import pandas
from pydantic import BaseModel
from sphinx.application import Sphinx
from sphinx.util.typing import stringify_annotation

#: Literals, whose "|" stay. Elsewhere |x| is an absolute value, which reStructuredText would substitute.
_LITERAL = re.compile(r"(``.+?``)")
_ATTRIBUTES = ("attribute", "data", "property")  #: Kinds of objects whose docstrings stay as they are.
_docstrings: dict[str, list[str]] = {}  #: Docstrings of attributes by name, before Napoleon has changed them.
_ENTRY = re.compile(r"(?P<names>\*{0,2}\w+(?:, \*{0,2}\w+)*):(?: (?P<text>.*))?$")
#: Begin of a text that refers to the record where the fields are described with their types.
_ELSEWHERE = re.compile(r"(?:[Ss]ee|[Aa]s in) :class:")
#: First word of a text that may begin with a capital letter. Symbols, such as x or tan φ, may not.
_FIRST_WORD = re.compile(r"(?!tan\b|atan\b|inf\b)[a-z]{2,}\b(?![_(.\]])|a\b")


def _is_model(of: Any) -> bool:
    return isinstance(of, type) and issubclass(of, BaseModel)


def _plain(value: Any) -> str:
    """Return a default value as it would be written in a call."""
    if isinstance(value, float) and (math.isinf(value) or value == int(value)):
        return f"{value:g}"
    if dataclasses.is_dataclass(value):
        # The fields of settings are listed where their class is described.
        return f"{type(value).__name__}()"
    if isinstance(value, tuple):
        return f"({', '.join(map(_plain, value))})"
    return repr(value)


def _default(of: type[BaseModel], name: str) -> str | None:
    """Return the default of a field as text, or None if the field is required."""
    field = of.model_fields[name]
    return None if field.is_required() else _plain(field.get_default(call_default_factory=True))


def _signature(of: type[BaseModel]) -> str:
    given = {name: _default(of, name) for name in of.model_fields}
    wanted = [name for name, default in given.items() if default is None]
    return f"({', '.join(['*', *wanted, *(f'{n}={d}' for n, d in given.items() if d is not None)])})"


def _hints(of: type) -> dict[str, Any]:
    """Return the annotations of the fields and the properties of a class."""
    # Annotations may name pandas although the module imports it only inside functions.
    within = {"pd": pandas, "Self": of}
    hints = typing.get_type_hints(of, localns=within)
    for name, member in inspect.getmembers(of, lambda kind: isinstance(kind, property | cached_property)):
        getter = member.fget if isinstance(member, property) else member.func
        hints[name] = typing.get_type_hints(getter, localns=within).get("return", Any)
    return hints


def _typed(of: type, names: list[str]) -> str:
    """Return the types and defaults of the fields that one entry describes, as code."""
    hints = _hints(of)
    types = {}
    for name in names:
        if name in hints:
            shown = stringify_annotation(hints[name], "smart").replace("~", "").replace(" | ", " or ")
            shown = re.sub(r"\b(?:masonry_opt|typing|collections)(?:\.\w+)*\.(\w+)", r"\1", shown)
            shown = re.sub(r"Literal\[(.+?)\]", lambda words: words[1].replace(", ", " or "), shown)
            default = _default(of, name) if _is_model(of) else None
            types[name] = f"``{shown}``" + ("" if default in (None, "None") else f", default ``{default}``")
    if len(set(types.values())) == 1:
        return next(iter(types.values()))
    return "; ".join(f"{name}: {kind}" for name, kind in types.items())


def _entries(lines: list[str]) -> Iterator[tuple[list[str], list[str]]]:
    """Yield the names and the lines of text of each entry of a section."""
    names: list[str] = []
    text: list[str] = []
    for line in lines:
        entry = _ENTRY.match(line)
        if entry:
            if names:
                yield names, text
            names, text = entry["names"].split(", "), [entry["text"]] if entry["text"] else []
        elif names:
            text.append(line.removeprefix("    "))
    if names:
        yield names, text


def _rewritten(of: Any, names: list[str], text: list[str]) -> Iterator[str]:
    """Yield the lines of an entry in the style of NumPy, without types if its text names another record."""
    typed = (_is_model(of) or dataclasses.is_dataclass(of)) and isinstance(of, type)
    elsewhere = len(names) > 1 and text and _ELSEWHERE.match(" ".join(text))
    kind = _typed(of, names) if typed and not elsewhere else ""
    yield ", ".join(names) + (f" : {kind}" if kind else "")
    yield from (f"    {line}" if line else "" for line in _capitalised(text) or [""])


def _capitalised(text: list[str]) -> list[str]:
    """Return the lines of a text that begins with a capital letter, unless it begins with a symbol."""
    if text and _FIRST_WORD.match(text[0]):
        return [text[0][0].upper() + text[0][1:], *text[1:]]
    return text


def _inherited(of: Any, own: str, shown: Any) -> Iterator[tuple[list[str], list[str]]]:
    """Yield the attributes that only the base classes of a class describe.

    ``own`` is the docstring of the class. Members that have their own entry (``shown``) are left out.
    """
    bases = of.__mro__[1:] if isinstance(of, type) and not _is_model(of) else ()
    for base in bases:
        text = inspect.cleandoc(base.__dict__.get("__doc__") or "").split("\n")
        if base.__module__.startswith("masonry_opt.") and "Attributes" in text:
            for names, lines in _entries(text[text.index("Attributes") + 2 :]):
                if not any(re.search(rf"^{name}\b", own, re.MULTILINE) or name in shown for name in names):
                    yield names, lines


def _process(app: Sphinx, what: str, name: str, of: Any, options: Any, lines: list[str]) -> None:
    """Rewrite the sections of a docstring in place, before Napoleon reads them."""
    parts: list[str] = []
    described: set[str] = set()
    at = 0
    while at < len(lines):
        header = lines[at].strip()
        if header in ("Parameters", "Attributes") and at + 1 < len(lines) and lines[at + 1].startswith("---"):
            end = at + 2
            while end < len(lines) and not (end + 1 < len(lines) and lines[end + 1].startswith("---")):
                end += 1
            title = "Fields" if _is_model(of) else header
            parts += [title, "-" * len(title)]
            entries = [*_entries(lines[at + 2 : end])]
            if not entries:
                raise ValueError(f"{name}: no line of the section {header!r} is 'name: text'")
            if header == "Attributes" and what == "class":
                entries += _inherited(of, "\n".join(lines), options.get("members") or ())
            for names, text in entries:
                described.update(names)
                parts += list(_rewritten(of, names, text))
            parts.append("")
            at = end
        else:
            parts.append(lines[at])
            at += 1
    if _is_model(of) and not described:
        parts += ["", "Fields", "------"]
        for field in of.model_fields:
            parts += list(_rewritten(of, [field], []))
    _link_return_type(parts)
    lines[:] = map(_without_substitutions, parts)
    if what in _ATTRIBUTES:
        _docstrings[name] = _sentence(lines)


@cache
def _classes_of_reference() -> frozenset[str]:
    """Return the names of the classes that the reference describes."""
    page = Path(__file__).parents[1] / "reference.md"
    return frozenset(re.findall(r"^\.\. autoclass:: [\w.]+\.(\w+)$", page.read_text("utf-8"), re.MULTILINE))


def _link_return_type(lines: list[str]) -> None:
    """Make links, in place, of the types that the section ``Returns`` names."""
    if "Returns" in lines:
        line = lines.index("Returns") + 2
        lines[line] = re.sub(r"\w+", _linked, lines[line])


def _linked(word: re.Match[str]) -> str:
    """Return a word of a return type, as a link if it is a class of the reference."""
    return f":class:`~.{word[0]}`" if word[0] in _classes_of_reference() else word[0]


def _sentence(lines: list[str]) -> list[str]:
    """Return a comment on an attribute as a sentence: with a capital letter and a full stop."""
    text = "\n".join(_capitalised(lines)).rstrip()
    return [*f"{text}.".split("\n"), ""] if text and text[-1] not in ".:;!?" else [*text.split("\n"), ""]


def _restore(app: Sphinx, what: str, name: str, of: Any, options: Any, lines: list[str]) -> None:
    """Restore the docstring of an attribute in place, after Napoleon has changed it.

    Napoleon takes the text before a colon in the first line for the type of the attribute.
    """
    if what in _ATTRIBUTES:
        lines[:] = _docstrings.pop(name)


def _without_substitutions(line: str) -> str:
    pieces = _LITERAL.split(line)
    return "".join(piece if piece.startswith("``") else piece.replace("|", r"\|") for piece in pieces)


def _call(app: Sphinx, what: str, name: str, of: Any, options: Any, given: str, back: str) -> Any:
    """Return the signature that the reference shows, or None to keep the original signature.

    The signature of a record lists its fields. Results and statuses have no signature, because users do not
    create them. Paths and lambdas among the defaults of a function are made readable.
    """
    if what == "class" and _is_model(of):
        return _signature(of), None
    if what == "class" and (dataclasses.is_dataclass(of) or issubclass(of, Enum)):
        return "", None
    if given:
        return re.sub(r"PosixPath\((.+?)\)", r"\1", given).replace("<function <lambda>>", "..."), back
    return None


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the extension to Sphinx, with priorities before and after Napoleon."""
    app.connect("autodoc-process-docstring", _process, priority=400)
    app.connect("autodoc-process-docstring", _restore, priority=600)
    app.connect("autodoc-process-signature", _call)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
