"""Settings of the proof that a load factor is the least."""

from dataclasses import dataclass

from masonry_opt.methods.settings import Settings, zero_or_more
from masonry_opt.problem.problem import Problem
from masonry_opt.solution.load_history import LoadHistory
from masonry_opt.solution.thresholds import ZERO


@dataclass(frozen=True)
class ProofSettings(Settings):
    """Settings of the proof by conflict learning. No setting affects the validity of a conflict."""

    #: Gap between the lowest known load factor and the proven bound, relative to the load factor. With a
    #: smaller gap, the energies that prove a conflict approach the rounding errors of its multipliers.
    gap: float = 5e-7

    #: Slack below which a face counts as at yield, and rate below which it counts as at rest. A larger value
    #: saves linear programs, but more assignments must be refuted later.
    zero: float = 1e-9

    #: A collapse state is looked for near forces and a mechanism if no product z_i p_i exceeds this value, in
    #: units of the load. With a larger value more of these attempts fail. If all conditions are assigned, an
    #: attempt is always made.
    energy: float = 1e-7

    #: Multipliers below this share of the largest multiplier count as rounding errors. With a larger share
    #: conflicts involve fewer conditions, but more conflicts are invalid.
    rounding: float = 1e-9

    #: Distance of a lower bound of friction energy below the optimum of its linear program, relative to the
    #: loads. With a smaller distance rounding errors make more bounds invalid.
    margin: float = 1e-6

    #: Number of linear programs after which a search ends without a proof. A program takes about 0.3 ms on
    #: scenes of 30 joints. Unlike a time limit, this limit ends a search at the same point on every machine.
    most_programs: int = 10_000_000

    #: Time limit of a linear program in seconds. Without a limit HiGHS may never end. With a shorter limit
    #: more programs are stopped, and more assignments remain undecided.
    longest_program: float = 5.0

    #: The search makes every n-th decision itself, for the face with the largest energy z_i p_i. The SAT
    #: solver makes all other decisions. With 1, 2 and 3, times differed by less than 20 % on 6 scenes of 14
    #: to 20 joints.
    decide_every: int = 2


#: Settings with their defaults.
SETTINGS = ProofSettings()


@dataclass(frozen=True)
class ProofBudget(Settings):
    """Number of linear programs for the proof that method "coulomb" tries by default.

    Unlike a time limit, a number of programs ends the search at the same point on every machine.
    ``benchmarks/README.md`` has the measurements.
    """

    #: Largest number of joints of a scene with the full budget, which proves 95 % of random scenes of this
    #: size. On larger scenes most searches would end without a proof.
    few_joints: int = zero_or_more(15)

    #: Largest number of redundant forces (unknown forces minus equations of equilibrium) of a scene that has
    #: the full budget with up to ``most_joints`` joints. A single arch has three, so that its proof is short.
    #: With a larger number more searches use the full budget in vain.
    few_redundant_forces: int = zero_or_more(3)

    #: Number of linear programs of the full budget, which take about 1 s. With a larger budget more scenes
    #: are proven, and all other scenes take longer.
    programs: int = zero_or_more(4500)

    #: Largest number of joints of a scene for which a proof is tried, by default with the full budget only,
    #: and with option ``search``. On scenes with more joints a proof hardly ever succeeds.
    most_joints: int = zero_or_more(60)

    #: Budget on other scenes, as a share of the programs that the method has already solved, which take about
    #: twice as long each. With a larger share more scenes are proven, and the method is slower.
    share: float = zero_or_more(0.6)

    #: Largest number of joints of a scene with this smaller budget. It proves one in ten random scenes of 16
    #: to 25 joints; of 110 scenes of 26 to 60 joints it proved one, in a quarter of the time of the default.
    most_joints_with_share: int = zero_or_more(25)

    #: Time limit of the proof in seconds, which is reached only if linear programs are very slow.
    seconds: float = 30.0

    #: If neither an exact state nor the associative load factor is known, states are searched for up to this
    #: multiple of the last load factor of the load history. With a smaller multiple states above the load
    #: history are missed; with a very large multiple rounding errors leave more searches undecided.
    load_range: float = 10.0

    #: With option ``search`` the search for lower load factors and the proof alternate. This is the number of
    #: linear programs of the first period; each later period is twice as long. With a smaller number a proof
    #: may be found earlier, but more work is repeated.
    first_turn: int = 1000

    def covers(self, problem: Problem) -> bool:
        """Return True if method "coulomb" can try a proof for a problem, at least with option ``search``.

        No proof is needed if equilibrium alone fixes all forces, or if the flow rule is associative. No proof
        is tried for scenes in space, for scenes with many joints or with dilatancy that depends on stress,
        and if the forces at rest are prescribed.
        """
        if problem.layout.round or problem.joints > self.most_joints or problem.settled is not None:
            return False
        if problem.dilatancy_depends_on_stress:
            return False
        return not problem.statics_fix_forces and not problem.flow_is_associative

    def tries_by_default(self, problem: Problem) -> bool:
        """Return True if method "coulomb" tries a proof for a problem without option ``search``."""
        is_small = problem.joints <= self.most_joints_with_share or self.is_full_for(problem)
        return is_small and self.covers(problem)

    def is_full_for(self, problem: Problem) -> bool:
        """Return True if a problem has the full budget: few joints, or few redundant forces as an arch."""
        equations, forces = problem.B.shape
        return problem.joints <= self.few_joints or forces - equations <= self.few_redundant_forces

    def programs_for(self, problem: Problem, solved: int) -> int:
        """Return the largest number of programs for a proof, given the number of programs already solved."""
        return self.programs if self.is_full_for(problem) else int(self.share * solved)

    def range_end(self, associative: float | None, history: LoadHistory | None) -> float | None:
        """Return the load factor up to which states are searched for if no exact state is known.

        This is the associative load factor, which no state exceeds. Without it, forces within friction may
        carry any multiple of the live load, and the range ends at a multiple of the last load factor of the
        load history. The result is None if neither load factor is known, or if the last one is zero.
        """
        if associative is not None:
            return associative
        if history is None:
            return None
        end = self.load_range * history.steps[-1].load_factor
        return end if end > ZERO else None


#: Budget with its defaults.
BUDGET = ProofBudget()
