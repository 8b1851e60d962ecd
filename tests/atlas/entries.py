"""The failure atlas: small scenes on which a method or solver may fail, with the expected answers.

Each scene is built to provoke one failure. To add a failure, add an entry to ``ATLAS``.
"""

from atlas import small_scenes as small
from atlas.entry import Entry, Expectation, entry
from atlas.expectations import (
    AGAIN,
    COARSE,
    LOCKS,
    LOOP,
    NO_INFLUENCE,
    OTHERS,
    RAW,
    REMEDIED,
    SOLVERS,
    TWO_FORMULATIONS,
    WITHOUT_HALVING,
    associative,
    by_solver,
    default,
    every_method,
    loops,
    no_state,
    one_answer,
    references,
    refused,
)

from masonry_opt.solution.reasons import Code, Reason, Status, reason

#: A wall with two load paths around an opening, whose load factors are nearly equal.
TWO_PATHS = small.bonded([[0.5, 1, 1, 0.5], [1, -1, 1], [0.5, 1, 1, 0.5]], (4, 1), 0.8)
#: Walls on which the answer of the loop depends on the small cohesion c₀.
STUCK = small.bonded([[0.5, 1, 1, 0.5], [1, -1, 1], [0.5, 1, -1, 0.5], [1, 1, 1]], (4, 1), 0.8)
PENETRATING = small.bonded([[0.5, 1, 1, 1, 0.5], [1, -1, 1, 1], [0.5, 1, 1, 1, 0.5]], (4, 1), 0.8)
#: Interval for wall 6: from the lowest exact state known to 1 % above the paper's value.
NEAR_WALL_6 = (0.291780, 0.29649 * 1.01)
LOWEST = "from the lowest exact state known to 1 % above the paper's λ"
ON_THE_CYCLE = "a state on the mechanism of the cycle: from the paper's λ to the largest λ of the cycle"
UP_TO_ASSOCIATIVE = "from the published MPEC to the associative λ; 0.307 occurred, 16 % above the MPEC"
STEPPED = small.bonded([[0.5, 1, 1, 0.5], [1, -1, 1], [0.5, -1, 1, 0.5], [1, 1, 1]], (4, 3), 0.65)

SWINGING = {"beta": 1.0}
TWICE = reason(Code.REPEATS, period=2)
SOLID: list[list[float]] = [[0.5, 1, 1, 0.5], [1, 1, 1], [0.5, 1, 1, 0.5], [1, 1, 1]]


def cycles(*solvers: str | None, why: Reason | None = None, **options: float) -> tuple[Expectation, ...]:
    """Return the expectations that the loop of the paper cycles between states with the given solvers."""
    swinging, why = SWINGING | options | RAW, why or reason(Code.REPEATS)
    return loops(solvers=solvers, expected=Status.CYCLING, options=swinging, why=why)


