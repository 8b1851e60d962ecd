"""Read TOML or JSON case files as scenes, and write them, with errors that name file, key and block."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal, TypeVar

import tomli_w
from pydantic import BeforeValidator, ConfigDict, ValidationError

from masonry_opt.errors import CaseError
from masonry_opt.files import JSON_KEY, MARK, WRITER, refuse_replacing
from masonry_opt.scene.arch import Arch
from masonry_opt.scene.blocks import NonNegative, Text
from masonry_opt.scene.drawings.stones import AsDrawn
from masonry_opt.scene.generator import MOST_BLOCKS_GENERATED, AnyGenerator, Generator, SolidGenerator
from masonry_opt.scene.keys import SceneKeys
from masonry_opt.scene.mistakes import wrong_values
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solid_generators.plan import Plan
from masonry_opt.scene.solid_generators.vaults import Barrel, Dome, Groin, Shaft
from masonry_opt.scene.solids import Vector
from masonry_opt.scene.tables import as_path, read_tables, write_file
from masonry_opt.scene.walls import Column, Facade, Wall

_G = TypeVar("_G", bound=AnyGenerator)

#: Pattern of a TOML list that extends over several lines and contains no nested list or table.
_LIST = re.compile(r"\[\n\s*([^][{}]*?),?\n\s*\]")
_LINE_BREAK = re.compile(r"\n\s*")  #: Pattern of a line break and the indentation of the next line.

#: Generators of one kind: a single table, such as [arch], or a list of tables, such as [[arch]].
OneOrMore = Annotated[list[_G], BeforeValidator(lambda value: value if isinstance(value, list) else [value])]


class MeshTable(AsDrawn):
    """Table ``[mesh]`` of a case file, which reads blocks from a mesh file.

    The keys for supports, axes and unit have the same meaning as in :func:`read_mesh`. The keys for weight
    and live load apply to each block, as in :class:`Solid`.
    """

    file: Text  #: path of the mesh file, relative to the folder of the case file
    unit_weight: NonNegative
    live_per_weight: Vector = (0.0, 0.0, 0.0)


class CaseFile(SceneKeys):
    """Content of a case file: the keys of a scene, generators of blocks, and a mesh with blocks."""

    # A key has only one name in a file: [[block]] is valid, [[blocks]] is not.
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
    mesh: MeshTable | None = None

    def _mistakes(self) -> Iterator[str]:
        flat_generators = self._generators_of(Generator)
        solid_generators = self._generators_of(SolidGenerator)
        size = sum(generator.size for generator in [*flat_generators, *solid_generators])
        if size > MOST_BLOCKS_GENERATED:
            yield (
                f"the generators build about {size} blocks, "
                f"but at most {MOST_BLOCKS_GENERATED} are allowed: build fewer blocks"
            )
        plane = self._plane_content(flat_generators)
        space = self._space_content(solid_generators)
        if plane and space and (flat_generators or solid_generators or self.mesh):
            yield f"a scene must be in the plane or in space, but {plane}, and {space}: remove one of the two"

    def _plane_content(self, generators: list[Generator]) -> str:
        """Return a phrase about the first generator of plane blocks, or else about the first plane block.

        The phrase is part of an error message. It is empty if there are neither.
        """
        if generators:
            return f"{_table_name(generators[0])} builds blocks in the plane"
        names = [block.name for block in self.blocks if block.dimension == 2]
        return f"block '{names[0]}' lies in the plane" if names else ""

    def _space_content(self, generators: list[SolidGenerator]) -> str:
        """Return a phrase about the first generator of solids, or else about the mesh or the first solid.

        The phrase is part of an error message. It is empty if there are none of these.
        """
        if generators:
            return f"{_table_name(generators[0])} builds solids"
        if self.mesh:
            return "[mesh] contains solids"
        names = [block.name for block in self.blocks if block.dimension == 3]
        return f"block '{names[0]}' is a solid" if names else ""

    @property
    def dimension(self) -> Literal[2, 3]:
        """Return the number of coordinates of a point: 2 in the plane, 3 in space.

        The dimension is 3 if the listed blocks, a generator or the mesh define solids.
        """
        return 3 if self._generators_of(SolidGenerator) or self.mesh else super().dimension

    def _generators_of(self, kind: type[_G]) -> list[_G]:
        """Return the block generators of a given class in the case file, such as arches or walls."""
        values = (getattr(self, name) for name in type(self).model_fields)
        lists = (value for value in values if isinstance(value, list))
        return [record for records in lists for record in records if isinstance(record, kind)]

    def tables_with_old_live(self) -> list[str]:
        """Return the names of the generator tables that use ``live``, the old key for ``live_per_weight``.

        In blocks and loads, ``live`` is a force.
        """
        generators = [generator for generator in self._generators_of(Generator) if any(generator.live)]
        return list(dict.fromkeys(map(_table_name, generators)))

    def scene(self) -> Scene:
        """Return the scene: the listed blocks, then the blocks of generators and of the mesh.

        Raises ValidationError if the keys and blocks are not a valid scene. Raises CaseError if a generator
        cannot build its blocks or the mesh cannot be read.
        """
        blocks = list(self.blocks)
        for flat_generator in self._generators_of(Generator):
            blocks += flat_generator.blocks()
        for solid_generator in self._generators_of(SolidGenerator):
            blocks += solid_generator.blocks()
        # Pass only the keys that the file contains, because a scene in space rejects some keys even if they
        # have their default value.
        keys = {name: getattr(self, name) for name in SceneKeys.model_fields if name in self.model_fields_set}
        if self.mesh:
            # import here, because few case files contain a mesh
            from masonry_opt.scene.drawings.mesh_files import read_mesh

            options = self.mesh.model_dump(exclude={"file", "live_per_weight"})
            options["tolerance"] = self.tolerance
            mesh_scene = read_mesh(self.mesh.file, friction=0.0, live=self.mesh.live_per_weight, **options)
            blocks += mesh_scene.blocks
            keys["tolerance"] = mesh_scene.tolerance
        return Scene.model_validate(keys | {"blocks": blocks})


def _table_name(generator: AnyGenerator) -> str:
    """Return the name of a generator's table in case files."""
    return f"[{type(generator).__name__.lower()}]"


