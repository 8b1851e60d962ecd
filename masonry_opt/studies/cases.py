"""The repository's own case files, by name in their folder."""

from __future__ import annotations

from pathlib import Path

from masonry_opt.errors import CaseError
from masonry_opt.scene.arch import Arch
from masonry_opt.scene.case_file import load, load_with_arch
from masonry_opt.scene.scene import Scene


def open_case(cases: Path, name: str) -> Scene:
    """The scene of a case file, by its name in the folder of case files.

    Raises CaseError if it is missing or wrong.
    """
    return load(_existing(cases, name))


def open_arch(cases: Path, name: str) -> tuple[Scene, Arch]:
    """The scene of a case file, and the ``[arch]`` it was generated from.

    Raises CaseError if the file is missing or wrong, or has no ``[arch]``.
    """
    path = _existing(cases, name)
    scene, arch = load_with_arch(path)
    if arch is None:
        raise CaseError(f"{path}: has no [arch] to vary")
    return scene, arch


def _existing(cases: Path, name: str) -> Path:
    path = cases / name
    if not path.exists():
        raise CaseError(
            f"{path}: no such file: run in a clone of the repository, or name its folder of case "
            "files with --cases"
        )
    return path
