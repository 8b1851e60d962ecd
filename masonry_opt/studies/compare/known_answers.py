"""Which ends of an analysis are known to be right or wrong for a scene, whatever the method says."""

from __future__ import annotations

from collections.abc import Mapping

from masonry_opt.answer.status import Status
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.endings import REFUSED

ASSOCIATIVE, COULOMB = "associative", "Coulomb"

#: What an analysis can say of a scene: that it has a load factor, or why it has none. Every other end
#: (not converged, solver failed, a limit) says something of the method alone.
ANSWER = "answer"
CLAIMS = (ANSWER, REFUSED, Status.UNSTABLE, Status.UNLIMITED, Status.LOCKED, Status.JAMMED)


def known_claims(
    question: str, bounds: CertifiedBounds | None, expected: Mapping[str, str]
) -> dict[str, bool]:
    """By claim, whether it is right; what nobody knows is left out.

    Parameters
    ----------
    question: ASSOCIATIVE or COULOMB.
    bounds: certified bounds of the associative load factor; None if unknown.
    expected: by question, the claim that was derived by hand (the failure atlas).

    Notes
    -----
    The bounds decide the associative question. Coulomb's law has the same states of equilibrium within
    yield, without the mechanisms: where there is none for the dead load it has none either, and where they
    end at a load factor it cannot be unlimited. It may still have no mechanism that goes with them, or one
    where dilatancy would lock.
    """
    if question in expected:
        return {claim: claim == expected[question] for claim in CLAIMS}
    of_statics = [claim for claim in CLAIMS if claim != REFUSED]
    if bounds is None:
        return {}
    if bounds.unstable:
        return {claim: claim == Status.UNSTABLE for claim in of_statics}
    if bounds.finite:
        if question == COULOMB:
            return dict.fromkeys((Status.UNLIMITED, Status.LOCKED, Status.JAMMED), False)
        return {claim: claim == ANSWER for claim in of_statics}
    if bounds.unlimited and question == ASSOCIATIVE:
        return {claim: claim in (Status.UNLIMITED, Status.LOCKED) for claim in of_statics}
    return {}
