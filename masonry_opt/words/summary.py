"""A result in plain words, and its technical lines: what ``print`` and the command show."""

from collections import Counter
from collections.abc import Iterable, Iterator
from itertools import groupby
from operator import itemgetter

import numpy as np

from masonry_opt.answer.acceptance import LIMITS, Kind
from masonry_opt.answer.motion import joint_motion, moving_blocks
from masonry_opt.answer.outcome import Outcome
from masonry_opt.answer.reasons import Code, Status
from masonry_opt.answer.thresholds import ZERO, same
from masonry_opt.errors import counted, printable
from masonry_opt.problem.assembly import Assembly
from masonry_opt.scene.case_file import CaseFile
from masonry_opt.words.names import labelled, verb
from masonry_opt.words.sentences import BY_CHORDS, by_sides, message, numeral, sentences

#: Codes that tell what is known of lower states.
_BOUNDS = (
    *(Code.PROVEN, Code.WITHIN_IMPOSED, Code.TOUCHES_IMPOSED),
    *(Code.OUT_OF_TIME, Code.OUT_OF_TIME_WITHIN_IMPOSED, Code.BELOW_ZERO),
)

#: Codes that tell what was tried, and nothing of the scene.
_TRIED = (Code.BEGAN_AGAIN, Code.CURVE, Code.SPREAD)

_TIES = 4  #: Ties and props that are told of.


def summary(result: Outcome, technical: bool = False) -> str:
    """What falls, at what load, how sure that is, and what looks unintended; if ``technical``, also how the
    answer was found: residuals, programs, solvers, times."""
    size, known = result.size, facts(result) | (_technical(result) if technical else {})
    numbers = {"block": size.blocks, "joint": size.joints, "contact point": size.contacts}
    count = ", ".join(counted(number, noun) for noun, number in numbers.items() if number is not None)
    warnings = [f"warning: {sentence}" for sentence in sentences(result.warnings)]
    lines = [f"{result.case}: {count}", _headline(result), labelled(known), *warnings]
    return printable("\n".join(filter(None, lines)))


def facts(result: Outcome) -> dict[str, str]:
    """What is known of a result beside its load factor and status, in plain words, by a label each."""
    known = {
        "why": _why(result),
        "falls" if result.status is Status.UNSTABLE else "moves": _mechanism(result),
        "ties": _ties(result),
        "live load": _live_load(result),
        "fill": "\n".join(of_fills(result.assembly)),
        "how sure": _certainty(result),
        "curve": "".join(_said(result, Code.CURVE)),
        "spread": "".join(_said(result, Code.SPREAD)),
        "load factors": load_factors(result),
        "friction": _friction(result),
        "crushing": _crushing(result),
        "reference": _reference(result),
    }
    return {label: words for label, words in known.items() if words}


def _said(result: Outcome, *codes: Code) -> tuple[str, ...]:
    """Sentences of the reasons with these codes."""
    return sentences([said for said in result.reasons if said.code in codes])


def _why(result: Outcome) -> str:
    """Why there is no load factor, without what was tried; or why there is one without work."""
    if result.status.usable:
        return "".join(_said(result, Code.NO_WORK))
    told = [reason for reason in result.reasons if reason.code not in _TRIED] or result.reasons
    return "\n".join(dict.fromkeys(sentences(told)))


def _headline(result: Outcome) -> str:
    """At what load the scene collapses, or how it ended without one."""
    if result.load_factor is None:
        return f"no load factor: {result.status}"
    factor = numeral(result.load_factor, ".7f")
    if result.tilt_angle is not None:
        tilt = result.assembly.scene.tilt
        side = f"to the {tilt}" if isinstance(tilt, str) else f"towards {_vector(tilt or ())}"
        angle = numeral(result.tilt_angle, ".4f")
        return f"falls {side} when the ground is tilted by {angle}° (λ = {factor})"
    return f"collapses when the live load is multiplied by λ = {factor}"


def _mechanism(result: Outcome) -> str:
    """How many blocks move, and what the joints do."""
    if result.solution.d is None:
        return ""
    of = joint_motion(result.assembly, result.solution)
    moving = len(moving_blocks(result.assembly, result.solution.d))
    done = {"slide": of.slides, "hinge": of.hinges, "separate": of.separates, "crush": of.crushes}
    said = [f"{n} {verb(n, word)}" for word, joints in done.items() if (n := int(joints.sum()))]
    joints = f"; of the joints {', '.join(said)}" if said else ""
    return f"{moving} of {counted(result.size.blocks, 'block')}{joints}"


