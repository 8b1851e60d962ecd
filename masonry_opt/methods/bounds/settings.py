"""Settings of the proof that a load factor is the least."""

from dataclasses import dataclass

import numpy as np

from masonry_opt.problem.problem import Problem


@dataclass(frozen=True)
class ProofSettings:
    """Settings of the search for conflicts. None of them decides whether a conflict is valid."""

    #: Gap between the best load factor known and the bound, relative to the load factor. With a smaller gap
    #: the energies of conflicts come nearer to the rounding errors of their multipliers.
    gap: float = 5e-7

    #: Slack, or rate, up to which a condition counts as at yield, or at rest, without a new linear program. A
    #: larger value saves programs and leaves more assignments to be refuted later.
    zero: float = 1e-9

    #: Largest product z_i p_i, in units of the load, up to which forces and mechanism are tried as a state. A
    #: larger value costs programs for pairs that are none; a complete assignment is always tried.
    energy: float = 1e-7

    #: Share of the largest multiplier below which a multiplier is rounding. A larger share makes conflicts
    #: shorter and more of them invalid.
    rounding: float = 1e-9

    #: Margin by which a force bound is lowered below the optimum of its program, relative to the loads. A
    #: smaller margin leaves bounds that their multipliers do not confirm.
    margin: float = 1e-6

    #: Linear programs after which a search ends without a proof, some 0.3 ms each on scenes of 30 joints. The
    #: same search ends in the same way on every machine, unless its time limit ends it before.
    most_programs: int = 10_000_000

    #: Time limit of a linear program, in seconds, as HiGHS may run for ever. A program that is stopped
    #: decides nothing, so that a shorter limit leaves more assignments open.
    longest_program: float = 5.0

    #: The search chooses every n-th decision by the largest energy z_i p_i, and leaves all others to the SAT
    #: solver. Every value from 1 to 3 took as long within 20 % on 6 scenes of 14 to 20 joints.
    decide_every: int = 2


#: Settings with their defaults.
SETTINGS = ProofSettings()


@dataclass(frozen=True)
class ProofBudget:
    """Budget of the proof that method "coulomb" tries by default, in linear programs.

    A number of programs, unlike a time, ends the search in the same way on every machine.
    ``benchmarks/README.md`` has the measurements.
    """

    #: Largest number of joints of a scene with the full budget. Of random scenes of up to this size, 95 % are
    #: proven with it. On larger scenes most searches would end without a proof.
    few_joints: int = 15

    #: The full budget, some 1 s. A larger budget proves more scenes, and takes longer on all others.
    programs: int = 4500

    #: Largest number of joints of a scene for which a proof is tried. Scenes with more joints are hardly ever
    #: proven.
    most_joints: int = 60

    #: Budget on scenes between both sizes, as a share of the programs that the method has solved before.
    #: Those programs take about twice as long each. A larger share proves more scenes, and makes the method
    #: slower.
    share: float = 0.6

    #: Time limit in seconds, which only scenes with very slow programs reach.
    seconds: float = 30.0

    #: Programs of the first turn, if a search for lower states and a proof take turns (option ``search``).
    #: The turns of both grow twofold. A smaller number proves sooner and repeats more work after each turn.
    first_turn: int = 1000

    def covers(self, problem: Problem) -> bool:
        """Return True if a proof is tried for a problem.

        No proof is needed if equilibrium alone fixes all forces, or if the flow rule is associative. None is
        tried for scenes that stand on forces that are given, in space, and with many joints.
        """
        if problem.layout.round or problem.joints > self.most_joints or problem.settled is not None:
            return False
        if problem.dilatancy_depends_on_stress:
            return False
        return not problem.statics_fix_forces and not np.array_equal(problem.dilatancy, problem.friction)

    def programs_for(self, problem: Problem, solved: int) -> int:
        """Return the number of programs for a problem, after a number of programs solved before."""
        return self.programs if problem.joints <= self.few_joints else int(self.share * solved)


#: Budget with its defaults.
BUDGET = ProofBudget()
