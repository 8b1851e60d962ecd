"""The report as one HTML file: interactive charts and tables, no network needed.

Whatever comes from a case file or a solver is escaped: in tables by pandas, in charts where they are
made.
"""

from __future__ import annotations

from html import escape

import pandas as pd
import plotly.io

from masonry_opt.studies.compare import draw_plotly, frames
from masonry_opt.studies.compare.accuracy import Bounds
from masonry_opt.studies.compare.charts import charts, number
from masonry_opt.studies.compare.comparison import REPEATED_BELOW, Comparison
from masonry_opt.studies.compare.judge import GAP_FLOOR, LIMITS, OUTSIDE, TARGET
from masonry_opt.studies.compare.known_answers import ASSOCIATIVE, COULOMB
from masonry_opt.studies.compare.machine import machine, versions

_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 1200px; padding: 0 1em }
table { border-collapse: collapse; font-size: 13px; font-variant-numeric: tabular-nums }
th, td { padding: 3px 8px; border-bottom: 1px solid #ddd; text-align: left; white-space: nowrap }
th { position: sticky; top: 0; background: #f4f4f4; cursor: pointer }
.table { overflow: auto; max-height: 600px; margin: 1em 0 }
.words td { white-space: normal } input { padding: 4px; width: 20em }
"""

#: Sorts a table at a click on its head, and hides rows that do not hold what is typed.
_SCRIPT = """
for (const head of document.querySelectorAll('th')) head.onclick = () => {
  const body = head.closest('table').tBodies[0], at = head.cellIndex, up = head.dataset.up !== '1';
  head.dataset.up = up ? '1' : '0';
  const key = row => { const text = row.cells[at].textContent, number = parseFloat(text);
                       return isNaN(number) ? text : number };
  const rows = [...body.rows].sort((a, b) => { const x = key(a), y = key(b);
    return typeof x === typeof y ? (x < y ? -1 : x > y ? 1 : 0) : typeof x === 'number' ? -1 : 1 });
  if (!up) rows.reverse();
  body.append(...rows);
};
for (const box of document.querySelectorAll('input')) box.oninput = () => {
  for (const row of document.querySelectorAll('#' + box.dataset.table + ' tbody tr'))
    row.hidden = !box.value.toLowerCase().split(' ').every(w => row.textContent.toLowerCase().includes(w));
};
"""


def page(comparison: Comparison) -> str:
    """The whole file."""
    summary = comparison.summary
    parts = ["<h1>Comparison of methods and solvers</h1>", _meaning(comparison)]
    if not summary.empty:
        for index, chart in enumerate(charts(summary)):
            figure = draw_plotly.draw(chart)
            parts.append(f"<h2>{escape(chart.title)}</h2><p>{escape(chart.notes)}</p>")
            parts.append(
                plotly.io.to_html(
                    figure, full_html=False, include_plotlyjs=index == 0, config={"displaylogo": False}
                )
            )
        parts += [
            "<h2>Success rate and time, method × solver</h2>",
            _table(frames.success(summary).drop(columns="pair"), "success"),
        ]
        parts += [
            "<h2>All runs (medians of repeats)</h2>",
            '<input data-table="runs" placeholder="filter: wall_6 clarabel certified">',
            _table(summary.drop(columns="pair"), "runs"),
        ]
    parts += ["<h2>What answers are measured by</h2>", _table(_references(comparison), "references")]
    if comparison.plan.left_out:
        left_out = pd.DataFrame([vars(item) for item in comparison.plan.left_out])
        parts += ["<h2>Not applicable</h2>", _table(left_out, "left_out")]
    about = machine() | {f"version of {name}": release for name, release in versions().items()}
    parts += [
        "<h2>Machine, versions, command</h2>",
        _table(pd.DataFrame(about.items(), columns=["", " "]), "about"),
    ]
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>Comparison</title>'
        f"<style>{_STYLE}</style></head><body>{''.join(parts)}<script>{_SCRIPT}</script></body></html>\n"
    )


def _meaning(comparison: Comparison) -> str:
    """What a reader must know before the charts."""
    limits = comparison.limits
    certificates = "; ".join(
        f"{kind}: " + ", ".join(f"{name} ≤ {value:g}" for name, value in of.items())
        for kind, of in LIMITS.items()
    )
    lines = [
        f"{len(comparison.scenes)} scenes. Each run in its own process, on one core, within "
        f"{limits.time:g} s and {limits.memory:g} MB; times are medians of {limits.repeats} runs (of one "
        f"where a run takes over {REPEATED_BELOW:g} s), without reading the scene and the check of its "
        "dead load, which all share.",
        f"Certified: there is a load factor, its certificate leaves at most ({certificates}), and it lies no "
        f"more than {OUTSIDE:g} outside the certified bounds. Named correctly: there is none, and the reason "
        "is known to be the right one, by the failure atlas or by the bounds. Failed but said so: no answer "
        "(not converged, solver failed, a limit), or a reason that nobody can confirm. Wrong: a load factor "
        "without its certificate, or a load factor or reason known to be false. Success: certified or "
        "named correctly. Only what is certified is drawn as a point of time and error.",
        "Error of the associative λ: relative distance from the middle of certified bounds. Error of "
        f"Coulomb's λ: relative gap to the best exact state known, {GAP_FLOOR:g} at least; beside it the "
        "largest violation of yield in median block weights. An answer below the best exact state is not "
        "exact. One above it may still be a state of Coulomb friction: there are many, and the least is the "
        "safe one.",
        "Profiles and growth: least time, at any tolerance, to a certified answer with an error of at most "
        f"{TARGET[ASSOCIATIVE]:g} (associative) or {TARGET[COULOMB]:g} (Coulomb). Open marks and broken "
        "lines: Pyomo.",
        *comparison.notes,
    ]
    return "".join(f"<p>{escape(line)}</p>" for line in lines)


def _references(comparison: Comparison) -> pd.DataFrame:
    lines = []
    for scene in comparison.scenes:
        bounds, best = comparison.bounds.get(scene.name), comparison.best.get(scene.name)
        lines.append(
            {
                "scene": scene.name,
                "title": scene.title,
                "λ associative, at least": f"{bounds.lower:.12g}" if bounds else "",
                "at most": f"{bounds.upper:.12g}" if bounds else "",
                "certified to": _certified_to(bounds),
                "right by hand": "; ".join(f"{asks}: {claim}" for asks, claim in scene.expected.items()),
                "best exact Coulomb λ": f"{best.load_factor:.9g}" if best else "none known",
                "found by": best.method if best else "",
            }
        )
    return pd.DataFrame(lines)


def _certified_to(bounds: Bounds | None) -> str:
    if bounds is None:
        return "no bounds"
    if bounds.finite:
        return f"{bounds.width:.0e}"
    return "unstable" if bounds.unstable else "unlimited" if bounds.unlimited else "unknown"


def _table(frame: pd.DataFrame, name: str) -> str:
    html = frame.to_html(
        index=False, border=0, table_id=name, na_rep="", float_format=number, escape=True, justify="left"
    )
    return f'<div class="table">{html}</div>'
