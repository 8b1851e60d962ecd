"""
Table 1: the six walls of Ferris & Tin-Loi
==========================================

The table compares five computed load factors with published values. These are the associative load factor,
the paper's loop, exact Coulomb states (compared with the mixed complementarity problem, MCP, of Ferris &
Tin-Loi 2001), and their MPEC. The incremental load factor has a column of its own; the loop and the MCP are
close to it. The lowest state that a search finds is compared with the lowest known state. All methods have
their default options.

The guide does not run this example. ``masonry-opt reproduce table1`` saves its tables.
"""

from functools import partial

import pandas as pd

import masonry_opt as mo
from masonry_opt.scene.case_file import case_folder
from masonry_opt.studies.runner import Workers

#: For each column, the method, its options, and the value of the case file with which it is compared.
COLUMNS = {
    "mpec": ("mpec", {}, "mpec"),
    "search": ("coulomb", {"search": 30.0}, "refined"),
    "loop": ("nonassociative", {}, "nonassociative"),
    "coulomb": ("coulomb", {}, "mcp"),
    "incremental": ("incremental", {}, "nonassociative"),
    "CVXPY": ("static", {"model": "cvxpy"}, "associative"),
    "Pyomo": ("static", {"model": "pyomo"}, "associative"),
}
WALLS = {n: mo.load(case_folder() / "ferris_tinloi" / f"wall_{n}.toml") for n in range(1, 7)}


def published(wall: int, name: str) -> float:
    """Return a reference value of the wall's case file; NaN if the file does not contain it."""
    known = WALLS[wall].reference.get(name)
    return known.value if known else float("nan")


# %%
# Each solve runs in its own process, and the longest solves start first. A search ends at the lowest known
# state, or after 30 s.
parts = [(wall, column) for column in COLUMNS for wall in reversed(WALLS)]
solves = []
for wall, column in parts:
    method, options, name = COLUMNS[column]
    if column == "search":
        options = options | {"until": published(wall, name) * (1 + 4e-6)}
    solves.append(partial(mo.solve, WALLS[wall], method, incremental=False, **options))
with Workers() as workers:
    results = {part: end.result for part, end in workers.map(zip(parts, solves, strict=True))}
found = {at: result.required() for at, result in results.items()}
found |= {(wall, "incremental"): results[wall, "incremental"].incremental for wall in WALLS}

# %%
# Each row of the table is a wall. The Coulomb problem has many states. The solver of the MCP, the default
# (``coulomb``), the loop and the MPEC end in different states. Method ``incremental`` selects one state, by
# elastic contacts and a load history from rest.
table = pd.DataFrame(
    {
        "wall": wall,
        "b × c": f"{results[wall, 'loop'].size.blocks} × {results[wall, 'loop'].size.joints}",
        "assoc. paper": published(wall, "associative"),
        "CVXPY": found[wall, "CVXPY"],
        "Pyomo": found[wall, "Pyomo"],
        "loop paper": published(wall, "nonassociative"),
        "loop": found[wall, "loop"],
        "loop diff %": 100 * (found[wall, "loop"] / published(wall, "nonassociative") - 1),
        "MCP publ.": published(wall, "mcp"),
        "coulomb": found[wall, "coulomb"],
        "coulomb diff %": 100 * (found[wall, "coulomb"] / published(wall, "mcp") - 1),
        "incremental": found[wall, "incremental"],
        "MPEC publ.": published(wall, "mpec"),
        "mpec": found[wall, "mpec"],
        "lowest known": published(wall, "refined"),
        "search": found[wall, "search"],
        "search diff %": 100 * (found[wall, "search"] / published(wall, "refined") - 1),
    }
    for wall in WALLS
)
print(table.to_string(index=False, float_format="{:.5f}".format))

# %%
# The second table contains the residual of each condition, and the number of programs and the time of each
# method. The published times are those of machines of 2001 and 2005.
times = {"loop": "nonassociative_seconds", "mpec": "mpec_seconds"}
table_residuals = pd.DataFrame(
    {
        "wall": wall,
        "method": column,
        "status": str(results[wall, column].status),
        **results[wall, column].certificate.as_dict(),
        "LPs": results[wall, column].lp_solves,
        "NLPs": results[wall, column].nlp_solves,
        "time (s)": sum(results[wall, column].seconds.values()),
        "published (s)": published(wall, times.get(column, "")),
    }
    for wall in WALLS
    for column in ("loop", "coulomb", "mpec", "search")
)
print(table_residuals.to_string(index=False, float_format="{:.2g}".format))

# %%
# The assertions compare these results with published values:
#
# - the associative load factors, to the five published digits
# - the loop, within 3e-4 (wall 5: 2e-3)
# - the MPEC, within 1e-4
# - the incremental load factor with the published loop, within 4e-3, although it is another quantity
# - the default, which is at most 5e-4 above the published MCP
# - the search, which finds the lowest known state of walls 1 to 5
#
# On wall 6 the result of the search depends on the speed of the machine. The search ends at the lowest known
# state or, on a slow machine, above it.
for wall, scene in WALLS.items():
    size, known = results[wall, "loop"].size, scene.reference
    assert (size.blocks, size.joints) == (known["blocks"].value, known["joints"].value), wall
    for column in ("CVXPY", "Pyomo"):
        assert abs(found[wall, column] - published(wall, "associative")) < 5e-6, (wall, column)
    held = ("loop", "mpec", "incremental")
    loop, mpec, incremental = (found[wall, name] / published(wall, COLUMNS[name][2]) - 1 for name in held)
    assert abs(loop) < (2e-3 if wall == 5 else 3e-4), (wall, loop)
    assert abs(mpec) < 1e-4, (wall, mpec)
    assert abs(incremental) < 4e-3, (wall, incremental)
    assert results[wall, "incremental"].reasons[0].code in ("collapse", "range"), wall
    assert found[wall, "coulomb"] < published(wall, "mcp") * (1 + 5e-4), wall
    if wall != 6:
        assert found[wall, "search"] < published(wall, "refined") * (1 + 5e-6), wall
    assert found[wall, "search"] < min(found[wall, "coulomb"], found[wall, "mpec"]) + 1e-7, wall
assert set(table_residuals["status"]) == {"converged"}
exact = table_residuals["method"].isin(["coulomb", "search"])
assert table_residuals.loc[exact, ["equilibrium", "yield", "flow", "complementarity"]].max(axis=None) < 1e-8
