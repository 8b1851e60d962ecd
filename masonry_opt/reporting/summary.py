"""Write the summary of a result, which ``print`` and the command show, and its technical lines."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from masonry_opt.errors import counted, printable, shortened
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role
from masonry_opt.problem.load_factor_scale import RELATIVE_ROUNDING
from masonry_opt.reporting.linear_laws import BY_CHORDS, PARABOLA_REMARK
from masonry_opt.reporting.load_factors import (
    AFTER_INCREMENTAL,
    ASSOCIATIVE,
    INCREMENTAL,
    LEAST,
    LOWEST,
    STATE_FOUND,
    factor_text,
    friction_law,
    is_rounding_error,
    known_least,
    load_factor_table,
    own_name,
    why_not_incremental,
)
from masonry_opt.reporting.names import FORCE_UNIT, labelled, verb
from masonry_opt.reporting.sentences import message, numeral, sentences
from masonry_opt.reporting.stability import answer_line, reserves
from masonry_opt.scene.blocks import Reference
from masonry_opt.scene.case_file import CaseFile
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.motion import joint_motion, moving_blocks
from masonry_opt.solution.outcome import Outcome
from masonry_opt.solution.reasons import Code, Status

#: Codes of reasons that describe the analysis instead of the scene. The line that states why there is no load
#: factor omits reasons with these codes if the result also has other reasons.
_ANALYSIS_CODES = (Code.BEGAN_AGAIN, Code.CURVE, Code.SPREAD)

#: The summary explains a low λ by self-stress if λ is below this fraction of the incremental load factor.
#: With a larger value, the summary also explains a λ that is only a little below the incremental load factor.
_FAR_BELOW = 0.5

#: The summary explains a low λ by self-stress only if at most this fraction of the blocks moves. With a
#: larger value, the summary also explains collapses of the whole structure.
_FEW_BLOCKS = 0.5

_MOST_TIES = 4  #: Largest number of ties and props that a summary lists; the remaining ones are only counted.


def summary(result: Outcome, technical: bool = False) -> str:
    """Return the summary of a result: load factors, moving blocks and joints, loads and warnings.

    If ``technical`` is True, residuals, programs, solvers and times are included.
    """
    size = result.size
    numbers = {"block": size.blocks, "joint": size.joints, "contact": size.contacts}
    count = ", ".join(counted(number, noun) for noun, number in numbers.items() if number is not None)
    ended = answer_line(result)
    moves, known = motion(result), facts(result)
    at_collapse = ""
    if moves and result.status.usable:
        label, words = moves
        at_collapse = f"{label}: {words}"
        del known[label]
    if technical:
        known |= _technical(result)
    warnings = [f"warning: {sentence}" for sentence in sentences(result.warnings)]
    lines = [f"{result.case}: {count}", ended, load_factor_table(result), at_collapse]
    return printable("\n".join(filter(None, [*lines, labelled(known), *warnings])))


def facts(result: Outcome) -> dict[str, str]:
    """Return all facts of a result except its load factors and its status, as a dict from label to text."""
    known = {
        **({"forces": _why(result)} if result.stability else {"why": _why(result)}),
        **reserves(result),
        "time limit": "\n".join(_time_limits(result)) if result.status.usable else "",
        "incremental": why_not_incremental(result) if _says_why_not_incremental(result) else "",
        **dict(filter(None, [motion(result)])),
        "self-stress": _self_stress(result),
        "ties": _ties(result),
        "live load": _live_load(result),
        "fill": "\n".join(of_fills(result.assembly)),
        "curve": "".join(_sentences_of(result, Code.CURVE)),
        "spread": "".join(_sentences_of(result, Code.SPREAD)),
        "friction": _friction(result),
        "crushing": crushing(result),
        "reference": _reference(result),
    }
    return {label: words for label, words in known.items() if words}


def _says_why_not_incremental(result: Outcome) -> bool:
    """Return True if the summary states why there is no incremental load factor.

    This is the case if a live load acts on a stable scene that has no load factor.
    """
    return result.load_factor is None and result.status.live_load_acts


def _sentences_of(result: Outcome, *codes: Code) -> tuple[str, ...]:
    """Return a sentence for each reason of the result whose code is one of ``codes``."""
    return sentences([reason for reason in result.reasons if reason.code in codes], result.method)


def _time_limits(result: Outcome) -> list[str]:
    """Return the sentences about the time limit, without repetitions.

    Several parts of an analysis may end at the time limit, with the same sentence as the reason.
    """
    return [*dict.fromkeys(_sentences_of(result, Code.TIME_LIMIT))]


def _why(result: Outcome) -> str:
    """Return the reasons for a missing load factor, or for a collapse in which the live load does no work.

    Reasons that describe only the analysis are omitted if the result has other reasons.
    """
    if result.status.usable:
        return "".join(_sentences_of(result, Code.NO_WORK))
    reasons = [reason for reason in result.reasons if reason.code not in _ANALYSIS_CODES] or result.reasons
    return "\n".join(dict.fromkeys(sentences(reasons, result.method)))


#: Labels of the printed line that counts moving blocks and joints, by the name of the load factor at which
#: they move.
_MOTION_LABELS = {
    LOWEST: "at the lowest",
    LEAST: "at the least",
    STATE_FOUND: "at the state found",
    AFTER_INCREMENTAL: "after incremental collapse",
    INCREMENTAL: "at incremental collapse",
    ASSOCIATIVE: "at associative collapse",
}


def motion(result: Outcome) -> tuple[str, str] | None:
    """Return a label, and a text that counts the moving blocks and the joints of each kind of motion.

    The kinds of motion are sliding, hinging, opening and crushing. The function returns None if no motion is
    known.
    """
    if result.solution.d is None:
        return None
    motions = joint_motion(result.assembly, result.solution)
    moving = len(moving_blocks(result.assembly, result.solution.d))
    counts = {
        "slide": motions.slides.sum(),
        "hinge": motions.hinges.sum(),
        "open": motions.separates.sum(),
        "crush": motions.crushes.sum(),
    }
    phrases = [
        f"{counted(count, 'joint')} {verb(int(count), word)}" for word, count in counts.items() if count
    ]
    joints = f"; {', '.join(phrases)}" if phrases else ""
    blocks = f"{moving} of {counted(result.size.blocks, 'block')}"
    if result.load_factor is None:
        return "falls" if result.status is Status.UNSTABLE else "moves", f"{blocks}{joints}"
    return _MOTION_LABELS[own_name(result)], f"{blocks} {verb(moving, 'move')}{joints}"


def _self_stress(result: Outcome) -> str:
    """Return a text about a load factor far below the incremental load factor, or "" in all other cases.

    The text is about load factors at which few blocks move, because such a state is often a single stone that
    is released by its own self-stress. The text gives no advice: the joint forces of a real structure are
    unknown. It is empty in these cases:

    - The load factor is proven to be the least.
    - The load factor is negative, so that the load history does not pass it.
    - Equilibrium is lost as soon as the live load acts, so that the load history passes no load factor.
    - Supports have settled, so that the load history does not begin at rest.
    """
    if result.kind is not Kind.EXACT or result.load_factor is None or result.incremental is None:
        return ""
    has_settled = result.assembly.at_rest is not None or result.assembly.problem.settled is not None
    if (
        known_least(result)
        or result.load_factor < -result.assembly.problem.load_factor_scale.zero
        or has_settled
    ):
        return ""
    if is_rounding_error(result, result.incremental):
        return ""
    if result.solution.d is None or result.load_factor >= _FAR_BELOW * result.incremental:
        return ""
    moving = len(moving_blocks(result.assembly, result.solution.d))
    if moving > _FEW_BLOCKS * result.size.blocks:
        return ""
    return (
        f"{counted(moving, 'block')} {verb(moving, 'move')} at this λ if the joint forces are those of this "
        "collapse state; the load history from rest passes this λ without collapse, and the incremental λ is "
        f"{factor_text(result, result.incremental)}"
    )


def _ties(result: Outcome) -> str:
    """Return a text about ties and props with their forces; ties and props that yield come first.

    The text is empty for a scene without ties and props, and for a scene that falls.
    """
    # Return early if there are no ties or props, because their table needs pandas, and importing pandas takes
    # a quarter of a second.
    if not any(force.role in (Role.TIE, Role.PROP) for force in result.assembly.limited):
        return ""
    if result.ties["force"].isna().all():
        return ""
    phrases = []
    rounding = RELATIVE_ROUNDING * result.assembly.problem.force_unit
    for tie in result.ties.sort_values("yields", ascending=False, kind="stable").to_dict("records"):
        predicate = "yields at" if tie["yields"] else "carries"
        # A force of the size of rounding errors is printed as zero.
        carried = 0.0 if abs(tie["force"]) <= rounding else tie["force"]
        force = "" if np.isnan(carried) else f" {predicate} {numeral(carried, '.5g')}"
        phrases.append(f"{tie['kind']} '{tie['name']}'{force}")
    return f"forces {FORCE_UNIT}: {'; '.join(shortened(phrases, _MOST_TIES))}"


def _live_load(result: Outcome) -> str:
    """Return a description of the live load, such as "case 'wind'" or "a force on 1 block".

    The text is empty if the ground is tilted, or if only the dead load acts on the state of the result.
    """
    scene = result.assembly.scene
    if scene.tilt or not result.status.live_load_acts:
        return ""
    if scene.load_case is not None:
        return f"case '{scene.load_case.name}': {scene.load_case}"
    if scene.shaken_by is not None:
        return f"earthquake {scene.shaken_by}"
    phrases = []
    multiples = Counter(block.live_per_weight for block in scene.blocks if any(block.live_per_weight))
    if multiples:
        factor = f"{_vector(next(iter(multiples)))} times" if len(multiples) == 1 else "multiples of"
        # Name the generator tables that use the old key "live", which means a multiple of the weight instead
        # of a force.
        tables = scene.case.tables_with_old_live() if isinstance(scene.case, CaseFile) else []
        given_as = f" (as 'live' of {', '.join(tables)})" if tables else ""
        phrases.append(f"{factor} the weight of {counted(multiples.total(), 'block')}{given_as}")
    loads: list[tuple[str, object]] = [(block.name, block) for block in scene.blocks]
    loads += [(load.block, load) for load in scene.loads]
    for kind, attribute in (("force", "live"), ("moment", "live_moment")):
        loaded = {name for name, load in loads if any(getattr(load, attribute, None) or ())}
        if loaded:
            noun = f"a {kind}" if len(loaded) == 1 else f"{kind}s"
            phrases.append(f"{noun} on {counted(len(loaded), 'block')}")
    lines = sum(load.kind == "live" for load in scene.edge_loads)
    if lines:
        phrases.append(f"along {counted(lines, 'line')}")
    return "; ".join(phrases)


def _vector(parts: Iterable[float]) -> str:
    """Return the components of a vector in square brackets."""
    return f"[{', '.join(f'{part:g}' for part in parts)}]"


def of_fills(assembly: Assembly) -> Iterator[str]:
    """Describe each fill in a line: the edges that the fill touches, its weight, load spread and pressure."""
    scene, movable = assembly.scene, set(assembly.movable.tolist())
    for number, fill in enumerate(scene.fills):
        pieces = [piece for piece in assembly.filled_pieces if piece.fill == number]
        below = [piece for piece in pieces if piece.weight and piece.block in movable]
        weight = scene.thickness * sum(piece.weight for piece in below)
        blocks = counted(len({piece.block for piece in below}), "block")
        phrases = [f"touches {counted(len({piece.edge for piece in pieces}), 'edge')}"]
        factor = scene.factor("dead", "fill")
        factored = "" if factor == 1 else f" (the factor {factor:g} of the load case is not included)"
        weighs = f"weighs {weight:.4g} on {blocks}{factored}, {FORCE_UNIT}"
        phrases.append(weighs if fill.weight else "without weight")
        spread = f"loads on the road spread within {fill.spread:g}° of the vertical"
        phrases.append("loads on the road do not spread" if fill.spread is False else spread)
        if fill.pressure:
            active, at_rest, passive = fill.coefficients
            phrases.append(
                f"pressure between {active:.4g} σ (active, K_a) and {passive:.4g} σ (passive, m K_p), at "
                f"rest {at_rest:.4g} σ (K_0); σ is unit weight times depth, and m is the mobilised fraction "
                "of K_p"
            )
        else:
            phrases.append("no pressure")
        if fill.backing:
            backed = {piece.edge for piece in pieces if piece.zone}
            phrases.append(f"its backing touches {counted(len(backed), 'edge')}")
        if fill.backing and fill.pressure:
            active, _, passive = fill.zones[1].coefficients
            phrases[-1] += (
                f", pressure between {active:.4g} σ and {passive:.4g} σ, where σ is the vertical stress "
                "from the weight of fill and backing"
            )
        if fill.pressure and scene.factor_of_pressure != 1:
            phrases.append(f"the load case multiplies all pressures by {scene.factor_of_pressure:g}")
        yield "; ".join(phrases)


def _friction(result: Outcome) -> str:
    """Return a text about the friction law of a scene in space, and about the points where joint forces act.

    The text is empty without contacts: in the plane, and for scenes that hang on ties alone.
    """
    if not result.size.contacts:
        return ""
    unlimited, incremental = not len(result.assembly.problem.sliding), result.at_incremental
    phrases = [friction_law(result)] if unlimited or result.friction_law else []
    if result.incremental is not None and incremental and incremental.friction_law != result.friction_law:
        phrases.append(f"for the incremental λ {friction_law(incremental)}")
    if result.load_factor is not None:
        phrases.append("joint forces act at contact points, which are the corners of joints")
    return "; ".join(phrases)


def crushing(result: Outcome) -> str:
    """Return a text about the crushing law of a result: the parabola itself, or chords inside the parabola.

    The text is empty if no joint has a limited strength.
    """
    if not result.crushing:
        return ""
    if result.load_factor is None and result.associative is None:
        return f"limited by {BY_CHORDS}; the parabola permits larger moments than its chords"
    if result.crushing == "parabola":
        return (
            "limited by the crushing parabola itself; only methods 'static' and 'kinematic' with Clarabel "
            f"use the parabola, and all other methods use {BY_CHORDS}"
        )
    associative = "" if result.kind is Kind.ASSOCIATIVE else ", also for the associative λ"
    return f"limited by {BY_CHORDS}{associative}; {PARABOLA_REMARK}"


def _reference(result: Outcome) -> str:
    """Return the reference value of the case file, and the relative difference of λ from this value.

    For "coulomb" this may be the value of an MCP or of the loop, because all these methods compute a collapse
    with Coulomb friction. The text then names the value, and adds the value of an MPEC. Without such a value,
    the associative reference value is compared with the associative λ. The text is empty for a load case,
    because a case file does not name the load case of its values.
    """
    if result.assembly.scene.load_case is not None:
        return ""
    names = {
        "static": ["associative"],
        "kinematic": ["associative"],
        "coulomb": ["coulomb", "mcp", "nonassociative"],
    }
    known = result.assembly.scene.reference
    name = next((name for name in names.get(result.method, [result.method]) if name in known), None)
    load_factor, kind, difference = result.load_factor, "", ""
    if name is None and "associative" in known and result.associative is not None:
        name, load_factor, kind = "associative", result.associative, "associative "
    if name is None:
        return ""
    reference = known[name]
    if load_factor is not None and reference.value:
        percent = numeral(100 * (load_factor / reference.value - 1), "+.3f")
        difference = f"; the {kind}λ of this result differs from the reference by {percent} %"
    value = numeral(reference.value, ".7g")
    return f"{kind}{value} ({reference.source}{_name_in_case(known, name, result)}){difference}"


def _name_in_case(known: Mapping[str, Reference], name: str, result: Outcome) -> str:
    """Return a note with the name of a reference value in the case file, or "" if no note is needed.

    No note is needed if the reference value has the name of the method, or the name "associative". If the
    case file also has the reference value of an MPEC, the note adds this value.
    """
    if name in (result.method, "associative"):
        return ""
    mpec = f", which also has 'mpec' = {numeral(known['mpec'].value, '.7g')}" if "mpec" in known else ""
    return f"; value '{name}' of the case file{mpec}"


def _technical(result: Outcome) -> dict[str, str]:
    """Return the technical lines of a summary, such as residuals and times, as a dict from label to text."""
    size = result.size
    certificate = result.certificate.as_dict() if result.certificate else {}
    if result.stability:
        certificate = {"equilibrium": result.stability.equilibrium, "yield": result.stability.yield_}
    largest = f"{counted(size.rows or 0, 'row')}, {size.columns} columns, {size.nonzeros} non-zeros"
    return {
        "method": f"{result.method} ({result.model}, {result.solver})",
        "status": ": ".join(filter(None, (result.status, message(result.reasons, result.method)))),
        "steps": "\n".join(log_sentences(result)),
        "range": _range(result),
        "certificate": "   ".join(f"{name} {numeral(value, '.1e')}" for name, value in certificate.items()),
        "alignment": _alignment(result),
        "existence": str(result.infeasibility.existence) if result.infeasibility else "",
        "programs": _programs(result),
        "largest program": "" if size.rows is None else largest,
        "solvers": "   ".join(f"{purpose}: {', '.join(names)}" for purpose, names in result.solvers.items()),
        "seconds": "   ".join(f"{part} {value:.3f}" for part, value in result.seconds.items()),
        "not modelled": "\n".join(left_out(result.assembly)),
    }


def log_sentences(result: Outcome) -> Iterator[str]:
    """Describe each step of the method in a sentence, with its duration and the lowest λ known after it."""
    for entry in result.solution.log:
        known = "no load factor yet"
        if entry.load_factor is not None:
            known = f"λ = {numeral(entry.load_factor, '.6g')}"
        states = f", {counted(entry.exact_states, 'exact state')}" if entry.exact_states else ""
        note = f", {entry.note}" if entry.note else ""
        yield f"{entry.step}: {known}{states}{note} ({entry.seconds:.2f} s)"


def _alignment(result: Outcome) -> str:
    """Return a text about the largest changes that the alignment made to joints, or "" if none changed."""
    if not result.largest_turn and not result.largest_shift:
        return ""
    return (
        f"joints were turned by up to {result.largest_turn:.1e} rad, and contact points were moved by up to "
        f"{result.largest_shift:.1e} (tolerance {result.assembly.geometry.tolerance:.1e})"
    )


def _range(result: Outcome) -> str:
    """Return the bounds on the least load factor as text, or "" if there are no bounds to print."""
    lower, upper = result.range
    known = lower is None and result.load_factor is not None
    if result.kind is Kind.ASSOCIATIVE or known or upper is None:
        return ""
    return f"{'' if lower is None else numeral(lower, '.7f') + ' ≤ '}λ ≤ {numeral(upper, '.7f')}"


def _programs(result: Outcome) -> str:
    """Return a text with the numbers of solved optimisation programs and of solver iterations.

    If no program was solved, the text has the number of load steps instead, or is empty without load steps.
    """
    if not result.lp_solves and not result.nlp_solves:
        return f"none: {counted(result.iterations, 'load step')}" if result.iterations else ""
    nonlinear = f" and {result.nlp_solves} nonlinear" if result.nlp_solves else ""
    cones = "" if result.size.contacts is None else " or of cones"
    return f"{result.lp_solves} linear{cones}{nonlinear} ({counted(result.iterations, 'solver iteration')})"


def left_out(assembly: Assembly) -> tuple[str, ...]:
    """Return phrases about motions that are not modelled, such as sliding with unlimited friction."""
    problem, joints = assembly.problem, assembly.joints
    unlimited = len(assembly.joints_of(np.delete(np.arange(problem.joints), problem.sliding)))
    counts = {
        f"sliding of {counted(unlimited, 'joint')}, whose friction is unlimited": unlimited,
        f"opening and sliding of {counted(joints.fixed_pairs, 'joint')} between fixed blocks, because these "
        "blocks cannot move": joints.fixed_pairs,
    }
    return tuple(phrase for phrase, number in counts.items() if number)
