"""Settings of the proof that a load factor is the least."""

from dataclasses import dataclass

from masonry_opt.methods.settings import Settings, above_one, zero_or_more
from masonry_opt.problem.problem import Problem
from masonry_opt.solution.load_history import LoadHistory


@dataclass(frozen=True)
class ProofSettings(Settings):
    """Settings of the proof by conflicts and products. Proofs are valid for all values of the settings."""

    #: A proof excludes load factors up to (1 − gap) times the lowest known load factor. With a smaller gap,
    #: rounding errors make more conflicts of a proof invalid.
    gap: float = 5e-7

    #: Slacks and rates up to this value count as zero. Slacks are relative to the dead load of the blocks on
    #: which the live load acts. Rates are relative to the mean velocity of the points at which the live load
    #: acts. With a larger value, the search solves fewer linear programs, but discovers later that a
    #: combination of yield conditions is impossible. It then has to examine more combinations.
    zero: float = 1e-9

    #: The search looks for a collapse state near its present forces and mechanism if no product z_i p_i of
    #: slack and rate exceeds this value. The units of z_i and p_i are those of ``zero``. With a larger value,
    #: more of these attempts fail. If all conditions are assigned, the search makes an attempt in any case.
    energy: float = 1e-7

    #: Multipliers below this fraction of the largest multiplier count as rounding errors. With a larger
    #: fraction, conflicts have fewer conditions, but more conflicts are invalid.
    rounding: float = 1e-9

    #: Safety margin, relative to the loads, that a proof subtracts from its lower bounds on friction energy.
    #: With a smaller margin, rounding errors make more bounds invalid.
    margin: float = 1e-6

    #: Number of linear programs after which a search ends without a proof. Unlike a time limit, this number
    #: makes results independent of the machine.
    most_programs: int = 10_000_000

    #: Number of linear programs after which relaxations by products first interrupt the search for conflicts.
    #: With a smaller number, proofs by products are found earlier, and proofs by conflicts later.
    first_products: int = 2000

    #: Relaxations interrupt the search again after this factor times as many linear programs, then after the
    #: square of the factor, and so on. With a smaller factor, more time is spent on relaxations.
    products_growth: float = above_one(5.0)

    #: Largest number of products in a relaxation that is solved to a vertex; 0 for proofs by conflicts alone.
    #: Running bonds of 41 joints have fewer products, and the walls of Table 1 have more. With a larger
    #: number, more lower bounds hold without assumed limits, but take longer.
    most_products: int = zero_or_more(12_000)

    #: A relaxation is repeated, with tighter force limits, if it closes more than this fraction of the gap
    #: between the lower and the upper bound on λ. Otherwise the next relaxation has more products, and takes
    #: two to ten times as long. With a smaller fraction, more relaxations are repeated.
    worth_repeating: float = 0.5

    #: No larger relaxation is tried if the bound so far is below this share of the lowest known λ. With a
    #: smaller share, more time is spent on relaxations that prove little.
    least_share: float = zero_or_more(0.5)

    #: Time limit in seconds of a single linear program, because HiGHS may never end without a limit. With a
    #: shorter limit, more combinations of yield conditions remain undecided.
    longest_program: float = 5.0

    #: If this number is n, the search makes every n-th decision, and the SAT solver makes all others. A
    #: decision of the search assumes that the yield condition with the largest energy z_i p_i is at yield.
    #: With a larger number, the SAT solver makes more decisions. The effect is small: solution times for
    #: n = 1, 2 and 3 differed by less than 20 %.
    decide_every: int = 2


#: Settings with their defaults.
SETTINGS = ProofSettings()


@dataclass(frozen=True)
class ProofBudget(Settings):
    """Limits within which method "coulomb" searches for a proof: joints, linear programs and time.

    The guide explains each field: page "The method", section "Settings of the default method". The source
    file of this class has the same text in the comment above each field.

    Unlike a time limit, a number of programs makes results independent of the machine.
    ``benchmarks/README.md`` has the measurements.
    """

    #: A proof is tried by default on scenes with at most this number of joints. Proofs succeed on more than
    #: nine of ten random scenes of up to 15 joints, mostly within 0.1 s. They succeed on three of four scenes
    #: of 16 to 25 joints, but there they take 2 to 4 s, several times longer than all other steps.
    few_joints: int = zero_or_more(15)

    #: A proof is also tried by default on scenes of up to ``most_joints`` joints with at most this number of
    #: redundant forces (unknown forces minus equations of equilibrium). A single arch has three. With a
    #: larger number, more searches end without a proof.
    few_redundant_forces: int = zero_or_more(3)

    #: Largest number of linear programs of a proof that is tried by default. Together with relaxations by
    #: products, 4500 programs take 2 to 4 s. With a larger number, more proofs succeed, and unsuccessful
    #: searches for a proof take longer.
    programs: int = zero_or_more(4500)

    #: No proof is tried on scenes with more than this number of joints, because it would hardly ever succeed.
    #: With a larger limit, option ``search`` takes longer on the scenes that the limit then includes.
    most_joints: int = zero_or_more(60)

    #: Time limit of a proof that is tried by default, in seconds. It is reached only if linear programs are
    #: very slow. With a shorter limit, results may depend on the machine.
    seconds: float = 30.0

    #: If no exact state and no associative load factor is known, a proof covers λ up to this multiple of the
    #: last λ of the load history. With a smaller value, states may be missed. With a very large value,
    #: rounding errors leave more searches undecided.
    load_range: float = 10.0

    #: With option ``search``, periods of search and of proof alternate. The first two have this number of
    #: linear programs each, and the number doubles after each period of proof. With a smaller number, a proof
    #: may be found earlier, but more work is repeated.
    first_turn: int = 1000

    def covers(self, problem: Problem) -> bool:
        """Return True if method "coulomb" can try a proof, by default or with its option ``search``.

        The method :meth:`tries_by_default` returns False for the scenes that need option ``search``. No proof
        is needed if equilibrium alone fixes all forces, or if the flow rule is associative. No proof is tried
        for scenes in space, for scenes with more than ``most_joints`` joints or with dilatancy that depends
        on stress, and if the forces at rest are prescribed.
        """
        if problem.layout.round or problem.joints > self.most_joints or problem.settled is not None:
            return False
        if problem.dilatancy_depends_on_stress:
            return False
        return not problem.statics_fix_forces and not problem.flow_is_associative

    def tries_by_default(self, problem: Problem) -> bool:
        """Return True if method "coulomb" tries a proof without option ``search``.

        The problem must have few joints or few redundant forces.
        """
        equations, forces = problem.B.shape
        is_small = problem.joints <= self.few_joints or forces - equations <= self.few_redundant_forces
        return is_small and self.covers(problem)

    def range_end(
        self, problem: Problem, associative: float | None, history: LoadHistory | None
    ) -> float | None:
        """Return the upper end of the range of load factors to search if no exact state is known.

        The upper end is the associative load factor, which no state exceeds. If this load factor is unknown,
        forces within friction may carry any multiple of the live load. The range then ends at a multiple of
        the last load factor of the load history. The result is None if both load factors are unknown, or if
        the last load factor of the load history is zero.
        """
        if associative is not None:
            return associative
        if history is None:
            return None
        end = self.load_range * history.steps[-1].load_factor
        return end if end > problem.load_factor_scale.zero else None


#: Budget with its defaults.
BUDGET = ProofBudget()