def load(path: str | Path) -> Scene:
    """Read a case file, ``.toml`` or ``.json``, and return its scene.

    The scene contains the blocks that the generators of the file build. Its attribute ``case`` has the
    original content of the file.

    Parameters
    ----------
    path: Path of the case file.

    Returns
    -------
    Scene
        The scene, in the units of the case file.

    Raises
    ------
    CaseError
        If the file cannot be read or does not describe a scene. The message names file, key and block.
    """
    path = as_path(path, "a case file")
    case = read_tables(path)
    mesh = case.get("mesh")
    if isinstance(mesh, dict) and isinstance(mesh.get("file"), str):
        mesh["file"] = str(path.parent / mesh["file"])
    try:
        file = CaseFile.model_validate(case)
        return file.scene().read_from(path, file)
    except ValidationError as error:
        raise wrong_values(error, CaseFile, case, str(path)) from None
    except CaseError as error:  # errors of generators and of the mesh reader do not name the case file
        raise CaseError(f"{path}: {error}") from None


def as_scene(scene: Scene | str | Path, load_case: str | None = None) -> Scene:
    """Return a scene that is given as a :class:`Scene` or as the path of a case file.

    If ``load_case`` is given, the scene is in the load case of this name.

    Raises CaseError if the argument is neither a scene nor a path, or the case file is wrong. Raises
    OptionError if the scene has no such load case.
    """
    if isinstance(scene, (str, Path)):
        scene = load(scene)
    if isinstance(scene, Scene):
        return scene if load_case is None else scene.in_case(load_case)
    raise CaseError(f"a scene must be a Scene or the path of a case file (found {type(scene).__name__})")


def save(scene: Scene | CaseFile, path: str | Path, force: bool = False) -> None:
    """Write a scene as a case file: TOML, or JSON if the file name ends in ``.json``.

    If the file cannot be written completely, it is not changed. Files of this package are recognised by a
    mark in them.

    Parameters
    ----------
    scene: A scene, or the content of a case file (``scene.case``).
    path: File to write; the name ends in ``.toml`` or ``.json``.
    force: True to replace a file that another program wrote.

    Raises
    ------
    CaseError
        If the argument is not a scene, if the name has another ending, or if the file cannot be written.
    OptionError
        If a file exists that was not written by this package, unless ``force`` is True.
    """
    if not isinstance(scene, Scene | CaseFile):
        raise CaseError(f"only a Scene can be saved (found {type(scene).__name__})")
    path = as_path(path, "a case file", ".toml", ".json")
    if path.suffix.lower() == ".toml":
        mark = f"# {MARK}. As long as this line is here, saving a case replaces this file without asking.\n"
        text = mark + toml_text(scene)
    else:
        keys = {JSON_KEY: WRITER} | scene.model_dump(mode="json", by_alias=True, exclude_defaults=True)
        text = json.dumps(keys, indent=2, ensure_ascii=False) + "\n"
    refuse_replacing(path, force)
    write_file(path, text, CaseError)


def toml_text(scene: SceneKeys) -> str:
    """Return a scene, or the content of a case file, as TOML, with each innermost list on one line."""
    text = tomli_w.dumps(scene.model_dump(by_alias=True, exclude_defaults=True))
    return _LIST.sub(lambda match: "[" + _LINE_BREAK.sub(" ", match[1]) + "]", text)


def case_folder(named: Path | None = None) -> Path:
    """Return the folder of the package's case files.

    The result is the first of these folders that has the files: the folder ``named``, which is not checked,
    ``cases/`` in the current folder, and ``cases/`` in the package or, in a clone, next to the package.
    Raises CaseError if no folder has the files.
    """
    if named is not None:
        return named
    package = Path(__file__).parents[1]
    for folder in (Path("cases"), package / "cases", package.parent / "cases"):
        if (folder / "ferris_tinloi" / "wall_1.toml").is_file():
            return folder
    raise CaseError(
        "the package's case files are missing: reinstall the package, or specify their folder with --cases"
    )
