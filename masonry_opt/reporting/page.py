"""Write the text on a result for a page or a notebook, as HTML."""

from html import escape

from masonry_opt.errors import printable
from masonry_opt.reporting.load_factors import factor_text, load_factor_lines, own_name, value_text
from masonry_opt.reporting.names import pairs, verb
from masonry_opt.reporting.sentences import numeral, sentences
from masonry_opt.reporting.stability import STABLE
from masonry_opt.reporting.summary import facts, left_out
from masonry_opt.solution.acceptance import LIMITS
from masonry_opt.solution.outcome import Outcome
from masonry_opt.solution.stability import Stability

#: Explanation of each residual of the certificate, as printed on an HTML page.
RESIDUAL_MEANINGS = {
    "equilibrium": "out-of-balance forces, relative to the dead load",
    "yield": (
        "violation of a yield condition (friction, compression, rocking), relative to the median dead load "
        "of a block"
    ),
    "flow": "motion that violates the flow rule, relative to the largest velocity",
    "complementarity": (
        "energy of joints that move but do not yield, relative to the work of the live load at λ = 1"
    ),
}


def text(words: str) -> str:
    """Return text as HTML, with special characters escaped and line breaks as ``<br>``."""
    return escape(printable(words)).replace("\n", "<br>")


def headline(result: Outcome) -> str:
    """Return the main answer of a result as HTML: the load factor with its name, or "no load factor".

    For a scene without live load, the answer states if the scene is stable.
    """
    if result.stability:
        return text(STABLE)
    if result.load_factor is None:
        words = "no load factor" if result.assembly.problem.live_norm else text(result.status)
        return f'<span class="none">{words}</span>'
    tilt = ""
    if result.tilt_angle is not None:
        tilt = f" <small>tilted by {numeral(result.tilt_angle, '.2f')}°</small>"
    return f"<small>{own_name(result)}</small> λ = {factor_text(result, result.load_factor)}{tilt}"


def load_factor_rows(result: Outcome) -> str:
    """Return the table of load factors as HTML, or "" if no load factor is known."""
    rows = "".join(
        f'<tr><th scope="row">{line.name}</th><td class="number">{value_text(result, line)}</td>'
        f"<td>{text(line.remark)}</td></tr>\n"
        for line in load_factor_lines(result)
    )
    return f'<table class="load-factors">\n{rows}</table>\n' if rows else ""


def answer(result: Outcome) -> str:
    """Return the load factors, status, other facts and warnings of a result as HTML."""
    known = {"status": str(result.status)} | facts(result)
    rows = "".join(f"<dt>{text(label)}</dt><dd>{text(words)}</dd>\n" for label, words in known.items())
    warnings = "".join(f"<li>Warning: {text(words)}</li>\n" for words in sentences(result.warnings))
    list_of_warnings = f'<ul class="warnings">\n{warnings}</ul>\n' if warnings else ""
    table = load_factor_rows(result)
    return f'<p class="load-factor">{headline(result)}</p>\n{table}<dl>\n{rows}</dl>\n{list_of_warnings}'


def certificate(result: Outcome) -> str:
    """Return the residuals of the certificate as a table in HTML.

    For a result without load factor, the text states what is proven about the existence of a load factor.
    Without a proof the text is empty.
    """
    if result.stability:
        return _of_forces(result.stability)
    if result.certificate is None:
        proven = result.infeasibility
        return f"<h2>Existence</h2>\n<p>{text(str(proven.existence))}</p>\n" if proven else ""
    limits = LIMITS[result.kind].as_dict()
    rows = "".join(
        f'<tr><th scope="row">{name} <small>{RESIDUAL_MEANINGS[name]}</small></th>'
        f'<td class="number">{numeral(value, ".1e")}</td><td class="number">{limits[name]:g}</td></tr>\n'
        for name, value in result.certificate.as_dict().items()
    )
    return (
        '<h2>Certificate</h2>\n<table class="certificate"><thead><tr><th scope="col">residual</th>'
        '<th scope="col" class="number">found</th><th scope="col" class="number">at most</th></tr></thead>\n'
        f"<tbody>\n{rows}</tbody></table>\n"
    )


def _of_forces(stability: Stability) -> str:
    """Return an HTML table of residuals for a stable scene, whose joint forces carry the dead load."""
    residuals = {"equilibrium": stability.equilibrium, "yield": stability.yield_}
    rows = "".join(
        f'<tr><th scope="row">{name} <small>{RESIDUAL_MEANINGS[name]}</small></th>'
        f'<td class="number">{numeral(value, ".1e")}</td></tr>\n'
        for name, value in residuals.items()
    )
    heading = '<tr><th scope="col">residual</th><th scope="col" class="number">found</th></tr>'
    table = f'<table class="certificate"><thead>{heading}</thead>\n<tbody>\n{rows}</tbody></table>'
    return f"<h2>Certificate</h2>\n{table}\n"


def described(result: Outcome) -> str:
    """Return an HTML list that describes the motions that are not modelled, or "" if there are none."""
    items = "".join(f"<li>{text(words)}</li>" for words in left_out(result.assembly))
    return f"<h2>Not modelled</h2>\n<ul>{items}</ul>\n" if items else ""


def begins(slide: list[list[str]], part: list[list[str]], load_factor: float) -> str:
    """Return a text that names the joints that begin to slide or to open, or "" if no joint does.

    ``slide`` and ``part`` list the joints that slide and that open, each as the names of its two blocks.
    """
    phrases = [
        f"{pairs({'pairs': joints})} {verb(len(joints), 'begin')} to {motion}"
        for motion, joints in (("slide", slide), ("open", part))
        if joints
    ]
    return f"{'; '.join(phrases)} at λ = {numeral(load_factor, '.3g')}" if phrases else ""
