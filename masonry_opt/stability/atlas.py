"""The failure atlas: small scenes, each built so that a named method fails, and what every method and
solver must answer. Every expectation stands here. Adding a failure is one entry."""

from __future__ import annotations

from typing import Any

from masonry_opt.analysis.status import Status
from masonry_opt.errors import CaseError
from masonry_opt.stability.entry import Entry, Run
from masonry_opt.stability.scenes import (
    apart,
    block,
    bonded,
    chute,
    clamped_h,
    confined,
    ferris_tinloi,
    four_in_a_point,
    groove,
    overhanging,
    pebble,
    short_bearing,
    slabs,
    two_blocks,
)

#: The loop stops at a relative change of λ of 1e-5 and leaves the small cohesion's trace.
LOOP = 2e-5

#: HiGHS and Clarabel solve to 1e-9; friction in the hundred thousands costs digits.
COARSE = 1e-5

#: IPOPT's last relaxation, ε = 3e-9.
MPEC = 1e-7

#: Enough for scenes this small, where the first state is the lowest but for a few.
FEW_KICKS = 10

WITHOUT_HALVING = {"alpha": 0.0, "alpha_min": 0.0}
AGAIN = "began again with alpha"
LOCKS = "dilatancy locks the associative start, so the loop started cohesive"
NO_INFLUENCE = "the flow rule has no influence"
WRONG_BY_WEIGHT = (
    "the live load is 1e-8 of the dead load: the forces out of balance that a solver leaves, or that the "
    "small cohesion lets through, exceed it; such a λ must be refused if it cannot be found"
)
LETS_UNKNOWN_THROUGH = "CVXPY raises ValueError on HiGHS's 'unknown', which the driver lets through"

SOLVERS = ("clarabel", "highs", "highs-ipm")


def associative(
    expected: Status | type[CaseError],
    load_factor: float | tuple[float, float] | None = None,
    source: str = "",
    **keys: Any,
) -> tuple[Run, ...]:
    """The static program in three solvers, and the kinematic one in Pyomo."""
    return (
        *(
            Run(expected, "static", solver=name, load_factor=load_factor, source=source, **keys)
            for name in SOLVERS
        ),
        Run(expected, "kinematic", "pyomo", load_factor=load_factor, source=source, **keys),
    )


def loops(
    expected: Status | type[CaseError],
    load_factor: float | tuple[float, float] | None = None,
    source: str = "",
    solvers: tuple[str, ...] = SOLVERS,
    tolerance: float = LOOP,
    **keys: Any,
) -> tuple[Run, ...]:
    """The loop in CVXPY, in some solvers."""
    return tuple(
        Run(expected, solver=name, load_factor=load_factor, source=source, tolerance=tolerance, **keys)
        for name in solvers
    )


def references(
    load_factor: float | tuple[float, float],
    source: str,
    proven: bool | None = None,
    cold: Status = Status.CONVERGED,
) -> tuple[Run, ...]:
    """The refinement, the MPEC warm and cold, and the bracket (``proven`` or not; None: not asked)."""
    found: dict[str, Any] = {"load_factor": load_factor, "source": source}
    cold_found = found if cold.usable else {}
    runs = [
        Run(Status.CONVERGED, "refined", options={"kicks": FEW_KICKS}, **found),
        Run(Status.CONVERGED, "mpec", tolerance=MPEC, **found),
        Run(cold, "mpec", options={"start": "cold"}, tolerance=MPEC, **cold_found),
    ]
    if proven is not None:
        runs.append(Run(Status.OPTIMAL if proven else Status.CONVERGED, "global", **found))
    return tuple(runs)


def every_method(expected: Status, says: str = "", cold: Status | None = None) -> tuple[Run, ...]:
    """A status that every method must give."""
    return (
        *associative(expected, says=says),
        *loops(expected, says=says),
        Run(expected, options={"start": "cohesive"}, says=says),
        Run(expected, "refined", says=says),
        Run(expected, "global", says=says),
        Run(expected, "mpec", says=says),
        Run(cold or expected, "mpec", options={"start": "cold"}, says="" if cold else says),
    )