def _ties(result: Outcome) -> str:
    """Which ties and props yield, and what the others carry; nothing of a scene that falls."""
    if result.ties["force"].isna().all():
        return ""
    told = []
    for tie in result.ties.sort_values("yields", ascending=False, kind="stable").to_dict("records"):
        does = "yields at" if tie["yields"] else "carries"
        force = "" if np.isnan(tie["force"]) else f" {does} {_known(tie['force'])}"
        told.append(f"{tie['kind']} '{tie['name']}'{force}")
    more = [f"and {len(told) - _TIES} more"] if len(told) > _TIES else []
    return "; ".join([*told[:_TIES], *more])


def _live_load(result: Outcome) -> str:
    """What λ multiplies: multiples of weights, which generators take by the name of forces too, or forces."""
    scene = result.assembly.scene
    if scene.tilt or not result.status.live_load_acts:
        return ""
    if scene.load_case is not None:
        return f"case '{scene.load_case.name}': {scene.load_case}"
    if scene.shaken_by is not None:
        return f"earthquake {scene.shaken_by}"
    said = []
    if times := Counter(block.live_per_weight for block in scene.blocks if any(block.live_per_weight)):
        many = f"{_vector(next(iter(times)))} times" if len(times) == 1 else "multiples of"
        tables = scene.case.tables_with_old_live() if isinstance(scene.case, CaseFile) else []
        given_as = f" (as 'live' of {', '.join(tables)})" if tables else ""
        said.append(f"{many} the weight of {counted(times.total(), 'block')}{given_as}")
    given: list[tuple[str, object]] = [(block.name, block) for block in scene.blocks]
    given += [(load.block, load) for load in scene.loads]
    for kind, of in (("force", "live"), ("moment", "live_moment")):
        if acted := {name for name, load in given if any(getattr(load, of, None) or ())}:
            said.append(f"{f'a {kind}' if len(acted) == 1 else f'{kind}s'} on {counted(len(acted), 'block')}")
    if lines := sum(load.kind == "live" for load in scene.edge_loads):
        said.append(f"along {counted(lines, 'line')}")
    return "; ".join(said)


def _vector(parts: Iterable[float]) -> str:
    return f"[{', '.join(f'{part:g}' for part in parts)}]"


def of_fills(assembly: Assembly) -> Iterator[str]:
    """A line on each fill: edges it touches, what weighs on movable blocks, spread of loads, pressure."""
    scene, movable = assembly.scene, set(assembly.movable.tolist())
    for number, fill in enumerate(scene.fills):
        pieces = [piece for piece in assembly.filled_pieces if piece.fill == number]
        below = [piece for piece in pieces if piece.weight and piece.block in movable]
        weight = scene.thickness * sum(piece.weight for piece in below)
        blocks = counted(len({piece.block for piece in below}), "block")
        said = [f"touches {counted(len({piece.edge for piece in pieces}), 'edge')}"]
        said.append(f"weighs {weight:.4g} on {blocks}" if fill.weight else "without weight")
        spread = f"loads on the road spread by {fill.spread:g}° to the vertical"
        said.append("loads go straight down" if fill.spread is False else spread)
        if fill.pressure:
            active, at_rest, passive = fill.coefficients
            between = f"pressure between {active:.4g} σ (K_a) and {passive:.4g} σ (m K_p)"
            said.append(f"{between}, at rest {at_rest:.4g} σ (K_0), σ its unit weight times depth")
        else:
            said.append("no pressure")
        if fill.backing:
            backed = {piece.edge for piece in pieces if piece.zone}
            said.append(f"its backing touches {counted(len(backed), 'edge')}")
        if fill.backing and fill.pressure:
            active, _, passive = fill.zones[1].coefficients
            said[-1] += f", pressure between {active:.4g} σ and {passive:.4g} σ, σ of both"
        if fill.pressure and scene.factor_of_pressure != 1:
            said.append(f"all pressures times {scene.factor_of_pressure:g}, of the load case")
        yield "; ".join(said)


def _certainty(result: Outcome) -> str:
    """Whether the answer is an exact state, and whether lower ones may exist."""
    if result.load_factor is None:
        return ""
    if none_lower := known_least(result):
        return none_lower
    if result.kind is Kind.COMPLIANT:
        pushed = "to expect of a scene that stands under its weight and is then pushed"
        less = "with other self-stress or fit it may carry less (method 'refined' looks for the least)"
        return f"{pushed}; {less}"
    if result.kind is Kind.ASSOCIATIVE and not result.exact:
        bound = "an upper bound, for joints that open as they slide"
        return f"{bound}: those that do not may collapse sooner (method 'mcp' tells)"
    state = "exact" if result.exact else f"exact but for {_left(result)}"
    if _is_associative(result):
        return state
    if bounds := _said(result, *_BOUNDS):
        return "; ".join([state, *bounds])
    looks = "".join(_said(result, Code.SEARCHED)) or "method 'refined' with search=10 searches for them"
    starts = _said(result, Code.STATES_MET, Code.FEW_STARTS)
    return f"{', '.join([state, *starts])}; lower ones may exist ({looks})"


