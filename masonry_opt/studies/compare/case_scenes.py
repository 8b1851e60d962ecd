"""The scenes of a comparison: case files, by path or by name. Adding a scene is adding its file."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from masonry_opt.errors import CaseError, OptionError
from masonry_opt.scene.case_file import load
from masonry_opt.scene.scene import Scene

#: What does not change an answer.
_WORDS = {"title", "source", "reference"}


@dataclass(frozen=True)
class CaseScene:
    """A scene of a comparison.

    Attributes
    ----------
    name: folder and stem of its case file, such as "ferris_tinloi/wall_1".
    path: the case file.
    registered: where the registry of best known states looks for it: the case file; of a scene that the
        comparison makes, its place in the folder of case files ("cases/random/wall_0.toml").
    content: hash of blocks, joints, loads and gravity; words and references do not change it.
    title: its title, as in the case file.
    expected: by question, what is known of its answer by hand (see :func:`~.known_answers.known_claims`).
    """

    name: str
    path: Path
    registered: Path
    content: str
    title: str
    expected: Mapping[str, str] = field(default_factory=dict)


def find_scenes(
    cases: Iterable[str | Path],
    folder: Path = Path("cases"),
    expected: Mapping[Path, Mapping[str, str]] | None = None,
    made: Path | None = None,
) -> tuple[CaseScene, ...]:
    """Read and name the scenes of a comparison.

    Parameters
    ----------
    cases: paths of case files, or names of those in ``folder`` ("ferris_tinloi/wall_1" or "wall_1").
    expected: what is known of some of them, by path.
    made: folder of the scenes that the comparison makes; they are registered with those of ``folder``.

    Raises
    ------
    CaseError
        If a case file is missing or wrong.
    OptionError
        If two different files have one name.
    """
    scenes: dict[str, CaseScene] = {}
    for case in cases:
        path = _path(case, folder)
        scene = load(path)
        name, known = f"{path.resolve().parent.name}/{path.stem}", (expected or {}).get(path, {})
        registered = folder / path.relative_to(made) if made and path.is_relative_to(made) else path
        found = CaseScene(name, path, registered, content_of(scene), scene.title, known)
        before = scenes.setdefault(found.name, found)
        if before.content != found.content:
            raise OptionError(f"{before.path} and {path}: two scenes named '{found.name}': rename one")
    return tuple(scenes.values())


def content_of(scene: Scene) -> str:
    """Hash of what a scene's answer depends on, 12 hexadecimal digits.

    Keys at their defaults do not count: a key that a later version adds changes no hash. Nor does it whether
    a live load is given as a multiple of the block's weight or as the force that it is.
    """
    keys = scene.model_dump(exclude=_WORDS, exclude_defaults=True)
    # A load may say another weight, which the multiple follows.
    for block in [] if scene.loads else keys["blocks"]:
        if "weight" in block and "live" not in block and (times := block.pop("live_per_weight", None)):
            block["live"] = tuple(part * block["weight"] for part in times)
            block |= {"live_at": block["weight_at"]} if "weight_at" in block else {}
    return hashlib.sha256(repr(keys).encode()).hexdigest()[:12]


def _path(case: str | Path, folder: Path) -> Path:
    path = Path(case)
    if path.exists() or path.suffix:
        return path
    named = [file for file in sorted(folder.glob("*/*.toml")) if str(case) in (file.stem, _name_of(file))]
    if not named:
        raise CaseError(f"{case}: no such file, and no case in {folder}/ has that name")
    if len(named) > 1:
        raise OptionError(f"'{case}' may be {', '.join(map(_name_of, named))}: name one in full")
    return named[0]


def _name_of(path: Path) -> str:
    return f"{path.parent.name}/{path.stem}"
