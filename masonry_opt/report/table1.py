"""Table 1 of the paper, from the case files, our columns beside the published ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from masonry_opt.analysis.result import Result
from masonry_opt.analysis.solve import solve
from masonry_opt.errors import CaseError
from masonry_opt.files import write_whole
from masonry_opt.scene.case_file import load
from masonry_opt.scene.scene import Scene

WALLS = (1, 2, 3, 4, 5, 6)

#: Random restarts of the refinement: enough for walls 5 and 6 to leave the loop's neighbourhood.
RESTARTS = 60


@dataclass(frozen=True)
class Table1:
    """The table in two parts, one row a wall, and what missed its published value.

    Attributes
    ----------
    load_factors: published and computed load factors.
    residuals: certificate and cost of the loop, the MPEC and the refinement, and published times.
    missed: one line for each computed value outside its case file's tolerance.
    """

    load_factors: pd.DataFrame
    residuals: pd.DataFrame
    missed: tuple[str, ...]


def table1(
    cases: Path,
    progress: Callable[[str], None] = lambda _: None,
    walls: Sequence[int] = WALLS,
) -> Table1:
    """Solve the six walls: associative in both languages, the loop, the MPEC, the refinement.

    Parameters
    ----------
    cases: folder of the case files.
    progress: called with a line before each solve.
    walls: which of the six.

    Raises
    ------
    CaseError
        If a case file is missing or wrong.
    """
    factors, residuals, missed = [], [], []
    for number in walls:
        path = cases / "ferris_tinloi" / f"wall_{number}.toml"
        if not path.exists():
            raise CaseError(
                f"{path}: no such file: run in a clone of the repository, or name its folder of case "
                "files with --cases"
            )
        scene = load(path)
        results = {}
        for name, (method, options) in _RUNS.items():
            progress(f"wall {number}: {name}")
            results[name] = solve(scene, method, **options)
            missed += misses(scene, _REFERENCE.get(name, method), results[name])
        missed += miscounts(scene, results["loop"])
        factors.append(_factor_row(number, scene, results))
        residuals += [_residual_row(number, scene, name, results[name]) for name in _WITH_RESIDUALS]
    return Table1(pd.DataFrame(factors), pd.DataFrame(residuals), tuple(missed))


#: Columns of the table: method and options.
_RUNS: dict[str, tuple[str, dict[str, Any]]] = {
    "CVXPY + Clarabel": ("static", {}),
    "Pyomo + HiGHS": ("static", {"model": "pyomo"}),
    "loop": ("nonassociative", {}),
    "mpec": ("mpec", {}),
    "refined": ("refined", {"restarts": RESTARTS}),
}
_REFERENCE = {"CVXPY + Clarabel": "associative", "Pyomo + HiGHS": "associative"}
_WITH_RESIDUALS = ("loop", "mpec", "refined")


def miscounts(scene: Scene, result: Result) -> list[str]:
    """A line for each count of blocks or joints that is not the published one."""
    return [
        f"{scene.origin}: {getattr(result.size, count)} {count}, published: "
        f"{scene.reference[count].value:.0f}"
        for count in ("blocks", "joints")
        if count in scene.reference and getattr(result.size, count) != scene.reference[count].value
    ]


def misses(scene: Scene, reference: str, result: Result) -> list[str]:
    """A line if a result has no load factor or leaves the tolerance of the case file's reference."""
    published = scene.reference[reference]
    what = f"{scene.origin}: {reference} ({result.model}, {result.solver})"
    if result.load_factor is None:
        return [f"{what}: {result.status}: {result.message}"]
    off = result.load_factor / published.value - 1
    # A refined state below the lowest known is no miss.
    lower = reference == "refined" and off < 0
    if published.tolerance is None or lower or abs(off) <= published.tolerance:
        return []
    return [
        f"{what}: {result.load_factor:.7f}, published {published.value}, off by {abs(off):.1e} "
        f"(tolerance {published.tolerance:.1e})"
    ]


def write_table1(table: Table1, folder: Path) -> list[Path]:
    """Write the two parts as ``table1.csv`` and ``table1_residuals.csv``; raises CaseError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        paths = [folder / "table1.csv", folder / "table1_residuals.csv"]
        for path, frame in zip(paths, (table.load_factors, table.residuals), strict=True):
            write_whole(path, frame.to_csv(index=False))
    except OSError as error:
        raise CaseError(f"{folder}: cannot be written: {error.strerror}") from None
    return paths


def _published(scene: Scene, name: str) -> float:
    return scene.reference[name].value if name in scene.reference else float("nan")


def _factor_row(number: int, scene: Scene, results: dict[str, Result]) -> dict[str, object]:
    factor = {
        name: float("nan") if result.load_factor is None else result.load_factor
        for name, result in results.items()
    }
    published = _published(scene, "nonassociative")
    size = results["loop"].size
    return {
        "wall": number,
        "b × c": f"{size.blocks} × {size.joints}",
        "assoc. paper": _published(scene, "associative"),
        "CVXPY": factor["CVXPY + Clarabel"],
        "Pyomo": factor["Pyomo + HiGHS"],
        "MCP publ.": _published(scene, "mcp"),
        "loop paper": published,
        "loop": factor["loop"],
        "diff %": 100 * (factor["loop"] / published - 1),
        "MPEC publ.": _published(scene, "mpec"),
        "mpec": factor["mpec"],
        "refined": factor["refined"],
    }


def _residual_row(number: int, scene: Scene, name: str, result: Result) -> dict[str, object]:
    residuals = result.certificate.as_dict() if result.certificate else {}
    published = {"loop": "nonassociative_seconds", "mpec": "mpec_seconds"}.get(name, "")
    return {
        "wall": number,
        "method": name,
        "status": str(result.status),
        **residuals,
        "LPs": result.lp_solves,
        "NLPs": result.nlp_solves,
        "time (s)": sum(result.seconds.values()),
        "published (s)": _published(scene, published),
    }
