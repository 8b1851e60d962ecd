"""A result in plain words, and its technical lines: what ``print`` and the command show."""

from collections import Counter
from collections.abc import Iterable, Iterator

import numpy as np

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.motion import joint_motion, moving_blocks
from masonry_opt.answer.outcome import Outcome
from masonry_opt.answer.reasons import Code, Status
from masonry_opt.answer.thresholds import ZERO
from masonry_opt.errors import counted, printable
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role
from masonry_opt.scene.case_file import CaseFile
from masonry_opt.words.load_factors import (
    ASSOCIATIVE,
    FOUND,
    INCREMENTAL,
    LEAST,
    LOWEST,
    friction_law,
    load_factor_table,
    own_name,
    why_not_incremental,
)
from masonry_opt.words.names import labelled, verb
from masonry_opt.words.sentences import BY_CHORDS, message, numeral, sentences

#: Codes that tell what was tried, and nothing of the scene.
_TRIED = (Code.BEGAN_AGAIN, Code.CURVE, Code.SPREAD)

_TIES = 4  #: Ties and props that are told of.


def summary(result: Outcome, technical: bool = False) -> str:
    """Return a result in words: its load factors, what moves, its loads, and warnings.

    If ``technical``, residuals, programs, solvers and times follow.
    """
    size = result.size
    numbers = {"block": size.blocks, "joint": size.joints, "contact": size.contacts}
    count = ", ".join(counted(number, noun) for noun, number in numbers.items() if number is not None)
    ended = "" if result.status.usable else f"no load factor: {result.status}"
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
    """Return what is known of a result besides its load factors and status, in plain words by labels."""
    known = {
        "why": _why(result),
        "incremental": why_not_incremental(result) if _says_why_not_incremental(result) else "",
        **dict(filter(None, [motion(result)])),
        "ties": _ties(result),
        "live load": _live_load(result),
        "fill": "\n".join(of_fills(result.assembly)),
        "curve": "".join(_said(result, Code.CURVE)),
        "spread": "".join(_said(result, Code.SPREAD)),
        "friction": _friction(result),
        "crushing": _crushing(result),
        "reference": _reference(result),
    }
    return {label: words for label, words in known.items() if words}


def _says_why_not_incremental(result: Outcome) -> bool:
    """True if a scene without a load factor carries its dead load, so that a load history was computed."""
    return result.load_factor is None and result.status is not Status.UNSTABLE


def _said(result: Outcome, *codes: Code) -> tuple[str, ...]:
    """Sentences of the reasons with these codes."""
    return sentences([said for said in result.reasons if said.code in codes], result.method)


def _why(result: Outcome) -> str:
    """Why there is no load factor, without what was tried; or why there is one without work."""
    if result.status.usable:
        return "".join(_said(result, Code.NO_WORK))
    told = [reason for reason in result.reasons if reason.code not in _TRIED] or result.reasons
    return "\n".join(dict.fromkeys(sentences(told, result.method)))


#: Labels of the motion at a load factor, by the name of the load factor.
_AT = {
    LOWEST: "at the lowest",
    LEAST: "at the least",
    FOUND: "at the state found",
    INCREMENTAL: "at incremental collapse",
    ASSOCIATIVE: "at associative collapse",
}


def motion(result: Outcome) -> tuple[str, str] | None:
    """Return how many blocks move and what the joints do, with a label; None if no motion is known."""
    if result.solution.d is None:
        return None
    of = joint_motion(result.assembly, result.solution)
    moving = len(moving_blocks(result.assembly, result.solution.d))
    counts = {"slide": of.slides.sum(), "hinge": of.hinges.sum()}
    counts |= {"open": of.separates.sum(), "crush": of.crushes.sum()}
    said = [f"{count} {verb(int(count), word)}" for word, count in counts.items() if count]
    joints = f"; of the joints {', '.join(said)}" if said else ""
    blocks = f"{moving} of {counted(result.size.blocks, 'block')}"
    if result.load_factor is None:
        return "falls" if result.status is Status.UNSTABLE else "moves", f"{blocks}{joints}"
    return _AT[own_name(result)], f"{blocks} {verb(moving, 'move')}{joints}"


def _ties(result: Outcome) -> str:
    """Return which ties and props yield and what the others carry.

    The text is empty for a scene without ties and props, and for a scene that falls.
    """
    # The table of ties is a pandas frame, and importing pandas takes a quarter of a second.
    if not any(force.role in (Role.TIE, Role.PROP) for force in result.assembly.limited):
        return ""
    if result.ties["force"].isna().all():
        return ""
    told = []
    for tie in result.ties.sort_values("yields", ascending=False, kind="stable").to_dict("records"):
        does = "yields at" if tie["yields"] else "carries"
        # Rounding of a solver is no force.
        carried = 0.0 if abs(tie["force"]) <= ZERO else tie["force"]
        force = "" if np.isnan(carried) else f" {does} {numeral(carried, '.5g')}"
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