#: Two paths to the base, round an opening, whose load factors lie near each other.
TWO_PATHS = bonded([[0.5, 1, 1, 0.5], [1, -1, 1], [0.5, 1, 1, 0.5]], (4, 1), 0.8)
#: Others on which the small cohesion decides, or a vertex.
STUCK = bonded([[0.5, 1, 1, 0.5], [1, -1, 1], [0.5, 1, -1, 0.5], [1, 1, 1]], (4, 1), 0.8)
PENETRATING = bonded([[0.5, 1, 1, 1, 0.5], [1, -1, 1, 1], [0.5, 1, 1, 1, 0.5]], (4, 1), 0.8)
STEPPED = bonded([[0.5, 1, 1, 0.5], [1, -1, 1], [0.5, -1, 1, 0.5], [1, 1, 1]], (4, 3), 0.65)
SOLID: list[list[float]] = [[0.5, 1, 1, 0.5], [1, 1, 1], [0.5, 1, 1, 0.5], [1, 1, 1]]

TWO_FORMULATIONS = "MPEC and refinement, which agree"
OTHERS = "static and kinematic, three solvers, which agree"

ATLAS: tuple[Entry, ...] = (
    Entry(
        "cycling on wall 6",
        "With β = 1 the shear limits follow the last normal forces alone and the loop swings between states.",
        ferris_tinloi(6),
        (
            Run(Status.CYCLING, options={"beta": 1.0, **WITHOUT_HALVING}, says="lower 'beta'"),
            Run(Status.CYCLING, options={"beta": 1.0}, says="lower 'beta'", slow=True),
            Run(Status.CONVERGED, load_factor=0.29649, tolerance=3e-4, source="paper, Table 1 (β = 0.6)"),
        ),
    ),
    Entry(
        "cycling between near-equal load paths",
        "Two ways round an opening carry nearly the same λ: each turn of the shear limits sends the load the "
        "other way.",
        TWO_PATHS,
        (
            *loops(Status.CYCLING, options={"beta": 1.0}, says="every 2 iterations"),
            *loops(Status.CONVERGED, 13 / 17, TWO_FORMULATIONS, tolerance=2e-4),
            *associative(Status.OPTIMAL, 79 / 101, OTHERS),
            *references(13 / 17, TWO_FORMULATIONS),
        ),
    ),
    Entry(
        "locking by dilatancy: confined block",
        "Between fixed faces a block that dilates cannot slide: associative λ is unlimited. Without "
        "dilatancy friction at the floor resists alone, λ = μ W, unless the block is prestressed.",
        confined(0.5),
        (
            *associative(Status.LOCKED),
            *loops(Status.CONVERGED, 0.5, "μ W", says=LOCKS),
            *references(0.5, "μ W", proven=None, cold=Status.HOMOTOPY),
            Run(Status.CONVERGED, "global", load_factor=0.5, source="μ W"),
        ),
    ),
    Entry(
        "locking by dilatancy: clamped H",
        "The web of an H hangs between flanges that cannot spread: with dilatancy it cannot slip at all. "
        "Friction under the clamping force P alone holds λ + W = 2 μ P.",
        clamped_h(0.5, 4.0),
        (
            *associative(Status.LOCKED),
            *loops(Status.CONVERGED, 3.0, "2 μ P - W", says=LOCKS),
            Run(
                Status.CONVERGED,
                options={"start": "cohesive"},
                load_factor=3.0,
                tolerance=LOOP,
                source="2 μ P - W",
            ),
            *references(3.0, "2 μ P - W", proven=None),
            Run(Status.CONVERGED, "global", load_factor=3.0, source="2 μ P - W"),
        ),
    ),
    Entry(
        "c₀ = 0: stuck at the associative answer",
        "Joints without normal force get the limits |s| ≤ -αμn, can never be loaded again, and λ stands "
        "still where it began.",
        STUCK,
        (
            *loops(Status.CONVERGED, 0.6918799, "the associative λ, 7 % too high", options={"c0": 0.0}),
            *loops(Status.CONVERGED, 0.6439628, TWO_FORMULATIONS),
            *associative(Status.OPTIMAL, 0.6918799, OTHERS),
            *references(0.6439628, TWO_FORMULATIONS),
        ),
    ),
    Entry(
        "c₀ = 0: uncontrolled penetration",
        "Both limits of a joint at n = 0 are active at once, and slip of both senses together closes the "
        "joint at no cost: blocks pass into each other, below any Coulomb λ. The certificate shows it.",
        PENETRATING,
        (
            Run(
                Status.CONVERGED,
                solver="highs",
                options={"c0": 0.0},
                load_factor=0.7483785,
                source="4 % below the least Coulomb state known: blocks penetrate",
                flow=0.9,
            ),
            *loops(
                Status.CONVERGED,
                0.7784431,
                TWO_FORMULATIONS,
                ("clarabel", "highs-ipm"),
                tolerance=5e-5,
                options={"c0": 0.0},
            ),
            *loops(Status.CONVERGED, 0.7784431, TWO_FORMULATIONS, tolerance=5e-5),
            *references(0.7784431, TWO_FORMULATIONS),
        ),
    ),
    Entry(
        "a vertex locks joints: wall 3",
        "Simplex ends in a vertex, where many joints have n = 0: their limits close and no state is left.",
        ferris_tinloi(3),
        (
            *loops(Status.CONVERGED, 0.355817, "published MPEC", ("highs",), says=AGAIN),
            Run(
                Status.CONVERGED,
                model="pyomo",
                solver="highs",
                load_factor=0.355817,
                tolerance=LOOP,
                source="published MPEC",
                says=AGAIN,
            ),
            *loops(Status.CONVERGED, 0.355817, "published MPEC", ("clarabel", "highs-ipm")),
        ),
    ),
    Entry(
        "a vertex locks joints: wall 4",
        "As wall 3; and where the loop does not stop at once, the state it ends in depends on the vertex.",
        ferris_tinloi(4),
        (
            *loops(Status.CONVERGED, 0.263736, "published MPEC", ("highs",), says=AGAIN),
            *loops(Status.CONVERGED, 0.263736, "published MPEC", ("clarabel",)),
            *(
                Run(
                    Status.CONVERGED,
                    model=model,
                    solver=solver,
                    load_factor=(0.263736, 0.331949),
                    source="published MPEC to associative: 0.307 was seen, 16 % above the MPEC",
                )
                for model, solver in (("pyomo", "highs"), ("cvxpy", "highs-ipm"))
            ),
        ),
    ),
    Entry(
        "a vertex locks joints: wall 5",
        "As wall 3, with the vertices that HiGHS finds in Pyomo's form of the program, or with c₀ = 0.",
        ferris_tinloi(5),
        (
            Run(
                Status.CONVERGED,
                model="pyomo",
                solver="highs",
                load_factor=0.21455,
                tolerance=3e-4,
                source="paper, Table 1",
                says=AGAIN,
            ),
            *loops(
                Status.CONVERGED,
                0.21455,
                "paper, Table 1",
                ("clarabel",),
                tolerance=3e-4,
                options={"c0": 0.0},
                says=AGAIN,
            ),
            Run(Status.HOMOTOPY, "mpec", options={"start": "cold"}, says="start from the loop", slow=True),
        ),
    ),
    Entry(
        "interior point without crossover",
        "HiGHS's interior point without crossover ends with 'unknown', or so near a vertex that joints lock: "
        "neither is an answer.",
        STEPPED,
        (
            Run(
                Status.SOLVER_FAILED,
                solver="highs-ipm",
                options={"c0": 0.0, "start": "cohesive"},
                says="nknown",
                defect=LETS_UNKNOWN_THROUGH,
            ),
            Run(
                Status.SOLVER_FAILED,
                solver="highs",
                options={"c0": 0.0, "start": "cohesive"},
                says="nknown",
                defect=LETS_UNKNOWN_THROUGH,
            ),
            *loops(Status.NO_STATE, solvers=("highs-ipm",), says=AGAIN),
            *loops(Status.CONVERGED, 0.364840847, TWO_FORMULATIONS, ("clarabel", "highs"), says=AGAIN),
            *associative(Status.OPTIMAL, 0.4190270, OTHERS),
            *references(0.364840847, TWO_FORMULATIONS),
        ),
    ),
    Entry(
        "a vertex from a cohesive start: wall 1",
        "From trial cohesion simplex soon ends with 'unknown', which must be a status and no traceback.",
        ferris_tinloi(1),
        (
            Run(
                Status.SOLVER_FAILED,
                solver="highs",
                options={"start": "cohesive"},
                says="nknown",
                defect=LETS_UNKNOWN_THROUGH,
            ),
            Run(
                Status.CONVERGED,
                options={"start": "cohesive"},
                load_factor=0.63982,
                tolerance=3e-4,
                source="paper, Table 1",
            ),
        ),
    ),
    Entry(
        "a first-order solver",
        "SCS comes with CVXPY; it solves to a few digits, and reports in a form of its own.",
        block(1, 2, 0.6),
        (
            Run(
                Status.OPTIMAL,
                "static",
                solver="scs",
                load_factor=0.5,
                tolerance=1e-3,
                source="w / h",
                defect="the driver takes SCS's report for one of HiGHS: AttributeError",
            ),
            Run(Status.OPTIMAL, "static", solver="osqp", load_factor=0.5, tolerance=1e-3, source="w / h"),
        ),
    ),
    Entry(
        "a solver that ends 'unknown': wall 6",
        "The warm-started simplex of Pyomo's HiGHS gives up at the fourth sub-problem.",
        ferris_tinloi(6),
        (Run(Status.SOLVER_FAILED, model="pyomo", solver="highs", says="'unknown'"),),
    ),
    Entry(
        "MPEC from a cold start: wall 1",
        "Nothing to begin from but zeros: IPOPT fails (wall 5, the confined block) or takes longer, as here, "
        "where it reaches the published value all the same.",
        ferris_tinloi(1),
        (
            Run(
                Status.CONVERGED,
                "mpec",
                options={"start": "cold"},
                load_factor=0.638982,
                source="lowest exact state known",
                slow=True,
            ),
            Run(
                Status.CONVERGED,
                "mpec",
                load_factor=0.638982,
                source="lowest exact state known",
                slow=True,
            ),
        ),
    ),
    Entry(
        "unstable under dead load",
        "A block lies with its centroid beyond the edge that bears it: no λ at all, and its name is given.",
        overhanging(),
        every_method(Status.UNSTABLE, says="'B'"),
    ),
    Entry(
        "live load that does no work",
        "The only motion is at a right angle to the live load.",
        chute(),
        every_method(Status.UNLIMITED, says="no mechanism lets the live load do work", cold=Status.HOMOTOPY),
    ),
    Entry(
        "live load that cannot cause collapse",
        "A live load straight down on a block that lies on the ground: every motion works against it.",
        block(1, 1, 0.5, live=(0.0, -1.0)),
        every_method(Status.UNLIMITED, says="no mechanism lets the live load do work", cold=Status.HOMOTOPY),
    ),
    Entry(
        "μ = 0: nothing resists",
        "A flat smooth block slides at λ = 0, of which no relative tolerance is anything.",
        block(4, 1, 0.0),
        (
            *associative(Status.OPTIMAL, 0.0, "closed form"),
            *loops(Status.CONVERGED, 0.0, "closed form", tolerance=1e-8, says=NO_INFLUENCE),
            Run(Status.CONVERGED, options={"start": "cohesive"}, load_factor=0.0, source="closed form"),
            *references(0.0, "closed form", proven=True),
        ),
    ),
    Entry(
        "μ = 0: held by shape",
        "A square in a smooth groove at 45° climbs the face when λ = tan 45°.",
        groove(),
        (
            *associative(Status.OPTIMAL, 1.0, "tan 45°"),
            *loops(Status.CONVERGED, 1.0, "tan 45°", says=NO_INFLUENCE),
            *references(1.0, "tan 45°", proven=True),
        ),
    ),
    Entry(
        "μ very large: one block",
        "Rows of friction 1e6 beside rows of 1.",
        block(1, 2, 1e6),
        (
            *associative(Status.OPTIMAL, 0.5, "w / h"),
            *loops(Status.CONVERGED, 0.5, "w / h", says=NO_INFLUENCE),
            *references(0.5, "w / h", proven=True),
        ),
    ),
    Entry(
        "μ very large: wall 1",
        "With μ = 1e5 in 83 joints Clarabel does not reach its tolerances, and must say so. The wall, 20 by "
        "10.5, overturns in one piece.",
        ferris_tinloi(1, friction=1e5),
        (
            Run(Status.SOLVER_FAILED, "static", says="AlmostSolved"),
            Run(Status.SOLVER_FAILED, says="AlmostSolved"),
            *(
                Run(
                    Status.OPTIMAL,
                    "static",
                    solver=name,
                    load_factor=20 / 10.5,
                    tolerance=COARSE,
                    source="w / h",
                )
                for name in ("highs", "highs-ipm")
            ),
            *loops(Status.CONVERGED, 20 / 10.5, "w / h", ("highs", "highs-ipm")),
        ),
    ),
    Entry(
        "μ large: wall 3",
        "With μ = 10 the cap c / (αμ) on normal forces is so low that every slope locks joints.",
        ferris_tinloi(3, friction=10.0),
        (
            *loops(Status.NO_STATE, says=AGAIN),
            Run(
                Status.CONVERGED,
                options={"start": "cohesive"},
                load_factor=(0.0, 0.6833480),
                source="at most the associative λ",
            ),
            *associative(Status.OPTIMAL, 0.6833480, OTHERS),
        ),
    ),
    Entry(
        "joint 10⁻⁶ of a block long",
        "A slab whose second bearing is 4e-6 of its 4 long; it slides at λ = μ.",
        short_bearing(4e-6, 1e-9),
        (
            *associative(Status.OPTIMAL, 0.5, "μ"),
            *loops(Status.CONVERGED, 0.5, "μ"),
            *references(0.5, "μ", proven=True),
        ),
    ),
    Entry(
        "joint shorter than the tolerance",
        "The same bearing is nothing by default (1e-6 of the scene): the slab falls off its other support.",
        short_bearing(4e-6, None),
        every_method(Status.UNSTABLE, says="'slab'"),
    ),
    Entry(
        "sizes 1 : 10⁴, both pushed",
        "Weights 1 : 10⁸ in one program; either block slides at λ = μ.",
        pebble(1e4, push_both=True),
        (
            *associative(Status.OPTIMAL, 0.4, "μ"),
            *loops(Status.CONVERGED, 0.4, "μ"),
            *references(0.4, "μ", proven=False),
        ),
    ),
    Entry(
        "sizes 1 : 10⁴, the small one pushed",
        "The pebble slides at λ = μ, but its weight is lost in what solvers leave of the boulder's.",
        pebble(1e4, push_both=False),
        (
            *(
                Run(Status.OPTIMAL, method, model, name, load_factor=0.4, source="μ")
                for method, model, name in (
                    ("static", "cvxpy", "highs"),
                    ("static", "cvxpy", "highs-ipm"),
                    ("kinematic", "pyomo", "highs"),
                )
            ),
            *loops(Status.CONVERGED, 0.4, "μ", ("highs", "highs-ipm")),
            *(
                Run(
                    Status.OPTIMAL if method == "static" else Status.CONVERGED,
                    method,
                    options=options,
                    load_factor=0.4,
                    tolerance=LOOP,
                    source="μ",
                    defect=WRONG_BY_WEIGHT,
                )
                for method, options in (
                    ("static", {}),
                    ("nonassociative", {}),
                    ("nonassociative", {"start": "cohesive"}),
                    ("refined", {}),
                    ("mpec", {}),
                )
            ),
            Run(Status.SOLVER_FAILED, "global", says="no exact state"),
        ),
    ),
    *(
        Entry(
            f"coordinates {shift:g} from the origin",
            "Digits are lost in the coordinates: joints must be found, and λ = μ (the bottom course slides).",
            bonded(SOLID, (4, 1.75), 0.65, shift),
            (
                *associative(Status.OPTIMAL, 0.65, "μ"),
                *loops(Status.CONVERGED, 0.65, "μ"),
            ),
        )
        for shift in (1e6, 1e12)
    ),
    *(
        Entry(
            f"{'gap' if gap > 0 else 'overlap'} of {abs(gap) / 1e-3:g} tolerances",
            "Within the tolerance the blocks touch; beyond it the scene is refused, with their names.",
            apart(gap, 1e-3),
            (
                (*associative(Status.OPTIMAL, 0.65, "μ"), *loops(Status.CONVERGED, 0.65, "μ"))
                if abs(gap) < 1e-3
                else (Run(CaseError, "static", says=says), Run(CaseError, says=says))
            ),
        )
        for gap, says in (
            (0.99e-3, ""),
            (1.01e-3, "'B' touches no other block"),
            (-0.99e-3, ""),
            (-1.01e-3, "'A' and 'B' overlap"),
        )
    ),
    Entry(
        "four blocks in a point",
        "No joint may be made of the point. Two columns that overturn each about its own toe: λ = w / h.",
        four_in_a_point(0.65),
        (
            *associative(Status.OPTIMAL, 0.55401662, OTHERS),
            *loops(Status.CONVERGED, 0.5, "w / h"),
            *references(0.5, "w / h", proven=False),
        ),
    ),
    Entry(
        "many mechanisms of one λ",
        "A pile of six slabs slides in any of six joints, or several, at λ = μ.",
        slabs(6, 0.3),
        (
            *associative(Status.OPTIMAL, 0.3, "μ"),
            *loops(Status.CONVERGED, 0.3, "μ"),
            *references(0.3, "μ", proven=False),
        ),
    ),
    Entry(
        "many load factors of one mechanism",
        "Fig. 6: what B lays on A is indeterminate, 1.5 μ ≤ λ ≤ 2.5 μ. With α = 0 any may come; contraction "
        "finds the least.",
        two_blocks(0.1),
        (
            *associative(Status.OPTIMAL, 0.25, "2.5 μ"),
            *loops(
                Status.CONVERGED,
                (0.15 * (1 - LOOP), 0.25 * (1 + LOOP)),
                "1.5 μ to 2.5 μ",
                options=WITHOUT_HALVING,
            ),
            *loops(Status.CONVERGED, 0.15, "1.5 μ", tolerance=1e-3),
            *references(0.15, "1.5 μ", proven=True),
        ),
    ),
)