def known_least(result: Outcome) -> str:
    """Why no state has a lower load factor than the answer; "" where that is not known."""
    below = result.solution.below_zero <= ZERO
    if any(reason.code is Code.PROVEN for reason in result.reasons) and not below:
        return "exact, and proven: no state is lower"
    if any(reason.values.get("fixed") for reason in result.reasons):
        return "exact: there is no other state"
    statics = result.kind is Kind.ASSOCIATIVE
    if _is_associative(result) and (statics or (result.exact and result.kind is not Kind.COMPLIANT)):
        law = f" {_friction_law(result)}" if "polygon" in result.friction_law else ""
        return f"exact{law}: the flow rule of all joints is the associative one, so no state is lower"
    return ""


def _is_associative(result: Outcome) -> bool:
    """Whether the joints' own flow rule is the associative one: all exact states have one load factor."""
    problem = result.assembly.problem
    return np.array_equal(problem.dilatancy, problem.friction) and not problem.dilatancy_depends_on_stress


def _left(result: Outcome) -> str:
    """Residuals above what an exact state may leave; or that friction is by sides, not by the cone."""
    above = LIMITS[Kind.EXACT].failing(result.certificate.as_dict() if result.certificate else {})
    if not above and "polygon" in result.friction_law:
        return f"friction, {_friction_law(result)}"
    named = ", ".join(f"{name} {value:.1e}" for name, value in above.items())
    return f"what its certificate leaves{f' ({named})' if named else ''}"


def load_factors(result: Outcome) -> str:
    """The load factors that a Coulomb answer comes with, and what each is for; none of a scene that falls."""
    if result.kind is Kind.ASSOCIATIVE or result.status is Status.UNSTABLE:
        return ""
    found, expected = result.load_factor, result.expected
    lowest = expected if result.end is None else result.end
    told: list[tuple[str, str, str]] = []  # what each is, its digits, and a remark
    if found is not None and result.kind is not Kind.COMPLIANT:
        above, what, remark = lowest is not None and lowest < found and not same(lowest, found), "found", ""
        if result.solution.below_zero <= ZERO:
            what, remark = "lowest found", " (with the worst self-stress or fit it falls by itself)"
        elif above:
            remark = " (lower ones are likely)"
        elif lowest is not None and result.exact:
            what = "safe (lowest found)"
        told.append((what, f" {_known(found)}", remark))
    if expected is not None:
        told.append(("expected in a test", f" {_known(expected)}", _doubt(result)))
    elif {said.code for said in result.expected_reasons} - {said.code for said in result.reasons}:
        told.append(("none expected in a test", "", f" ({message(result.expected_reasons)})"))
    if result.associative is not None:
        told.append(("upper bound", f" {_known(result.associative)}", " (classical limit analysis)"))
    return " · ".join(_once(number, list(equal)) for number, equal in groupby(told, itemgetter(1)))


def _once(number: str, equal: list[tuple[str, str, str]]) -> str:
    """Load factors that are equal, each with what it is and a remark, said once."""
    if len(equal) == 1:
        return "".join(equal[0])
    *before, last = (name + remark for name, _, remark in equal)
    return f"{', '.join(before)} and {last}{number}"


def _doubt(result: Outcome) -> str:
    """What is not shown of the load to expect, or is left of it once blocks move, in brackets."""
    for why in result.expected_reasons:
        if why.code is Code.NO_PLATEAU:
            return f" ({message([why])})"
        doubts = ["no collapse proves it"] if why.code in (Code.GROWN, Code.LEVEL) else []
        if why.code in (Code.RAY, Code.LEVEL) and why.values["peak"] is not None:
            doubts.append(f"{'nothing' if result.end is None else _known(result.end)} as it moves on")
        if doubts:
            return f" ({', '.join(doubts)})"
    return ""


def _known(load_factor: float) -> str:
    """A load factor, zero without the digits of its rounding."""
    return numeral(0.0 if abs(load_factor) <= ZERO else load_factor, ".5g")


