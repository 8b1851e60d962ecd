"""Table 1 of the paper, from the case files, our columns beside the published ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from masonry_opt.analysis.result import Result
from masonry_opt.analysis.solve import solve
from masonry_opt.errors import CaseError
from masonry_opt.files import write_whole
from masonry_opt.scene.case_file import load
from masonry_opt.scene.scene import Scene

WALLS = tuple(f"ferris_tinloi/wall_{number}.toml" for number in range(1, 7))


@dataclass(frozen=True)
class Table1:
    """The table in two parts, one row a wall, and what missed its published value.

    Attributes
    ----------
    load_factors: published and computed load factors.
    residuals: certificate and cost of our loop beside the published time.
    missed: one line for each computed value outside its case file's tolerance.
    """

    load_factors: pd.DataFrame
    residuals: pd.DataFrame
    missed: tuple[str, ...]


def table1(cases: Path, progress: Callable[[str], None] = lambda _: None) -> Table1:
    """Solve the six walls.

    Parameters
    ----------
    cases: folder of the case files.
    progress: called with a line before each solve.

    Raises
    ------
    CaseError
        If a case file is missing or wrong.
    """
    if not (cases / WALLS[0]).exists():
        raise CaseError(
            f"{cases / WALLS[0]}: no such file: run in a clone of the repository, or name its folder of "
            "case files with --cases"
        )
    factors, residuals, missed = [], [], []
    for number, name in enumerate(WALLS, start=1):
        scene = load(cases / name)
        progress(f"wall {number}: associative, CVXPY")
        cvxpy = solve(scene, "static")
        progress(f"wall {number}: associative, Pyomo")
        pyomo = solve(scene, "static", model="pyomo")
        progress(f"wall {number}: loop")
        loop = solve(scene, "nonassociative")
        for reference, result in (("associative", cvxpy), ("associative", pyomo), ("nonassociative", loop)):
            missed += misses(scene, reference, result)
        factors.append(_factor_row(number, scene, cvxpy, pyomo, loop))
        residuals.append(_residual_row(number, scene, loop))
    return Table1(pd.DataFrame(factors), pd.DataFrame(residuals), tuple(missed))


def misses(scene: Scene, reference: str, result: Result) -> list[str]:
    """A line if a result has other block or joint counts than published, or leaves the tolerance."""
    lines = []
    for count in ("blocks", "joints"):
        if count in scene.reference and getattr(result.size, count) != scene.reference[count].value:
            lines.append(
                f"{scene.origin}: {getattr(result.size, count)} {count}, published: "
                f"{scene.reference[count].value:.0f}"
            )
    published = scene.reference[reference]
    what = f"{scene.origin}: {reference} ({result.model}, {result.solver})"
    if result.load_factor is None:
        return [*lines, f"{what}: {result.status}: {result.message}"]
    off = abs(result.load_factor / published.value - 1)
    if published.tolerance is not None and off > published.tolerance:
        lines.append(
            f"{what}: {result.load_factor:.7f}, published {published.value}, off by {off:.1e} "
            f"(tolerance {published.tolerance:.1e})"
        )
    return lines


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


def _factor_row(number: int, scene: Scene, cvxpy: Result, pyomo: Result, loop: Result) -> dict[str, object]:
    published = _published(scene, "nonassociative")
    value = loop.load_factor if loop.load_factor is not None else float("nan")
    return {
        "wall": number,
        "b × c": f"{loop.size.blocks} × {loop.size.joints}",
        "associative, paper": _published(scene, "associative"),
        "CVXPY + Clarabel": cvxpy.load_factor,
        "Pyomo + HiGHS": pyomo.load_factor,
        "MCP, published": _published(scene, "mcp"),
        "MPEC, published": _published(scene, "mpec"),
        "loop, paper": published,
        "loop": value,
        "loop - paper (%)": 100 * (value / published - 1),
    }


def _residual_row(number: int, scene: Scene, loop: Result) -> dict[str, object]:
    residuals = loop.certificate.as_dict() if loop.certificate else {}
    return {
        "wall": number,
        "status": str(loop.status),
        **{name: residuals.get(name, float("nan")) for name in residuals},
        "sub-problems": loop.lp_solves,
        "time (s)": sum(loop.seconds.values()),
        "time, paper (s)": _published(scene, "nonassociative_seconds"),
    }
