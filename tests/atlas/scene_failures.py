"""Atlas, second part: scenes that have no answer, or whose numbers are extreme."""

from atlas.entry import Entry, Expectation
from atlas.expectations import (
    COARSE,
    LOCKS,
    LOOP,
    NO_INFLUENCE,
    OTHERS,
    RAW,
    WITHOUT_HALVING,
    associative,
    default,
    every_method,
    loops,
    one_answer,
    references,
)
from atlas.small_scenes import (
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

from masonry_opt.answer.reasons import Code, Status, reason
from masonry_opt.errors import CaseError

SOLID: list[list[float]] = [[0.5, 1, 1, 0.5], [1, 1, 1], [0.5, 1, 1, 0.5], [1, 1, 1]]

ENTRIES: tuple[Entry, ...] = (
    Entry(
        "locking by dilatancy: confined block",
        "Between fixed faces a block that dilates cannot slide: associative λ is unlimited. Without "
        "dilatancy friction at the floor resists alone, λ = μ W, unless the block is prestressed.",
        confined(0.5),
        (
            *associative(Status.LOCKED),
            *loops(Status.CONVERGED, 0.5, "μ W", why=LOCKS),
            *references(0.5, "μ W", proven=False),
            default(0.5, "μ W"),
        ),
    ),
    Entry(
        "locking by dilatancy: clamped H",
        "The web of an H hangs between flanges that cannot spread: with dilatancy it cannot slip at all. "
        "Friction under the clamping force P alone holds λ + W = 2 μ P.",
        clamped_h(0.5, 4.0),
        (
            *associative(Status.LOCKED),
            *loops(Status.CONVERGED, 3.0, "2 μ P - W", why=LOCKS),
            *loops(Status.CONVERGED, 3.0, "2 μ P - W", (None,), options={"start": "cohesive"}),
            *references(3.0, "2 μ P - W", proven=False),
            default(3.0, "2 μ P - W"),
        ),
    ),
    Entry(
        "unstable under dead load",
        "A block lies with its centroid beyond the edge that bears it: no λ at all, and its name is given.",
        overhanging(),
        every_method(Status.UNSTABLE, why=reason(Code.FALLS, blocks="'B'")),
    ),
    Entry(
        "live load that does no work",
        "The only motion is at a right angle to the live load.",
        chute(),
        every_method(Status.UNLIMITED, why=reason(Code.NO_MECHANISM)),
    ),
    Entry(
        "live load that cannot cause collapse",
        "A live load straight down on a block that lies on the ground: every motion works against it.",
        block(1, 1, 0.5, live=(0.0, -1.0)),
        every_method(Status.UNLIMITED, why=reason(Code.NO_MECHANISM)),
    ),
    Entry(
        "μ = 0: nothing resists",
        "A flat smooth block slides at λ = 0, of which no relative tolerance is anything.",
        block(4, 1, 0.0),
        (
            *one_answer(0.0, "closed form", proven=True, tolerance=1e-8, why=NO_INFLUENCE),
            Expectation(
                Status.CONVERGED, options={"start": "cohesive"}, load_factor=0.0, source="closed form"
            ),
        ),
    ),
    Entry(
        "μ = 0: held by shape",
        "A square in a smooth groove at 45° climbs the face when λ = tan 45°.",
        groove(),
        one_answer(1.0, "tan 45°", proven=True, why=NO_INFLUENCE),
    ),
    Entry(
        "μ very large: one block",
        "Rows of friction 1e6 beside rows of 1.",
        block(1, 2, 1e6),
        one_answer(0.5, "w / h", proven=True, why=NO_INFLUENCE),
    ),
    Entry(
        "μ very large: wall 1",
        "With μ = 1e5 in 83 joints Clarabel reaches its tolerances in scaled rows alone. The wall, 20 by "
        "10.5, overturns in one piece.",
        ferris_tinloi(1, friction=1e5),
        (
            Expectation(Status.OPTIMAL, "static", load_factor=20 / 10.5, tolerance=COARSE, source="w / h"),
            *(
                Expectation(
                    Status.CONVERGED,
                    options=options,
                    load_factor=20 / 10.5,
                    tolerance=COARSE,
                    source="w / h",
                    why=NO_INFLUENCE,
                )
                for options in (RAW, {})
            ),
            *associative(Status.OPTIMAL, 20 / 10.5, "w / h", ("highs", "highs-ipm"), tolerance=COARSE),
            *loops(Status.CONVERGED, 20 / 10.5, "w / h", ("highs-ipm",)),
            *loops(Status.NO_STATE, solvers=("highs",), why=reason(Code.SUB_PROBLEM_EMPTY)),
            # A corner that bears nothing slides along in an exact state: no friction is at work in it.
            Expectation(
                Status.CONVERGED, "mcp", load_factor=(1.7575, 20 / 10.5), source="a state at 1.7575, or w / h"
            ),
        ),
    ),
    Entry(
        "μ large: wall 3",
        "With μ = 10 the cap c / (αμ) on normal forces is so low that most slopes lock joints, "
        "in the loop; a push has no such cap.",
        ferris_tinloi(3, friction=10.0),
        (
            *loops(Status.NO_STATE, solvers=("clarabel", "highs"), why=reason(Code.SUB_PROBLEM_EMPTY)),
            Expectation(
                Status.CONVERGED,
                solver="highs-ipm",
                load_factor=(0.0, 0.6833480),
                source="at most the associative λ",
                why=reason(Code.BEGAN_AGAIN, remedies="alpha="),
            ),
            Expectation(Status.NO_STATE, options={"start": "cohesive"}, why=reason(Code.SUB_PROBLEM_EMPTY)),
            *associative(Status.OPTIMAL, 0.6833480, OTHERS),
            default((0.0, 0.6833480), "at most the associative λ"),
        ),
    ),
    Entry(
        "joint 10⁻⁶ of a block long",
        "A slab whose second bearing is 4e-6 of its 4 long; it slides at λ = μ.",
        short_bearing(4e-6, 1e-9),
        one_answer(0.5, "μ", proven=True),
    ),
    Entry(
        "joint shorter than the tolerance",
        "The same bearing is nothing by default (1e-6 of the scene): the slab falls off its other support.",
        short_bearing(4e-6, None),
        every_method(Status.UNSTABLE, why=reason(Code.FALLS, blocks="'slab'")),
    ),
    Entry(
        "sizes 1 : 10⁴, both pushed",
        "Weights 1 : 10⁸ in one program; either block slides at λ = μ.",
        pebble(1e4, push_both=True),
        one_answer(0.4, "μ", proven=False),
    ),
    Entry(
        "sizes 1 : 10⁴, the small one pushed",
        "The pebble slides at λ = μ, but in block weights Clarabel leaves 1e-9 of the boulder's forces out "
        "of balance, a good part of the pebble's weight: its loop cycles, and begins again with HiGHS, which "
        "is exact. The linear program, in units of the pebble's load, is right.",
        pebble(1e4, push_both=False),
        (
            *associative(Status.OPTIMAL, 0.4, "μ"),
            *loops(Status.CONVERGED, 0.4, "μ", exact=True),
            Expectation(
                Status.CONVERGED,
                options={"start": "cohesive"},
                load_factor=0.4,
                tolerance=LOOP,
                source="μ",
                why=reason(Code.BEGAN_AGAIN, remedies="solver=highs-ipm"),
            ),
            Expectation(Status.CONVERGED, "refined", load_factor=0.4, source="μ", exact=True),
            default(0.4, "μ", only=True),
            Expectation(Status.SOLVER_FAILED, "mpec", why=reason(Code.NOT_CERTIFIED)),
            Expectation(
                Status.CONVERGED,
                "global",
                load_factor=0.4,
                source="μ",
                why=reason(Code.OUT_OF_TIME_WITHIN_IMPOSED),
            ),
        ),
    ),
    *(
        Entry(
            f"coordinates {shift:g} from the origin",
            "Digits are lost in the coordinates: joints must be found, and λ = μ (the bottom course slides).",
            bonded(SOLID, (4, 1.75), 0.65, shift),
            one_answer(0.65, "μ"),
        )
        for shift in (1e6, 1e12)
    ),
    *(
        Entry(
            f"{'gap' if gap > 0 else 'overlap'} of {abs(gap) / 1e-3:g} tolerances",
            "Within the tolerance the blocks touch; beyond it the scene is refused, with their names.",
            apart(gap, 1e-3),
            (
                one_answer(0.65, "μ")
                if abs(gap) < 1e-3
                else (Expectation(CaseError, "static", names=names), Expectation(CaseError, names=names))
            ),
        )
        for gap, names in (
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
            default(0.5, "w / h"),
        ),
    ),
    Entry(
        "many mechanisms of one λ",
        "A pile of six slabs slides in any of six joints, or several, at λ = μ.",
        slabs(6, 0.3),
        one_answer(0.3, "μ", proven=False),
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
            default(0.15, "1.5 μ"),
        ),
    ),
)
