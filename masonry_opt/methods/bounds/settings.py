"""Settings of the proof that a load factor is the least."""

from dataclasses import dataclass

from masonry_opt.answer.acceptance import CLOSED


@dataclass(frozen=True)
class ProofSettings:
    """Settings of the search for conflicts. None of them decides whether a conflict is valid."""

    #: Relative gap between the best load factor known and the bound. A smaller gap leaves conflicts whose
    #: energy is nearer to the rounding errors of their multipliers.
    gap: float = CLOSED

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

    #: The search chooses every n-th decision by the largest energy z_i p_i, and leaves all others to the SAT
    #: solver. Every value from 1 to 3 took as long within 20 % on 6 scenes of 14 to 20 joints.
    decide_every: int = 2


#: Settings with their defaults.
SETTINGS = ProofSettings()
