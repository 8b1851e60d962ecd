"""The repository's own case files: where their folder is, each by its name in it, and with other joints."""

from __future__ import annotations

from pathlib import Path

from masonry_opt.errors import CaseError
from masonry_opt.scene.arch import Arch
from masonry_opt.scene.case_file import load, load_with_arch
from masonry_opt.scene.scene import Scene

#: Help of the option that names the folder.
CASES_HELP = "Folder of the case files. Default: cases/ here, or else those of the package."

#: One of the paper's case files, by which their folder is known.
_KNOWN_BY = Path("ferris_tinloi", "wall_1.toml")

_PACKAGE = Path(__file__).parents[1]


def case_folder(named: Path | None = None) -> Path:
    """The folder of case files: the one named; else ``cases/`` in the current folder, if it holds the
    paper's; else the package's own, which in a clone lies beside the package.

    Raises CaseError if none is named and there is none.
    """
    if named is not None:
        return named
    for folder in (Path("cases"), _PACKAGE / "cases", _PACKAGE.parent / "cases"):
        if (folder / _KNOWN_BY).is_file():
            return folder
    raise CaseError("the package's case files are missing: install it anew, or name a folder with --cases")


def open_case(cases: Path, name: str) -> Scene:
    """The scene of a case file, by its name in the folder of case files.

    Raises CaseError if it is missing or wrong.
    """
    return load(_existing(cases, name))


def open_arch(cases: Path, name: str) -> tuple[Scene, Arch]:
    """The scene of a case file, and the ``[arch]`` it was generated from.

    Raises CaseError if the file is missing or wrong, or has not one ``[arch]``.
    """
    path = _existing(cases, name)
    scene, arch = load_with_arch(path)
    if arch is None:
        raise CaseError(f"{path}: has no [arch], or more than one, to vary")
    return scene, arch


def with_joints(scene: Scene, **properties: object) -> Scene:
    """The scene with other properties in all joints that have none of their own."""
    return scene.model_copy(update={"joints": scene.joints.model_copy(update=properties)})


def _existing(cases: Path, name: str) -> Path:
    path = cases / name
    if not path.exists():
        raise CaseError(
            f"{path}: no such file: name another folder with --cases, or none for the package's own"
        )
    return path