def _friction(result: Outcome) -> str:
    """At what points forces act in space, and by which law friction holds there."""
    if result.size.contacts is None:
        return ""
    unlimited, expected = not len(result.assembly.problem.sliding), result.at_expected
    said = [_friction_law(result)] if unlimited or result.friction_law else []
    if result.expected is not None and expected and expected.friction_law != result.friction_law:
        said.append(f"the load to expect {_friction_law(expected)}")
    if result.load_factor is not None:
        said.append("λ is that of forces at contact points, the corners of joints")
    return "; ".join(said)


def _friction_law(result: Outcome) -> str:
    if "polygon" in result.friction_law:
        return by_sides(result.assembly.problem.layout)
    return f"by the {result.friction_law}" if result.friction_law else "unlimited"


def _crushing(result: Outcome) -> str:
    """By which law joints crush, in the load factor and in what stands beside it."""
    if not result.crushing or (result.load_factor is None and result.associative is None):
        return ""
    if result.crushing == "parabola":
        return f"by the parabola itself; all but 'static' and 'kinematic' with Clarabel take {BY_CHORDS}"
    beside = "" if result.kind is Kind.ASSOCIATIVE else "; the associative λ by the same"
    return f"by {BY_CHORDS}{beside}"


def _reference(result: Outcome) -> str:
    """The case file's reference value for the method (of "mcp" else the loop's: both answer for Coulomb's
    joints) and how far λ is from it; without one the same of the associative λ."""
    names = {"static": ["associative"], "kinematic": ["associative"], "mcp": ["mcp", "nonassociative"]}
    known = result.assembly.scene.reference
    name = next((name for name in names.get(result.method, [result.method]) if name in known), None)
    found, of, off = result.load_factor, "", ""
    if name is None and "associative" in known and result.associative is not None:
        name, found, of = "associative", result.associative, "associative "
    if name is None:
        return ""
    reference = known[name]
    if found is not None and reference.value:
        off = f", here {numeral(100 * (found / reference.value - 1), '+.3f')} %"
    return f"{of}{reference.value} ({reference.source}){off}"


def _technical(result: Outcome) -> dict[str, str]:
    size = result.size
    certificate = result.certificate.as_dict() if result.certificate else {}
    largest = f"{counted(size.rows or 0, 'row')}, {size.columns} columns, {size.nonzeros} non-zeros"
    return {
        "method": f"{result.method} ({result.model}, {result.solver})",
        "status": ": ".join(filter(None, (result.status, message(result.reasons)))),
        "range": _range(result),
        "certificate": "   ".join(f"{name} {numeral(value, '.1e')}" for name, value in certificate.items()),
        "existence": str(result.infeasibility.existence) if result.infeasibility else "",
        "programs": _programs(result),
        "largest program": "" if size.rows is None else largest,
        "solvers": "   ".join(f"{what}: {', '.join(names)}" for what, names in result.solvers.items()),
        "seconds": "   ".join(f"{part} {value:.3f}" for part, value in result.seconds.items()),
        "not modelled": "\n".join(left_out(result.assembly)),
    }


def _range(result: Outcome) -> str:
    """Between what the least load factor lies, where more is known than the answer itself."""
    lower, upper = result.range
    known = lower is None and result.load_factor is not None
    if result.kind is Kind.ASSOCIATIVE or known or upper is None:
        return ""
    return f"{'' if lower is None else numeral(lower, '.7f') + ' ≤ '}λ ≤ {numeral(upper, '.7f')}"


def _programs(result: Outcome) -> str:
    if not result.lp_solves and not result.nlp_solves:
        return f"none: {counted(result.iterations, 'Newton step')}" if result.iterations else ""
    nonlinear = f" and {result.nlp_solves} nonlinear" if result.nlp_solves else ""
    cones = "" if result.size.contacts is None else " or of cones"
    return f"{result.lp_solves} linear{cones}{nonlinear} ({counted(result.iterations, 'solver iteration')})"


def told_factor(result: Outcome) -> str:
    """The load factor, or why there is none."""
    return str(result.status) if result.load_factor is None else f"λ = {numeral(result.load_factor, '.5f')}"


def left_out(assembly: Assembly) -> tuple[str, ...]:
    """What a scene did not need, each with its reason."""
    problem, joints = assembly.problem, assembly.joints
    unlimited = len(assembly.joints_of(np.delete(np.arange(problem.joints), problem.sliding)))
    found = {
        f"sliding of {counted(unlimited, 'joint')}: friction is unlimited": unlimited,
        f"{counted(joints.fixed_pairs, 'joint')} between two fixed blocks: neither moves": joints.fixed_pairs,
    }
    return tuple(said for said, number in found.items() if number)
