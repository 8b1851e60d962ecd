"""Case files: TOML or JSON to a scene and back, with errors that name file, key and block."""

from __future__ import annotations

import difflib
import json
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import tomli_w
from pydantic import ConfigDict, ValidationError

from masonry_opt.errors import CaseError
from masonry_opt.files import write_whole
from masonry_opt.scene.blocks import Block, Joint, JointDefaults, Record, Reference
from masonry_opt.scene.facade import Facade
from masonry_opt.scene.scene import Scene, SceneKeys
from masonry_opt.scene.wall import Wall


class CaseFile(SceneKeys):
    """A case file: the keys of a scene, and generators that expand to blocks."""

    # In a file a key has one name: [[block]], not also [[blocks]].
    model_config = ConfigDict(populate_by_name=False)

    wall: Wall | None = None
    facade: Facade | None = None

    def scene(self) -> Scene:
        """The scene, its generators expanded after the blocks written out.

        Raises pydantic.ValidationError if the blocks do not make a scene.
        """
        generated = [
            block for generator in (self.wall, self.facade) if generator for block in generator.blocks()
        ]
        keys = {name: getattr(self, name) for name in SceneKeys.model_fields}
        return Scene(**(keys | {"blocks": [*self.blocks, *generated]}))


#: The record that each table of a case file fills, to suggest the key that was meant.
TABLES: dict[str, type[Record]] = {
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
}


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
    path = Path(path)
    case = _read(path)
    try:
        return CaseFile.model_validate(case).scene().read_from(path)
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
    """One line per mistake: the table or block, the key, what is wrong."""
    return [_explain_one(dict(item), case) for item in error.errors(include_url=False)]


def _read(path: Path) -> dict[str, Any]:
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        raise CaseError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise CaseError(f"{path}: is a folder, not a case file") from None
    except UnicodeDecodeError:
        raise CaseError(f"{path}: is not UTF-8 text; save it as UTF-8") from None
    except OSError as error:
        raise CaseError(f"{path}: cannot be read: {error.strerror}") from None
    try:
        match path.suffix.lower():
            case ".toml":
                return tomllib.loads(text)
            case ".json":
                case = json.loads(text, object_pairs_hook=_without_repeats)
            case _:
                raise CaseError(f"{path}: a case file's name ends in .toml or .json")
    except _RepeatedKeyError as error:
        raise CaseError(f"{path}: key '{error}' is given twice in one object") from None
    except (tomllib.TOMLDecodeError, json.JSONDecodeError) as error:
        raise CaseError(f"{path}: not valid {path.suffix[1:].upper()}: {error}") from None
    except RecursionError:
        raise CaseError(f"{path}: is nested too deeply to be a case file") from None
    if not isinstance(case, dict):
        raise CaseError(f"{path}: must be one JSON object with the keys of a case file")
    return case


def _keys(scene: Scene, mode: Literal["python", "json"]) -> dict[str, Any]:
    return scene.model_dump(mode=mode, by_alias=True, exclude_defaults=True)


class _RepeatedKeyError(Exception):
    """A JSON object holds a key twice, of which a parser would keep the last in silence."""


def _without_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        keys = [key for key, _ in pairs]
        raise _RepeatedKeyError(next(key for key in keys if keys.count(key) > 1))
    return table


def _explain_one(item: dict[str, Any], case: Mapping[str, Any]) -> str:
    where: list[str] = []
    loc = list(item["loc"])
    table = str(loc[0]) if loc else ""
    if table in ("block", "joint") and len(loc) > 1 and isinstance(loc[1], int):
        where.append(_named_entry(table, loc[1], case.get(table)))
        loc = loc[2:]
    elif len(loc) > 1 or table in TABLES:
        where.append(f"[{table}]")
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
    message = _MESSAGES.get(item["type"], item["msg"].removeprefix("Value error, "))
    message = message[0].lower() + message[1:].format(**item.get("ctx", {}))
    if item["type"] != "value_error" or key:
        shown = repr(item["input"])
        message += f" (found {shown if len(shown) <= 60 else shown[:57] + '...'})"
    return ": ".join([*where, *([f"key '{key}'"] if key else []), message])


def _named_entry(table: str, index: int, entries: Any) -> str:
    name = None
    if isinstance(entries, list) and index < len(entries) and isinstance(entries[index], dict):
        name = entries[index].get("name", entries[index].get("between"))
    return f"{table} no. {index + 1}" + (f" ({name!r})" if name else "")


def _dotted(loc: list[Any]) -> str:
    key = ""
    for part in loc:
        if isinstance(part, int):
            key += f"[{part}]"
        elif part not in ("name", "lengths"):  # the two kinds of an entry of a wall's courses
            key += f".{part}" if key else str(part)
    return key


def _suggestion(key: str, table: str) -> str:
    fields = TABLES.get(table, CaseFile).model_fields
    known = [field.alias or name for name, field in fields.items()]
    close = difflib.get_close_matches(key.rsplit(".", 1)[-1], known, n=1)
    return f"; did you mean '{close[0]}'?" if close else f"; known: {', '.join(known)}"
