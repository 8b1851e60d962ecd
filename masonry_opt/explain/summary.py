"""A result in a few lines: what `print` and the command show."""

from __future__ import annotations

import numpy as np

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.reasons import Code
from masonry_opt.answer.result import Result
from masonry_opt.errors import printable
from masonry_opt.explain.sentences import numeral
from masonry_opt.explain.stressed_joints import stressed_joints

#: Percent of λ below which dilatancy adds nothing that can be told from rounding.
_NOTHING = 1e-4

#: What an associative answer is.
_ASSOCIATIVE = "joints open as they slide; those that do not (Coulomb) carry as much or less"


def summary_text(result: Result) -> str:
    """A result in a few lines."""
    certificate = result.certificate.as_dict() if result.certificate else {}
    lines = {
        "case": result.case,
        "method": f"{result.method} ({result.model}, {result.solver})",
        "status": f"{result.status}{': ' + result.message if result.message else ''}",
        "load factor": "none" if result.load_factor is None else numeral(result.load_factor, ".7f"),
        "tilt angle": _tilt(result),
        "coulomb state": _state(result),
        "associative": _associative(result),
        "range": _range(result),
        "blocks × joints": f"{result.size.blocks} × {result.size.joints}",
        "certificate": "   ".join(f"{name} {value:.1e}" for name, value in certificate.items()),
        "existence": str(result.infeasibility.existence) if result.infeasibility else "",
        "dilatancy": _dilatancy(result),
        "programs": _programs(result),
        "solvers": "   ".join(f"{what}: {', '.join(names)}" for what, names in result.solvers.items()),
        "seconds": "   ".join(f"{part} {value:.3f}" for part, value in result.seconds.items()),
        "reference": _reference(result),
        "not modelled": "\n                 ".join(result.size.left_out),
    }
    text = [f"{name:<16} {value}" for name, value in lines.items() if value]
    text += [f"warning: {sentence}" for sentence in result.warning_sentences]
    return printable("\n".join(text))


def facts(result: Result) -> dict[str, str]:
    """What is known of a result beside its load factor and status: by a label each, in words."""
    of_joints_that_open = result.load_factor is not None and result.kind is Kind.ASSOCIATIVE
    known = {
        "found" if result.status.usable else "why": result.message,
        "tilt angle": _tilt(result),
        "coulomb state": _state(result),
        "associative": _ASSOCIATIVE if of_joints_that_open else _associative(result),
        "range": _range(result),
        "dilatancy": _dilatancy(result),
        "reference": _reference(result),
    }
    return {label: printable(words) for label, words in known.items() if words}


def _tilt(result: Result) -> str:
    """How far the ground can be tilted, and to which side."""
    if result.tilt_angle is None:
        return ""
    return f"{result.tilt_angle:.4f}° to the {result.assembly.scene.tilt}"


def _state(result: Result) -> str:
    """Whether a Coulomb answer is an exact state, and that it need not be the lowest."""
    if result.load_factor is None or result.kind is Kind.ASSOCIATIVE:
        return ""
    if any(reason.code is Code.PROVEN for reason in result.reasons):
        return "exact, and none is lower"
    exact = "exact" if result.exact else "not exact (see the certificate)"
    return f"{exact}; lower ones may exist: method 'refined' with option 'search' looks for them"


def _associative(result: Result) -> str:
    """What dilatancy would add to a Coulomb answer."""
    if result.associative is None or result.kind is Kind.ASSOCIATIVE:
        return ""
    value = numeral(result.associative, ".7f")
    if not result.load_factor:
        return value
    adds = 100 * (result.associative / result.load_factor - 1)
    return f"{value}: dilatancy would add {f'{adds:.3g} %' if adds > _NOTHING else 'nothing'}"


def _range(result: Result) -> str:
    """Between what the least load factor lies, where more is known than the answer itself."""
    lower, upper = result.range
    if result.kind is Kind.ASSOCIATIVE or (lower is None and result.load_factor is not None):
        return ""
    if upper is None:
        return ""
    return f"{'' if lower is None else numeral(lower, '.7f') + ' ≤ '}λ ≤ {numeral(upper, '.7f')}"


def _programs(result: Result) -> str:
    if not result.lp_solves and not result.nlp_solves:
        return f"none: {result.iterations} Newton steps" if result.iterations else ""
    nonlinear = f" and {result.nlp_solves} nonlinear" if result.nlp_solves else ""
    return f"{result.lp_solves} linear{nonlinear} ({result.iterations} solver iterations)"


def _dilatancy(result: Result) -> str:
    """What an associative answer owes to joints too highly stressed to dilate, by the scene's own law."""
    has_law = np.isfinite(result.assembly.problem.dilatancy_force[:, 1]).any()
    if not has_law or result.load_factor is None or result.method not in ("static", "kinematic"):
        return ""
    stressed = stressed_joints(result)
    if stressed.empty:
        return ""
    worst = max(stressed.to_dict("records"), key=lambda joint: joint["stress"])
    return (
        f"not credible in {len(stressed)} sliding joints, with {stressed['energy'].sum():.3g} of λ: stressed "
        f"above 'dilatancy_stress', most in {worst['first']!r}–{worst['second']!r} ({worst['stress']:.3g})"
    )


def _reference(result: Result) -> str:
    """The case file's own reference value for the method, and how far the result is from it.

    Where none is known of the complementarity problem the loop's serves: both answer for Coulomb's joints.
    """
    names = {"static": ["associative"], "kinematic": ["associative"], "mcp": ["mcp", "nonassociative"]}
    known = result.assembly.scene.reference
    name = next((name for name in names.get(result.method, [result.method]) if name in known), None)
    if name is None:
        return ""
    reference = known[name]
    off = ""
    if result.load_factor is not None and reference.value:
        off = f", here {numeral(100 * (result.load_factor / reference.value - 1), '+.3f')} %"
    return f"{reference.value} ({reference.source}){off}"
