"""Atlas, first part: failures of the loop, its parameters and the solvers, on scenes that have an answer."""

from atlas.entry import Entry, Expectation
from atlas.expectations import (
    AGAIN,
    OTHERS,
    RAW,
    REMEDIED,
    TWO_FORMULATIONS,
    WITHOUT_HALVING,
    associative,
    default,
    loops,
    references,
)
from atlas.small_scenes import block, bonded, ferris_tinloi

from masonry_opt.answer.reasons import Code, Status, reason

#: Two paths to the base, round an opening, whose load factors lie near each other.
TWO_PATHS = bonded([[0.5, 1, 1, 0.5], [1, -1, 1], [0.5, 1, 1, 0.5]], (4, 1), 0.8)
#: Others on which the small cohesion decides, or a vertex.
STUCK = bonded([[0.5, 1, 1, 0.5], [1, -1, 1], [0.5, 1, -1, 0.5], [1, 1, 1]], (4, 1), 0.8)
PENETRATING = bonded([[0.5, 1, 1, 1, 0.5], [1, -1, 1, 1], [0.5, 1, 1, 1, 0.5]], (4, 1), 0.8)
#: The lowest exact state known of wall 6, to 1 % above the paper's.
NEAR_WALL_6, LOWEST = (0.291780, 0.29649 * 1.01), "lowest exact state known, to 1 % above the paper's"
STEPPED = bonded([[0.5, 1, 1, 0.5], [1, -1, 1], [0.5, -1, 1, 0.5], [1, 1, 1]], (4, 3), 0.65)

