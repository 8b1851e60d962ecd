"""Case files: TOML or JSON to a scene and back, with errors that name file, key and block."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

import tomli_w
from pydantic import BeforeValidator, ConfigDict, ValidationError, model_validator

from masonry_opt.errors import CaseError
from masonry_opt.files import JSON_KEY, MARK, WRITER, refuse_replacing, write_whole
from masonry_opt.scene.arch import Arch
from masonry_opt.scene.blocks import MOST_BLOCKS
from masonry_opt.scene.generator import AnyGenerator, Generator
from masonry_opt.scene.mistakes import wrong_file
from masonry_opt.scene.scene import Scene, SceneKeys
from masonry_opt.scene.solid_generators.barrel import Barrel
from masonry_opt.scene.solid_generators.dome import Dome
from masonry_opt.scene.solid_generators.generator import SolidGenerator
from masonry_opt.scene.solid_generators.groin import Groin
from masonry_opt.scene.solid_generators.plan import Plan
from masonry_opt.scene.solid_generators.shaft import Shaft
from masonry_opt.scene.solids import Solid
from masonry_opt.scene.tables import as_path, read_tables, reason
from masonry_opt.scene.walls import Column, Facade, Wall

_G = TypeVar("_G", bound=AnyGenerator)

#: One table of a generator, [arch], or several of them, [[arch]].
OneOrMore = Annotated[list[_G], BeforeValidator(lambda value: value if isinstance(value, list) else [value])]


class CaseFile(SceneKeys):
    """A case file: the keys of a scene, and generators that expand to blocks."""

    # In a file a key has one name: [[block]], not also [[blocks]].
    model_config = ConfigDict(populate_by_name=False)

    wall: OneOrMore[Wall] = []
    facade: OneOrMore[Facade] = []
    arch: OneOrMore[Arch] = []
    column: OneOrMore[Column] = []

    plan: OneOrMore[Plan] = []
    barrel: OneOrMore[Barrel] = []
    dome: OneOrMore[Dome] = []
    groin: OneOrMore[Groin] = []
    shaft: OneOrMore[Shaft] = []

    @model_validator(mode="after")
    def _can_be_built(self) -> CaseFile:
        flat, solid = self._in_plane(), self._in_space()
        if (size := sum(generator.size for generator in [*flat, *solid])) > MOST_BLOCKS:
            raise ValueError(f"its generators together build some {size} blocks; the most is {MOST_BLOCKS}")
        if flat and self.dimension == 3:
            other = _table(solid[0]) if solid else f"block '{self.blocks[0].name}'"
            raise ValueError(f"{_table(flat[0])} builds blocks in the plane; {other} is of solids")
        if solid and self.blocks and not isinstance(self.blocks[0], Solid):
            raise ValueError(
                f"{_table(solid[0])} builds solids; block '{self.blocks[0].name}' lies in the plane"
            )
        return self

    @property
    def dimension(self) -> Literal[2, 3]:
        return 3 if self._in_space() else super().dimension

    def _in_plane(self) -> list[Generator]:
        return [*self.wall, *self.facade, *self.arch, *self.column]

    def _in_space(self) -> list[SolidGenerator]:
        return [*self.plan, *self.barrel, *self.dome, *self.groin, *self.shaft]

    def tables_with_old_live(self) -> list[str]:
        """Generators that give ``live_per_weight`` by its old name, which elsewhere is a force."""
        return list(dict.fromkeys(_table(one) for one in self._in_plane() if any(one.live)))

    def scene(self) -> Scene:
        """The scene, its generators expanded after the blocks written out.

        Raises pydantic.ValidationError if the blocks do not make a scene, and CaseError if a generator
        cannot build its own.
        """
        flat = [block for generator in self._in_plane() for block in generator.blocks(self.thickness)]
        solid = [block for generator in self._in_space() for block in generator.blocks()]
        # Those that were given: what is refused by name is refused whatever its value.
        keys = {name: getattr(self, name) for name in SceneKeys.model_fields if name in self.model_fields_set}
        return Scene.model_validate(keys | {"blocks": [*self.blocks, *flat, *solid]})


def _table(generator: AnyGenerator) -> str:
    return f"[{type(generator).__name__.lower()}]"


def load(path: str | Path) -> Scene:
    """Read a case file.

    Parameters
    ----------
    path:
        A ``.toml`` file, or a ``.json`` file with the same keys.

    Returns
    -------
    Scene
        With generators expanded to blocks; unexpanded they are in its ``case``.

    Raises
    ------
    CaseError
        If the file cannot be read or does not describe a scene; the message names the file, the
        key and the block.
    """
    path = as_path(path, "a case file")
    case = read_tables(path)
    try:
        file = CaseFile.model_validate(case)
        return file.scene().read_from(path, file)
    except ValidationError as error:
        raise wrong_file(error, path, case, CaseFile) from None
    except CaseError as error:  # of a block that a generator built: pydantic's error lies behind it
        if not isinstance(error.__context__, ValidationError):
            raise
        raise wrong_file(error.__context__, path, case, CaseFile) from None


def as_scene(scene: Scene | str | Path) -> Scene:
    """A scene, read from its case file if a path is given.

    Raises CaseError if it is neither, or the case file is wrong.
    """
    if isinstance(scene, Scene):
        return scene
    if isinstance(scene, (str, Path)):
        return load(scene)
    raise CaseError(f"a scene is a Scene or the path of a case file (found {type(scene).__name__})")


def save(scene: Scene, path: str | Path, force: bool = False) -> None:
    """Write a scene as a case file (TOML, or JSON if the name ends so), whole or not at all.

    Raises CaseError if it is no scene, the name ends otherwise or the file cannot be written; OptionError if
    it would replace a file that was not written here, which is known by a mark in it, unless ``force``.
    """
    if not isinstance(scene, Scene):
        raise CaseError(f"what is saved is a Scene (found {type(scene).__name__})")
    path = as_path(path, "a case file")
    match path.suffix.lower():
        case ".toml":
            mark = f"# {MARK}, and replaced by it without asking until this line is deleted\n"
            text = mark + tomli_w.dumps(_keys(scene, "python"))
        case ".json":
            keys = {JSON_KEY: WRITER} | _keys(scene, "json")
            text = json.dumps(keys, indent=2, ensure_ascii=False) + "\n"
        case _:
            raise CaseError(f"{path}: a case file's name ends in .toml or .json")
    refuse_replacing(path, force)
    try:
        write_whole(path, text)
    except (OSError, ValueError) as error:
        raise CaseError(f"{path}: cannot be written: {reason(error)}") from None


def _keys(scene: Scene, mode: Literal["python", "json"]) -> dict[str, Any]:
    return scene.model_dump(mode=mode, by_alias=True, exclude_defaults=True)
