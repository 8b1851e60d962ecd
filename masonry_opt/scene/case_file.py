"""Case files: TOML or JSON to a scene and back, with errors that name file, key and block."""

import json
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
from masonry_opt.scene.generator import MOST_BLOCKS, AnyGenerator, Generator, SolidGenerator
from masonry_opt.scene.keys import SceneKeys
from masonry_opt.scene.mistakes import wrong_values
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solid_generators.plan import Plan
from masonry_opt.scene.solid_generators.vaults import Barrel, Dome, Groin, Shaft
from masonry_opt.scene.solids import Vector
from masonry_opt.scene.tables import as_path, read_tables, write_file
from masonry_opt.scene.walls import Column, Facade, Wall

_G = TypeVar("_G", bound=AnyGenerator)

#: One table of a generator, [arch], or several of them, [[arch]].
OneOrMore = Annotated[list[_G], BeforeValidator(lambda value: value if isinstance(value, list) else [value])]


class MeshTable(AsDrawn):
    """A table of a case file that stands for the blocks of a mesh in a file beside it: with supports, axes
    and unit as :func:`read_mesh` takes them, and weight and live load of each as of a :class:`Solid`."""

    file: Text  #: its path, from the folder of the case file
    unit_weight: NonNegative
    live_per_weight: Vector = (0.0, 0.0, 0.0)


class CaseFile(SceneKeys):
    """A case file: the keys of a scene, generators that expand to blocks, and a mesh that holds them."""

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
    mesh: MeshTable | None = None

    def _mistakes(self) -> Iterator[str]:
        flat, solid = self._of(Generator), self._of(SolidGenerator)
        if (size := sum(generator.size for generator in [*flat, *solid])) > MOST_BLOCKS:
            yield f"its generators together build some {size} blocks; the most is {MOST_BLOCKS}"
        first = {block.dimension: f"block '{block.name}'" for block in reversed(self.blocks)}
        plane = f"{_table(flat[0])} builds blocks" if flat else f"{first[2]} lies" if 2 in first else ""
        drawn = "[mesh] is of solids" if self.mesh else f"{first[3]} is a solid" if 3 in first else ""
        space = f"{_table(solid[0])} is of solids" if solid else drawn
        if plane and space and (flat or solid or self.mesh):
            yield f"{plane} in the plane; {space}"

    @property
    def dimension(self) -> Literal[2, 3]:
        """Numbers of a point: 3 if the blocks are solids, those of a generator or of a mesh too."""
        return 3 if self._of(SolidGenerator) or self.mesh else super().dimension

    def _of(self, kind: type[_G]) -> list[_G]:
        """Its generators of a kind."""
        values = (getattr(self, name) for name in type(self).model_fields)
        return [one for value in values if isinstance(value, list) for one in value if isinstance(one, kind)]

    def tables_with_old_live(self) -> list[str]:
        """Generators that give ``live_per_weight`` by its old name, which elsewhere is a force."""
        return list(dict.fromkeys(_table(one) for one in self._of(Generator) if any(one.live)))

    def scene(self) -> Scene:
        """The scene, generators and mesh expanded after the blocks written out. Raises ValidationError if
        these make no scene, CaseError if a generator cannot build its own or the mesh cannot be read."""
        blocks = list(self.blocks)
        for flat in self._of(Generator):
            blocks += flat.blocks()
        for solid in self._of(SolidGenerator):
            blocks += solid.blocks()
        # Those that were given: what is refused by name is refused whatever its value.
        keys = {name: getattr(self, name) for name in SceneKeys.model_fields if name in self.model_fields_set}
        if self.mesh:
            from masonry_opt.scene.drawings.mesh_files import read_mesh  # which few case files need

            given = self.mesh.model_dump(exclude={"file", "live_per_weight"}) | {"tolerance": self.tolerance}
            read = read_mesh(self.mesh.file, friction=0.0, live=self.mesh.live_per_weight, **given)
            blocks += read.blocks
            keys["tolerance"] = read.tolerance
        return Scene.model_validate(keys | {"blocks": blocks})


def _table(generator: AnyGenerator) -> str:
    return f"[{type(generator).__name__.lower()}]"


def load(path: str | Path) -> Scene:
    """Read a case file, ``.toml`` or ``.json`` with the same keys, as a scene with generators expanded;
    unexpanded they are in its ``case``.

    Raises CaseError if the file cannot be read or describes no scene; the message names file, key and block.
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
    except CaseError as error:  # of a block that a generator built, or of a mesh
        raise CaseError(f"{path}: {error}") from None


def as_scene(scene: Scene | str | Path, load_case: str | None = None) -> Scene:
    """A scene, read from its case file if a path is given; in one of its load cases if one is named. Raises
    CaseError if it is neither, or the case file is wrong; OptionError if it has no such load case."""
    if isinstance(scene, (str, Path)):
        scene = load(scene)
    if isinstance(scene, Scene):
        return scene if load_case is None else scene.in_case(load_case)
    raise CaseError(f"a scene is a Scene or the path of a case file (found {type(scene).__name__})")


def save(scene: Scene | CaseFile, path: str | Path, force: bool = False) -> None:
    """Write a scene as a case file (TOML, or JSON if the name ends so), whole or not at all.

    Raises CaseError if it is no scene, the name ends otherwise or the file cannot be written; OptionError if
    it would replace a file that was not written here, which is known by a mark in it, unless ``force``.
    """
    if not isinstance(scene, Scene | CaseFile):
        raise CaseError(f"what is saved is a Scene (found {type(scene).__name__})")
    path = as_path(path, "a case file", ".toml", ".json")
    if path.suffix.lower() == ".toml":
        mark = f"# {MARK}, and replaced by it without asking until this line is deleted\n"
        text = mark + toml_text(scene)
    else:
        keys = {JSON_KEY: WRITER} | scene.model_dump(mode="json", by_alias=True, exclude_defaults=True)
        text = json.dumps(keys, indent=2, ensure_ascii=False) + "\n"
    refuse_replacing(path, force)
    write_file(path, text, CaseError)


def toml_text(scene: SceneKeys) -> str:
    """A scene, or the content of a case file, as TOML."""
    return tomli_w.dumps(scene.model_dump(by_alias=True, exclude_defaults=True))


def case_folder(named: Path | None = None) -> Path:
    """The folder named; else ``cases/`` in the current folder if it holds the paper's case files; else the
    package's own, in a clone beside the package. Raises CaseError if there is none."""
    if named is not None:
        return named
    package = Path(__file__).parents[1]
    for folder in (Path("cases"), package / "cases", package.parent / "cases"):
        if (folder / "ferris_tinloi" / "wall_1.toml").is_file():
            return folder
    raise CaseError("the package's case files are missing: install it anew, or name a folder with --cases")
