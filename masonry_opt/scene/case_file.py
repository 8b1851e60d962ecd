"""Case files: TOML or JSON to a scene and back, with errors that name file, key and block."""

from __future__ import annotations

import difflib
import json
import reprlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import tomli_w
from pydantic import ConfigDict, ValidationError

from masonry_opt.errors import CaseError, printable
from masonry_opt.files import write_whole
from masonry_opt.scene.arch import Arch
from masonry_opt.scene.blocks import Block, Joint, JointDefaults, Record, Reference
from masonry_opt.scene.facade import Facade
from masonry_opt.scene.scene import Scene, SceneKeys
from masonry_opt.scene.tables import read_tables
from masonry_opt.scene.wall import Wall


class CaseFile(SceneKeys):
    """A case file: the keys of a scene, and generators that expand to blocks."""

    # In a file a key has one name: [[block]], not also [[blocks]].
    model_config = ConfigDict(populate_by_name=False)

    wall: Wall | None = None
    facade: Facade | None = None
    arch: Arch | None = None

    def scene(self) -> Scene:
        """The scene, its generators expanded after the blocks written out.

        Raises pydantic.ValidationError if the blocks do not make a scene.
        """
        generators = [generator for generator in (self.wall, self.facade, self.arch) if generator]
        generated = [block for generator in generators for block in generator.blocks()]
        keys = {name: getattr(self, name) for name in SceneKeys.model_fields}
        return Scene(**(keys | {"blocks": [*self.blocks, *generated]}))


#: The record that each table of a case file fills, to suggest the key that was meant.
TABLES: dict[str, type[Record]] = {
    "arch": Arch,
    "block": Block,
    "facade": Facade,
    "joint": Joint,
    "joints": JointDefaults,
    "reference": Reference,
    "wall": Wall,
}


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
    "string_unicode": "must be text of whole characters",
}

#: Mistakes named in one message; who makes more makes the same one again and again.
_MOST_MISTAKES = 20

#: Characters of a message that quotes names.
_LONGEST = 500

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = 60


def load(path: str | Path) -> Scene:
    """Read a case file.

    Parameters
    ----------
    path:
        A ``.toml`` file, or a ``.json`` file with the same keys.

    Returns
    -------
    Scene
        With generators expanded to blocks.

    Raises
    ------
    CaseError
        If the file cannot be read or does not describe a scene; the message names the file, the
        key and the block.
    """
    return load_with_arch(path)[0]


def load_with_arch(path: str | Path) -> tuple[Scene, Arch | None]:
    """Read a case file's scene and, unexpanded, its ``[arch]`` (None if it has none).

    Raises CaseError as :func:`load` does.
    """
    path = Path(path)
    case = read_tables(path)
    try:
        file = CaseFile.model_validate(case)
        return file.scene().read_from(path), file.arch
    except ValidationError as error:
        raise CaseError("\n".join(f"{path}: {line}" for line in explain(error, case))) from None


def save(scene: Scene, path: str | Path) -> None:
    """Write a scene as a case file (TOML, or JSON if the name ends so), whole or not at all.

    Raises CaseError if the name ends otherwise or the file cannot be written.
    """
    path = Path(path)
    match path.suffix.lower():
        case ".toml":
            text = tomli_w.dumps(_keys(scene, "python"))
        case ".json":
            text = json.dumps(_keys(scene, "json"), indent=2, ensure_ascii=False) + "\n"
        case _:
            raise CaseError(f"{path}: a case file's name ends in .toml or .json")
    try:
        write_whole(path, text)
    except OSError as error:
        raise CaseError(f"{path}: cannot be written: {error.strerror}") from None


def explain(error: ValidationError, case: Mapping[str, Any]) -> list[str]:
    """One line per mistake, at most twenty: the table or block, the key, what is wrong."""
    mistakes = error.errors(include_url=False)
    lines = [_explain_one(dict(item), case) for item in mistakes[:_MOST_MISTAKES]]
    more = len(mistakes) - len(lines)
    return [*lines, f"and {more} more mistakes"] if more else lines


def _keys(scene: Scene, mode: Literal["python", "json"]) -> dict[str, Any]:
    return scene.model_dump(mode=mode, by_alias=True, exclude_defaults=True)


def _shown(value: Any) -> str:
    """A value from a case file in one short line, however large or deep it is."""
    try:
        shown = _SHORT.repr(value)
    except ValueError:  # Python writes out no whole number of thousands of digits
        return "a number of thousands of digits"
    return shown if len(shown) <= _SHORT.maxother else f"{shown[: _SHORT.maxother - 3]}..."


def _explain_one(item: dict[str, Any], case: Mapping[str, Any]) -> str:
    where: list[str] = []
    loc = list(item["loc"])
    table = str(loc[0]) if loc else ""
    if table in ("block", "joint") and len(loc) > 1 and isinstance(loc[1], int):
        where.append(_named_entry(table, loc[1], case.get(table)))
        loc = loc[2:]
    elif len(loc) > 1 or table in TABLES:
        where.append(f"[{_one_line(table)}]")
        loc = loc[1:]
    key = _dotted(loc)
    if item["type"] == "extra_forbidden":
        return ": ".join([*where, f"unknown key '{key}'{_suggestion(key, table)}"])
    if item["type"] == "list_type" and table in ("block", "joint") and not key:
        return f"[{table}]: write [[{table}]], with double brackets, once for each {table}"
    if item["type"] == "missing" and loc and isinstance(loc[-1], int):
        return ": ".join([*where, f"key '{_dotted(loc[:-1])}': needs two numbers, [x, y]"])
    if item["type"] == "missing":
        return ": ".join([*where, f"missing key '{key}'" if key else "missing table"])
    if item["type"] in _MESSAGES:
        message = _MESSAGES[item["type"]].format(**item.get("ctx", {}))
    else:
        message = item["msg"].removeprefix("Value error, ")
        message = message[:1].lower() + message[1:_LONGEST]
    if item["type"] != "value_error" or key:
        message += f" (found {_shown(item['input'])})"
    return ": ".join([*where, *([f"key '{key}'"] if key else []), message])


def _named_entry(table: str, index: int, entries: Any) -> str:
    name = None
    if isinstance(entries, list) and index < len(entries) and isinstance(entries[index], dict):
        name = entries[index].get("name", entries[index].get("between"))
    return f"{table} no. {index + 1}" + (f" ({_shown(name)})" if name else "")


def _one_line(text: str) -> str:
    """A key as it is shown: keys are a case file's own words, of any length."""
    text = printable(text).replace("\n", "\\n")
    return text if len(text) <= 60 else f"{text[:57]}..."


def _dotted(loc: list[Any]) -> str:
    key = ""
    for part in loc:
        if isinstance(part, int):
            key += f"[{part}]"
        elif part not in ("name", "lengths"):  # the two kinds of an entry of a wall's courses
            key += f".{part}" if key else str(part)
    return _one_line(key)


def _suggestion(key: str, table: str) -> str:
    fields = TABLES.get(table, CaseFile).model_fields
    known = [field.alias or name for name, field in fields.items()]
    close = difflib.get_close_matches(key.rsplit(".", 1)[-1], known, n=1)
    return f"; did you mean '{close[0]}'?" if close else f"; known: {', '.join(known)}"
