"""Write the safety margins of a stable scene without live load: one text for each label."""

from masonry_opt.errors import rounded_up
from masonry_opt.reporting.names import pairs
from masonry_opt.reporting.sentences import numeral
from masonry_opt.solution.outcome import Outcome
from masonry_opt.solution.reasons import Status
from masonry_opt.solution.stability import Stability

#: First line of the answer if a scene without live load is stable.
STABLE = "stable under its dead load"

#: Accuracy of the bisections that compute the safety margins. A friction factor or joint margin this close to
#: 0, or a geometric margin this close to 1, is described in words instead of a number.
_NEGLIGIBLE_RESERVE = 2e-4


def answer_line(result: Outcome) -> str:
    """Return the line that says why a result has no load factor, such as "stable under its dead load".

    The line is empty if the result has a load factor. If no live load acts, the line does not mention a load
    factor.
    """
    if result.status.usable:
        return ""
    if result.status is Status.STABLE:
        return STABLE
    is_question = not result.assembly.problem.live_norm
    return str(result.status) if is_question else f"no load factor: {result.status}"


def reserves(result: Outcome) -> dict[str, str]:
    """Return texts on the reserves (safety margins) of a stable scene, as a dict from label to text.

    For any other result, the dict is empty.
    """
    stability = result.stability
    if stability is None:
        return {}
    return {
        "least friction": _least_friction(stability, result.assembly.problem.friction.tolist()),
        "thrust": _thrust(stability),
        "worst joint": _worst_joint(stability),
    }


def _least_friction(stability: Stability, friction: list[float]) -> str:
    """Return a text about the least friction with which a scene is stable, or "" if it is unknown.

    The number is rounded up, because with less friction than the least the scene is unstable.
    """
    factor = stability.least_friction_factor
    if factor is None:
        return ""
    if factor == 0:
        return "none: the scene is stable without friction"
    if factor <= _NEGLIGIBLE_RESERVE:
        return f"less than {_NEGLIGIBLE_RESERVE:g} times the friction of the joints"
    if stability.least_friction is None:
        times = rounded_up(factor)
        return f"{times} times the friction of each joint; with less friction the scene is unstable"
    least = rounded_up(stability.least_friction)
    return f"{least}; with less friction the scene is unstable (the joints have friction {friction[0]:g})"


def _thrust(stability: Stability) -> str:
    """Return a text about the geometric margin: how far the joints can shrink towards their middles.

    The text is "" if the margin is unknown. The remaining percentage is rounded up, so that the margin is not
    overstated.
    """
    margin = stability.geometric_margin
    if margin is None:
        return ""
    if margin >= 1 - _NEGLIGIBLE_RESERVE:
        return "all resultants can act at the middles of their joints"
    return f"all resultants can act within the middle {rounded_up(100 * (1 - margin), 3)} % of their joints"


def _worst_joint(stability: Stability) -> str:
    """Return a text about the joint whose resultant acts nearest to an edge, or "" if no joint is known."""
    worst = stability.worst_joint
    if worst is None:
        return ""
    joint = pairs({"pairs": [[worst.first, worst.second]]})
    distance, share = numeral(worst.distance, ".4g"), numeral(100 * worst.margin, ".3g")
    where = (
        f"{joint}: the resultant acts at a distance of {distance} from the edge of the joint, which is "
        f"{share} % of the distance from the edge to the middle"
    )
    if worst.margin <= _NEGLIGIBLE_RESERVE:
        where = f"{joint}: the resultant acts at the edge of the joint"
    return where if stability.unique else f"{where}, with the forces shown"
