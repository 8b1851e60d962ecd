"""Settings of the proof that a load factor is the least."""

from dataclasses import dataclass

from masonry_opt.problem.problem import Problem


@dataclass(frozen=True)
class ProofSettings:
    """Settings of the search for conflicts. No setting affects the validity of a conflict."""

    #: Gap between the best load factor known and the bound, relative to the load factor. With a smaller gap
    #: the energies of conflicts come nearer to the rounding errors of their multipliers.
    gap: float = 5e-7

    #: Slack below which a condition counts as at yield, and rate below which it counts as at rest. A larger
    #: value saves linear programs, but more assignments must be refuted later.
    zero: float = 1e-9

    #: Forces and mechanism are tried as a state if no product z_i p_i exceeds this value, in units of the
    #: load. With a larger value more linear programs are solved in vain. A complete assignment is always
    #: tried.
    energy: float = 1e-7

    #: Multipliers below this share of the largest multiplier count as rounding. With a larger share conflicts
    #: are shorter, and more conflicts are invalid.
    rounding: float = 1e-9

    #: Distance of a lower bound of friction energy below the optimum of its linear program, relative to the
    #: loads. With a smaller distance rounding errors make more bounds invalid.
    margin: float = 1e-6

    #: Number of linear programs after which a search ends without a proof. A program takes about 0.3 ms on
    #: scenes of 30 joints. Unlike a time limit, this limit ends a search at the same point on every machine.
    most_programs: int = 10_000_000

    #: Time limit of a linear program in seconds, because HiGHS may run for ever. A stopped program decides
    #: nothing, so that with a shorter limit more assignments remain undecided.
    longest_program: float = 5.0

    #: The search makes every n-th decision by the largest energy z_i p_i; the SAT solver makes all other
    #: decisions. With 1, 2 and 3, times differed by less than 20 % on 6 scenes of 14 to 20 joints.
    decide_every: int = 2


#: Settings with their defaults.
SETTINGS = ProofSettings()


@dataclass(frozen=True)
class ProofBudget:
    """Budget, in linear programs, of the proof that method "coulomb" tries by default.

    A number of programs, unlike a time, ends the search in the same way on every machine.
    ``benchmarks/README.md`` has the measurements.
    """

    #: Largest number of joints of a scene with the full budget, which proves 95 % of random scenes of this
    #: size. On larger scenes most searches would end without a proof.
    few_joints: int = 15

    #: Largest number of redundant forces (unknown forces minus equations of equilibrium) of a scene that has
    #: the full budget with any number of joints. A single arch has three, so that its proof is short. With a
    #: larger number more searches use the full budget in vain.
    few_redundant_forces: int = 3

    #: The full budget: number of linear programs, which take about 1 s. With a larger budget more scenes are
    #: proven, and all other scenes take longer.
    programs: int = 4500

    #: Largest number of joints of a scene for which a proof is tried. On scenes with more joints a proof
    #: hardly ever succeeds.
    most_joints: int = 60

    #: Budget on all other scenes, as a share of the programs that the method has already solved, which take
    #: about twice as long each. With a larger share more scenes are proven, and the method is slower.
    share: float = 0.6

    #: Time limit of the proof in seconds, which is reached only if linear programs are very slow.
    seconds: float = 30.0

    #: With option ``search`` the search for lower load factors and the proof alternate: this is the number of
    #: linear programs of the first period, and each later period is twice as long. With a smaller number a
    #: proof comes sooner, but more work is repeated.
    first_turn: int = 1000

    def covers(self, problem: Problem) -> bool:
        """Return True if method "coulomb" tries a proof for a problem.

        No proof is needed if equilibrium alone fixes all forces, or if the flow rule is associative. None is
        tried for scenes that stand on forces that are given, in space, and with many joints.
        """
        if problem.layout.round or problem.joints > self.most_joints or problem.settled is not None:
            return False
        if problem.dilatancy_depends_on_stress:
            return False
        return not problem.statics_fix_forces and not problem.flow_is_associative

    def is_full_for(self, problem: Problem) -> bool:
        """Return True if a problem has the full budget: few joints, or few redundant forces as an arch."""
        equations, forces = problem.B.shape
        return problem.joints <= self.few_joints or forces - equations <= self.few_redundant_forces

    def programs_for(self, problem: Problem, solved: int) -> int:
        """Return the largest number of programs for a proof, given the number of programs already solved."""
        return self.programs if self.is_full_for(problem) else int(self.share * solved)


#: Budget with its defaults.
BUDGET = ProofBudget()
