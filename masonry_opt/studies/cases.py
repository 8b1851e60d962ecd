"""The folder of the case files that come with the package."""

from __future__ import annotations

from pathlib import Path

from masonry_opt.errors import CaseError

#: Help of the option that names the folder.
CASES_HELP = "Folder of the case files. Default: cases/ here, or else those of the package."

#: A case file of the paper, by which the folder is recognised.
_KNOWN_BY = Path("ferris_tinloi", "wall_1.toml")

_PACKAGE = Path(__file__).parents[1]


def case_folder(named: Path | None = None) -> Path:
    """The folder named; else ``cases/`` in the current folder, if it holds the paper's case files; else the
    package's own, which in a clone lies beside the package.

    Raises CaseError if there is none.
    """
    if named is not None:
        return named
    for folder in (Path("cases"), _PACKAGE / "cases", _PACKAGE.parent / "cases"):
        if (folder / _KNOWN_BY).is_file():
            return folder
    raise CaseError("the package's case files are missing: install it anew, or name a folder with --cases")