def _friction(result: Outcome) -> str:
    """Return which law limits friction in space, and at which points forces act."""
    if result.size.contacts is None:
        return ""
    unlimited, incremental = not len(result.assembly.problem.sliding), result.at_incremental
    said = [friction_law(result)] if unlimited or result.friction_law else []
    if result.incremental is not None and incremental and incremental.friction_law != result.friction_law:
        said.append(f"incremental λ {friction_law(incremental)}")
    if result.load_factor is not None:
        said.append("forces act at contacts, the corners of joints")
    return "; ".join(said)


def _crushing(result: Outcome) -> str:
    """By which law joints crush, in the load factor and in what stands beside it."""
    if not result.crushing or (result.load_factor is None and result.associative is None):
        return ""
    if result.crushing == "parabola":
        return f"by the parabola itself; all but 'static' and 'kinematic' with Clarabel take {BY_CHORDS}"
    beside = "" if result.kind is Kind.ASSOCIATIVE else "; the associative λ by the same"
    return f"by {BY_CHORDS}{beside}"


def _reference(result: Outcome) -> str:
    """Return the case file's reference value for the method, and how far λ is from it.

    For "coulomb" this may be the value of an MCP or of the loop: all answer for Coulomb's joints. Without
    such a value the associative reference value is compared with the associative λ. The text is empty for a
    load case: a case file does not say of which one its values are.
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
    found, of, off = result.load_factor, "", ""
    if name is None and "associative" in known and result.associative is not None:
        name, found, of = "associative", result.associative, "associative "
    if name is None:
        return ""
    reference = known[name]
    if found is not None and reference.value:
        off = f", {of}here {numeral(100 * (found / reference.value - 1), '+.3f')} %"
    return f"{of}{reference.value} ({reference.source}){off}"


def _technical(result: Outcome) -> dict[str, str]:
    size = result.size
    certificate = result.certificate.as_dict() if result.certificate else {}
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
        "solvers": "   ".join(f"{what}: {', '.join(names)}" for what, names in result.solvers.items()),
        "seconds": "   ".join(f"{part} {value:.3f}" for part, value in result.seconds.items()),
        "not modelled": "\n".join(left_out(result.assembly)),
    }


def log_sentences(result: Outcome) -> Iterator[str]:
    """Yield a sentence for each step of the method: what is known after it, and how long it took."""
    for entry in result.solution.log:
        known = "no load factor yet"
        if entry.load_factor is not None:
            known = f"λ = {numeral(entry.load_factor, '.6g')}"
        states = f", {counted(entry.exact_states, 'exact state')}" if entry.exact_states else ""
        yield f"{entry.step}: {known}{states} ({entry.seconds:.2f} s)"


def _alignment(result: Outcome) -> str:
    """Return by how much contacts were aligned within the accuracy of the drawing; "" where they were not."""
    if not result.largest_turn and not result.largest_shift:
        return ""
    moved = f"joints turned by up to {result.largest_turn:.1e} rad, contact points moved by up to"
    return f"{moved} {result.largest_shift:.1e} (tolerance {result.assembly.geometry.tolerance:.1e})"


def _range(result: Outcome) -> str:
    """Between what the least load factor lies, where more is known than the answer itself."""
    lower, upper = result.range
    known = lower is None and result.load_factor is not None
    if result.kind is Kind.ASSOCIATIVE or known or upper is None:
        return ""
    return f"{'' if lower is None else numeral(lower, '.7f') + ' ≤ '}λ ≤ {numeral(upper, '.7f')}"


def _programs(result: Outcome) -> str:
    if not result.lp_solves and not result.nlp_solves:
        return f"none: {counted(result.iterations, 'load step')}" if result.iterations else ""
    nonlinear = f" and {result.nlp_solves} nonlinear" if result.nlp_solves else ""
    cones = "" if result.size.contacts is None else " or of cones"
    return f"{result.lp_solves} linear{cones}{nonlinear} ({counted(result.iterations, 'solver iteration')})"


def left_out(assembly: Assembly) -> tuple[str, ...]:
    """What a scene did not need, each with its reason."""
    problem, joints = assembly.problem, assembly.joints
    unlimited = len(assembly.joints_of(np.delete(np.arange(problem.joints), problem.sliding)))
    found = {
        f"sliding of {counted(unlimited, 'joint')}: friction is unlimited": unlimited,
        f"{counted(joints.fixed_pairs, 'joint')} between two fixed blocks: neither moves": joints.fixed_pairs,
    }
    return tuple(said for said, number in found.items() if number)