ATLAS: tuple[Entry, ...] = (
    # Failures of the loop, its parameters and the solvers, on scenes that have an answer.
    entry(
        "cycling on wall 6",
        "With β = 1, the shear limits depend only on the last normal forces, and the loop cycles between "
        "states. With a simplex solver, a sub-problem then has no state, and the loop starts again with a "
        "smaller slope. The warm-started simplex solver of HiGHS in Pyomo ends at a state 1.2 % below the "
        "paper's load factor.",
        small.ferris_tinloi(6),
        *cycles(None, **WITHOUT_HALVING),
        *loops((0.29649, 0.30087), ON_THE_CYCLE, (None,), options=SWINGING | WITHOUT_HALVING, why=TWICE),
        *loops(NEAR_WALL_6, LOWEST, (None,), options=SWINGING, why=REMEDIED),
        *loops(0.29649, "paper, Table 1 (β = 0.6)", (None,), tolerance=3e-4),
        *loops(0.29649, "paper, Table 1", ("highs",), tolerance=3e-4, why=AGAIN),
        *loops(NEAR_WALL_6, LOWEST, ("highs",), model="pyomo", options=RAW),
        *loops(NEAR_WALL_6, LOWEST, ("highs",), model="pyomo"),
        default((0.291780, 0.29649), "from the lowest exact state known to the paper's λ"),
    ),
    entry(
        "cycling between near-equal load paths",
        "Two load paths around an opening have nearly the same λ. Each update of the shear limits moves the "
        "load to the other path, so the loop cycles.",
        TWO_PATHS,
        *cycles("clarabel", "highs", why=TWICE),
        Expectation(
            solver="highs-ipm",
            options=SWINGING | RAW,
            expected=Status.SOLVER_FAILED,
            why=reason(Code.SUB_PROBLEM_FAILED),
        ),
        *(
            Expectation(load_factor=13 / 17, source=TWO_FORMULATIONS, solver=of, options=SWINGING, why=why)
            for of, why in (
                ("clarabel", reason(Code.REPEATS, exact=True)),
                ("highs", reason(Code.BEGAN_AGAIN, remedies="beta=0.5")),
                ("highs-ipm", by_solver("clarabel")),
            )
        ),
        *loops(13 / 17, TWO_FORMULATIONS, tolerance=2e-4),
        *associative(79 / 101, OTHERS),
        *references(13 / 17, TWO_FORMULATIONS),
        default(13 / 17, TWO_FORMULATIONS),
    ),
    entry(
        "c₀ = 0: stuck at the associative answer",
        "Joints without normal force get the limits |s| ≤ -αμn, so they never carry a force again. λ stays "
        "at the associative load factor.",
        STUCK,
        *loops(0.6918799, "the associative λ, 7 % too high", options={"c0": 0.0}),
        *loops(0.6439628, TWO_FORMULATIONS),
        *associative(0.6918799, OTHERS),
        *references(0.6439628, TWO_FORMULATIONS),
        default(0.6439628, TWO_FORMULATIONS),
    ),
    entry(
        "c₀ = 0: uncontrolled penetration",
        "At a joint with n = 0, both shear limits are active. Slip in both directions then closes the joint "
        "without energy, so blocks penetrate each other, and λ is below that of every Coulomb state. The "
        "certificate would show the penetration. In this program, which has forces at both ends of a joint, "
        "no solver ends at such a state.",
        PENETRATING,
        *loops(0.7784431, TWO_FORMULATIONS, ("highs",), tolerance=5e-5, options={"c0": 0.0, **RAW}),
        *loops(0.7784431, TWO_FORMULATIONS, tolerance=5e-5, options={"c0": 0.0}),
        *loops(0.7784431, TWO_FORMULATIONS, tolerance=5e-5),
        *references(0.7784431, TWO_FORMULATIONS),
        default(0.7784431, TWO_FORMULATIONS),
    ),
    entry(
        "a vertex locks joints: wall 3",
        "The simplex solver ends at a vertex, where many joints have n = 0. The shear limits of such joints "
        "may then exclude all states, as on wall 6. On this wall the loop converges.",
        small.ferris_tinloi(3),
        *loops(0.355817, "published MPEC"),
        *loops(0.355817, "published MPEC", ("highs",), model="pyomo"),
        default(0.355817, "published MPEC"),
    ),
    entry(
        "a vertex locks joints: wall 4",
        "The simplex solver ends at a vertex, as on wall 3. If the loop does not stop at once, its last "
        "state depends on the vertex.",
        small.ferris_tinloi(4),
        *loops(0.263736, "published MPEC", ("highs", "clarabel")),
        *loops((0.263736, 0.331949), UP_TO_ASSOCIATIVE, ("highs",), model="pyomo"),
        *loops((0.263736, 0.331949), UP_TO_ASSOCIATIVE, ("highs-ipm",), model="cvxpy"),
        default(0.263736, "published MPEC"),
    ),
    entry(
        "a vertex locks joints: wall 5",
        "As on wall 3, joints may lock: with the vertices of HiGHS in Pyomo's form of the program, or with "
        "c₀ = 0.",
        small.ferris_tinloi(5),
        *loops(0.21455, "paper, Table 1", ("highs",), model="pyomo", tolerance=3e-4),
        *loops(0.21455, "paper, Table 1", ("clarabel",), options={"c0": 0.0}, tolerance=3e-4),
        default((0.207973, 0.21455), "from the lowest exact state known to the paper's λ"),
    ),
    entry(
        "interior point without crossover",
        "HiGHS's interior-point solver without crossover ends with the status 'unknown', or so near a "
        "vertex that joints lock. In both cases the loop has no answer.",
        STEPPED,
        *no_state("highs", "highs-ipm", c0=0.0, start="cohesive"),
        *no_state(*SOLVERS, **RAW),
        *loops(0.364840847, TWO_FORMULATIONS, ("clarabel",), why=AGAIN),
        *no_state("highs", "highs-ipm"),
        *associative(0.4190270, OTHERS),
        *references(0.364840847, TWO_FORMULATIONS),
        default(0.364840847, TWO_FORMULATIONS),
    ),
    entry(
        "a vertex from a cohesive start: wall 1",
        "After the cohesive start, the simplex solver soon ends at a vertex without a following state, or "
        "with 'unknown'. The result must then have a status, and no traceback. The loop with an "
        "interior-point solver converges. The MPEC that starts from zeros fails on wall 5, and takes longer "
        "on this wall.",
        small.ferris_tinloi(1),
        *no_state("highs", start="cohesive"),
        *loops(0.63982, "paper, Table 1", (None,), options={"start": "cohesive"}, tolerance=3e-4),
        Expectation("mpec", 0.638982, "lowest exact state known", options={"start": "cold"}),
        default(0.638982, "lowest exact state known"),
    ),
    entry(
        "a first-order solver",
        "SCS, which CVXPY installs, solves to a few digits only, and reports its status in its own form.",
        small.block(1, 2, 0.6),
        *(
            Expectation("static", 0.5, "w / h", Status.OPTIMAL, solver=name, tolerance=1e-3)
            for name in ("scs", "osqp")
        ),
    ),
    # Scenes that have no answer, or whose numbers are extreme.
    entry(
        "locking by dilatancy: confined block",
        "A block between fixed faces cannot slide if it dilates, so the associative λ is unlimited. Without "
        "dilatancy, only friction at the floor resists, and λ = μ W, unless the block is prestressed.",
        small.confined(0.5),
        *associative(expected=Status.LOCKED),
        *loops(0.5, "μ W", why=LOCKS),
        *references(0.5, "μ W", proven=True),
        default(0.5, "μ W"),
    ),
    entry(
        "locking by dilatancy: clamped H",
        "The web of an H is between flanges that cannot spread. With dilatancy the web cannot slip. Without "
        "dilatancy, only friction under the clamping force P resists: λ + W = 2 μ P.",
        small.clamped_h(0.5, 4.0),
        *associative(expected=Status.LOCKED),
        *loops(3.0, "2 μ P - W", why=LOCKS),
        *loops(3.0, "2 μ P - W", (None,), options={"start": "cohesive"}),
        *references(3.0, "2 μ P - W", proven=True),
        default(3.0, "2 μ P - W"),
    ),
    entry(
        "unstable under dead load",
        "The centroid of a block is beyond the edge that supports it. The scene has no λ, and the result "
        "names the block.",
        small.overhanging(),
        *every_method(Status.UNSTABLE, why=reason(Code.FALLS, blocks="'B'")),
    ),
    entry(
        "live load that does no work",
        "The only possible motion is perpendicular to the live load.",
        small.chute(),
        *every_method(Status.UNLIMITED, why=reason(Code.NO_MECHANISM)),
    ),
    entry(
        "live load that cannot cause collapse",
        "The live load pushes a block on the ground straight down. In every motion its work is negative.",
        small.block(1, 1, 0.5, live=(0.0, -1.0)),
        *every_method(Status.UNLIMITED, why=reason(Code.NO_MECHANISM)),
    ),
    entry(
        "μ = 0: nothing resists",
        "A flat smooth block slides at λ = 0, where a relative tolerance has no effect.",
        small.block(4, 1, 0.0),
        *one_answer(0.0, "closed form", proven=True, tolerance=1e-8, why=NO_INFLUENCE),
        Expectation(load_factor=0.0, source="closed form", options={"start": "cohesive"}),
    ),
    entry(
        "μ = 0: held by shape",
        "A square in a smooth groove slides up a face of 45° at λ = tan 45°.",
        small.groove(),
        *one_answer(1.0, "tan 45°", proven=True, why=NO_INFLUENCE),
    ),
    entry(
        "μ very large: one block",
        "The program has rows with the coefficient 1e6 and rows with the coefficient 1.",
        small.block(1, 2, 1e6),
        *one_answer(0.5, "w / h", proven=True, why=NO_INFLUENCE),
    ),
    entry(
        "μ very large: wall 1",
        "With μ = 1e5 in 83 joints, Clarabel reaches its tolerances only in scaled rows. The wall, 20 wide "
        "and 10.5 high, overturns as one rigid body.",
        small.ferris_tinloi(1, friction=1e5),
        Expectation("static", 20 / 10.5, "w / h", Status.OPTIMAL, tolerance=COARSE),
        *loops(20 / 10.5, "w / h", (None,), tolerance=COARSE, options=RAW, why=NO_INFLUENCE),
        *loops(20 / 10.5, "w / h", (None,), tolerance=COARSE, why=NO_INFLUENCE),
        *associative(20 / 10.5, "w / h", ("highs", "highs-ipm"), tolerance=COARSE),
        *loops(20 / 10.5, "w / h", ("highs-ipm",)),
        *no_state("highs"),
        # In an exact state, a corner without normal force may slide without friction. The lowest known state
        # of this kind is at 24/35.
        Expectation("coulomb", (24 / 35, 20 / 10.5), "a state at 24/35, or w / h", exact=True),
    ),
    entry(
        "μ large: wall 3",
        "With μ = 10, the loop limits normal forces to c / (αμ). This limit is so low that joints lock with "
        "most slopes. A load history has no such limit.",
        small.ferris_tinloi(3, friction=10.0),
        *no_state("clarabel", "highs"),
        *loops((0.0, 0.6833480), "at most the associative λ", ("highs-ipm",), why=AGAIN),
        *no_state(None, start="cohesive"),
        *associative(0.6833480, OTHERS),
        default((0.0, 0.6833480), "at most the associative λ"),
    ),
    entry(
        "joint 10⁻⁶ of a block long",
        "The second bearing of a slab is 4e-6 long, and the slab is 4 long. The slab slides at λ = μ.",
        small.short_bearing(4e-6, 1e-9),
        *one_answer(0.5, "μ", proven=True),
    ),
    entry(
        "joint shorter than the tolerance",
        "The same bearing is shorter than the default tolerance, 1e-6 of the scene, so it is no joint. The "
        "slab falls off its other support.",
        small.short_bearing(4e-6, None),
        *every_method(Status.UNSTABLE, why=reason(Code.FALLS, blocks="'slab'")),
    ),
    entry(
        "sizes 1 : 10⁴, both pushed",
        "One program has weights with the ratio 1 : 10⁸. Each block slides at λ = μ.",
        small.pebble(1e4, push_both=True),
        *one_answer(0.4, "μ", proven=False),
    ),
    entry(
        "sizes 1 : 10⁴, the small one pushed",
        "The pebble slides at λ = μ. In block weights, Clarabel's error of equilibrium is 1e-9 of the "
        "boulder's forces, which is a large part of the pebble's weight. The loop with Clarabel therefore "
        "cycles, and starts again with HiGHS, which is exact. The linear program uses units of the pebble's "
        "load, and its answer is correct.",
        small.pebble(1e4, push_both=False),
        *associative(0.4, "μ"),
        *loops(0.4, "μ", exact=True),
        *loops(0.4, "μ", (None,), options={"start": "cohesive"}, why=by_solver("highs-ipm")),
        default(0.4, "μ", only=True),
        Expectation("mpec", expected=Status.SOLVER_FAILED, why=reason(Code.NOT_CERTIFIED)),
        Expectation("global", 0.4, "μ", Status.OPTIMAL),
    ),
    *(
        entry(
            f"coordinates {shift:g} from the origin",
            "Large coordinates lose digits. The joints must still be found, and λ = μ, because the bottom "
            "course slides.",
            small.bonded(SOLID, (4, 1.75), 0.65, shift),
            *one_answer(0.65, "μ"),
        )
        for shift in (1e6, 1e12)
    ),
    *(
        entry(
            f"{'gap' if gap > 0 else 'overlap'} of {abs(gap) / 1e-3:g} tolerances",
            "Within the tolerance, the blocks touch. Beyond the tolerance, the scene is refused, and the "
            "error names the blocks.",
            small.apart(gap, 1e-3),
            *(refused(names) if names else one_answer(0.65, "μ")),
        )
        for gap, names in zip(
            (0.99e-3, 1.01e-3, -0.99e-3, -1.01e-3),
            ("", "'B' touches no other block", "", "'A' and 'B' overlap"),
            strict=True,
        )
    ),
    entry(
        "four blocks in a point",
        "The common point of four blocks must not become a joint. Two columns overturn, each about its own "
        "toe, at λ = w / h.",
        small.four_in_a_point(0.65),
        *associative(0.55401662, OTHERS),
        *loops(0.5, "w / h"),
        *references(0.5, "w / h", proven=True),
        default(0.5, "w / h"),
    ),
    entry(
        "many mechanisms of one λ",
        "A pile of six slabs slides in any of its six joints, or in several joints, at λ = μ.",
        small.slabs(6, 0.3),
        *one_answer(0.3, "μ", proven=True),
    ),
    entry(
        "many load factors of one mechanism",
        "In Fig. 6, the force of block B on block A is indeterminate: 1.5 μ ≤ λ ≤ 2.5 μ. With α = 0, the "
        "loop may end at any of these load factors. With contraction, it ends at the least.",
        small.two_blocks(0.1),
        *associative(0.25, "2.5 μ"),
        *loops((0.15 * (1 - LOOP), 0.25 * (1 + LOOP)), "1.5 μ to 2.5 μ", options=WITHOUT_HALVING),
        *loops(0.15, "1.5 μ", tolerance=1e-3),
        *references(0.15, "1.5 μ", proven=True),
        default(0.15, "1.5 μ"),
    ),
)