ENTRIES: tuple[Entry, ...] = (
    Entry(
        "cycling on wall 6",
        "With β = 1 the shear limits follow the last normal forces alone and the loop swings between states. "
        "In a vertex no state is left, and it begins again with a smaller slope; the warm-started simplex of "
        "Pyomo's HiGHS leads to a state 1.2 % below the paper's.",
        ferris_tinloi(6),
        (
            *loops(
                Status.CYCLING,
                solvers=(None,),
                options={"beta": 1.0, **WITHOUT_HALVING, **RAW},
                why=reason(Code.REPEATS),
            ),
            *loops(
                Status.CONVERGED,
                (0.29649, 0.30087),
                "a state on the mechanism of the cycle: the paper's to the highest of the swing",
                (None,),
                options={"beta": 1.0, **WITHOUT_HALVING},
                why=reason(Code.REPEATS, period=2),
            ),
            *loops(Status.CONVERGED, NEAR_WALL_6, LOWEST, (None,), options={"beta": 1.0}, why=REMEDIED),
            *loops(Status.CONVERGED, 0.29649, "paper, Table 1 (β = 0.6)", (None,), tolerance=3e-4),
            *loops(Status.CONVERGED, 0.29649, "paper, Table 1", ("highs",), tolerance=3e-4, why=AGAIN),
            *loops(Status.CONVERGED, NEAR_WALL_6, LOWEST, ("highs",), model="pyomo", options=RAW),
            *loops(Status.CONVERGED, NEAR_WALL_6, LOWEST, ("highs",), model="pyomo"),
            default((0.291780, 0.29649), "lowest exact state known, to the paper's"),
        ),
    ),
    Entry(
        "cycling between near-equal load paths",
        "Two ways round an opening carry nearly the same λ: each turn of the shear limits sends the load the "
        "other way.",
        TWO_PATHS,
        (
            *loops(
                Status.CYCLING,
                solvers=("clarabel", "highs"),
                options={"beta": 1.0, **RAW},
                why=reason(Code.REPEATS, period=2),
            ),
            *loops(
                Status.SOLVER_FAILED,
                solvers=("highs-ipm",),
                options={"beta": 1.0, **RAW},
                why=reason(Code.SUB_PROBLEM_FAILED),
            ),
            *(
                expectation
                for solvers, why in (
                    (("clarabel",), reason(Code.REPEATS, exact=True)),
                    (("highs",), reason(Code.BEGAN_AGAIN, remedies="beta=0.5")),
                    (("highs-ipm",), reason(Code.BEGAN_AGAIN, remedies="solver=clarabel")),
                )
                for expectation in loops(
                    Status.CONVERGED,
                    13 / 17,
                    TWO_FORMULATIONS,
                    solvers,
                    options={"beta": 1.0},
                    why=why,
                    tolerance=1e-6,
                )
            ),
            *loops(Status.CONVERGED, 13 / 17, TWO_FORMULATIONS, tolerance=2e-4),
            *associative(Status.OPTIMAL, 79 / 101, OTHERS),
            *references(13 / 17, TWO_FORMULATIONS),
            default(13 / 17, TWO_FORMULATIONS),
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
            default(0.6439628, TWO_FORMULATIONS),
        ),
    ),
    Entry(
        "c₀ = 0: uncontrolled penetration",
        "Both limits of a joint at n = 0 are active at once, and slip of both senses together closes the "
        "joint at no cost: blocks pass into each other, below any Coulomb λ. The certificate would show "
        "it; with forces at both ends of a joint no solver ends there.",
        PENETRATING,
        (
            *loops(
                Status.CONVERGED,
                0.7784431,
                TWO_FORMULATIONS,
                ("highs",),
                tolerance=5e-5,
                options={"c0": 0.0, **RAW},
            ),
            *loops(Status.CONVERGED, 0.7784431, TWO_FORMULATIONS, tolerance=5e-5, options={"c0": 0.0}),
            *loops(Status.CONVERGED, 0.7784431, TWO_FORMULATIONS, tolerance=5e-5),
            *references(0.7784431, TWO_FORMULATIONS),
            default(0.7784431, TWO_FORMULATIONS),
        ),
    ),
    Entry(
        "a vertex locks joints: wall 3",
        "Simplex ends in a vertex, where many joints have n = 0: their limits may close until no state is "
        "left, as on wall 6. Here it comes through.",
        ferris_tinloi(3),
        (
            *loops(Status.CONVERGED, 0.355817, "published MPEC"),
            *loops(Status.CONVERGED, 0.355817, "published MPEC", ("highs",), model="pyomo"),
            default(0.355817, "published MPEC"),
        ),
    ),
    Entry(
        "a vertex locks joints: wall 4",
        "As wall 3; and where the loop does not stop at once, the state it ends in depends on the vertex.",
        ferris_tinloi(4),
        (
            *loops(Status.CONVERGED, 0.263736, "published MPEC", ("highs", "clarabel")),
            *(
                Expectation(
                    Status.CONVERGED,
                    model=model,
                    solver=solver,
                    load_factor=(0.263736, 0.331949),
                    source="published MPEC to associative: 0.307 was seen, 16 % above the MPEC",
                )
                for model, solver in (("pyomo", "highs"), ("cvxpy", "highs-ipm"))
            ),
            default(0.263736, "published MPEC"),
        ),
    ),
    Entry(
        "a vertex locks joints: wall 5",
        "As wall 3, with the vertices of HiGHS in Pyomo's form of the program, or with c₀ = 0.",
        ferris_tinloi(5),
        (
            *(
                expectation
                for solver, how in (("highs", {"model": "pyomo"}), ("clarabel", {"options": {"c0": 0.0}}))
                for expectation in loops(
                    Status.CONVERGED, 0.21455, "paper, Table 1", (solver,), tolerance=3e-4, **how
                )
            ),
            default((0.207973, 0.21455), "lowest exact state known, to the paper's"),
        ),
    ),
    Entry(
        "interior point without crossover",
        "HiGHS's interior point without crossover ends with 'unknown', or so near a vertex that joints lock: "
        "neither is an answer.",
        STEPPED,
        (
            *loops(
                Status.NO_STATE,
                solvers=("highs", "highs-ipm"),
                options={"c0": 0.0, "start": "cohesive"},
                why=reason(Code.SUB_PROBLEM_EMPTY),
            ),
            *loops(Status.NO_STATE, options=RAW, why=reason(Code.SUB_PROBLEM_EMPTY)),
            *loops(Status.CONVERGED, 0.364840847, TWO_FORMULATIONS, ("clarabel",), why=AGAIN),
            *loops(Status.NO_STATE, solvers=("highs", "highs-ipm"), why=reason(Code.SUB_PROBLEM_EMPTY)),
            *associative(Status.OPTIMAL, 0.4190270, OTHERS),
            *references(0.364840847, TWO_FORMULATIONS),
            default(0.364840847, TWO_FORMULATIONS),
        ),
    ),
    Entry(
        "a vertex from a cohesive start: wall 1",
        "From trial cohesion simplex soon ends in a vertex from which no state is left, or with 'unknown', "
        "which must be a status and no traceback; an interior point goes on. The MPEC, from zeros, fails "
        "(wall 5) or takes longer, as here.",
        ferris_tinloi(1),
        (
            *loops(
                Status.NO_STATE,
                solvers=("highs",),
                options={"start": "cohesive"},
                why=reason(Code.SUB_PROBLEM_EMPTY),
            ),
            *loops(
                Status.CONVERGED,
                0.63982,
                "paper, Table 1",
                (None,),
                options={"start": "cohesive"},
                tolerance=3e-4,
            ),
            Expectation(
                Status.CONVERGED,
                "mpec",
                options={"start": "cold"},
                load_factor=0.638982,
                source="lowest exact state known",
            ),
            default(0.638982, "lowest exact state known"),
        ),
    ),
    Entry(
        "a first-order solver",
        "SCS comes with CVXPY; it solves to a few digits, and reports in a form of its own.",
        block(1, 2, 0.6),
        (
            *(
                Expectation(
                    Status.OPTIMAL, "static", solver=name, load_factor=0.5, tolerance=1e-3, source="w / h"
                )
                for name in ("scs", "osqp")
            ),
        ),
    ),
)
