"""What a notebook shows of a result: no script, and nothing by name that could clash with another."""

from __future__ import annotations

from masonry_opt.answer.result import Result
from masonry_opt.report.motion import has_mechanism
from masonry_opt.report.page.arrows import draw_loads
from masonry_opt.report.page.drawing import Pen, draw_blocks, draw_mechanism, svg
from masonry_opt.report.page.keys import caption, marks
from masonry_opt.report.page.view import START, view_of
from masonry_opt.words.page import headline, text, title_of
from masonry_opt.words.sentences import numeral

#: Blocks above which there is no picture: a notebook keeps all that it shows.
MOST_BLOCKS = 2000

#: Width of the picture at most, in pixels; it is never taller than half as much again.
_WIDTH = 560


def notebook_html(result: Result) -> str:
    """Load factor, status, picture and certificate of a result, as HTML that stands by itself."""
    status = text(f"{result.status}{': ' + result.message if result.message else ''}")
    lines = [
        f"<b>{text(title_of(result))}</b>",
        f'<span style="font-size:1.4em">{headline(result)}</span>',
        status,
        *(f"Warning: {text(words)}" for words in result.warning_sentences),
    ]
    if result.size.blocks <= MOST_BLOCKS:
        lines.append(_picture(result))
    lines.append(caption(result))
    if result.certificate is not None:
        residuals = (
            f"{name} {numeral(value, '.1e')}" for name, value in result.certificate.as_dict().items()
        )
        lines.append(f"certificate: {' · '.join(residuals)}")
    rows = "".join(f"<div>{line}</div>\n" for line in lines)
    return f'<div style="max-width:{_WIDTH}px;overflow-wrap:break-word">\n{rows}</div>'


def _picture(result: Result) -> str:
    view = view_of(result)
    pen = Pen(view, START)
    layers = [draw_blocks(result, pen), draw_loads(result, pen)]
    if has_mechanism(result):
        layers.append(draw_mechanism(result, pen))
    width = min(_WIDTH, 1.5 * _WIDTH * view.width / view.height)
    style = f'style="display:block;width:100%;max-width:{width:.0f}px;background:#fff"'
    drawn = svg(view, f"picture of {title_of(result)}", layers, style)
    item = '<li style="display:inline-block;margin-right:1em">'
    listed = "".join(f"{item}{mark}</li>" for mark in marks(result))
    return f'{drawn}<ul style="list-style:none;margin:0;padding:0;font-size:.9em">{listed}</ul>'
