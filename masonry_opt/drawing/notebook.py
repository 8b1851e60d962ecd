"""What a notebook shows of a result: no script, and nothing by name that could clash with another."""

from __future__ import annotations

from base64 import b64encode

from masonry_opt.answer.outcome import Outcome
from masonry_opt.drawing.elements import START, Elements, result_elements
from masonry_opt.drawing.page import caption
from masonry_opt.drawing.pictures import result_picture
from masonry_opt.drawing.svg import Canvas, blocks_svg, legend_svg, marks_svg
from masonry_opt.words.page import headline, text
from masonry_opt.words.sentences import message, numeral, sentences
from masonry_opt.words.summary import load_factors

#: Blocks above which there is no picture: a notebook keeps all that it shows.
MOST_BLOCKS = 2000

#: Width of the picture at most, in pixels; it is never taller than half as much again.
_WIDTH = 560


def notebook_html(result: Outcome) -> str:
    """Load factor, status, picture and certificate of a result, as HTML that stands by itself."""
    elements = result_elements(result)
    status = text(": ".join(filter(None, (result.status, message(result.reasons)))))
    lines = [
        f"<b>{text(elements.title)}</b>",
        f'<span style="font-size:1.4em">{headline(result)}</span>',
        status,
        text(load_factors(result)),
        *(f"Warning: {text(words)}" for words in sentences(result.warnings)),
    ]
    if result.size.blocks <= MOST_BLOCKS:
        in_space = result.assembly.scene.dimension == 3
        lines.append(_image(result) if in_space else _picture(elements))
    lines.append(caption(elements))
    if result.certificate is not None:
        residuals = (
            f"{name} {numeral(value, '.1e')}" for name, value in result.certificate.as_dict().items()
        )
        lines.append(f"certificate: {' · '.join(residuals)}")
    rows = "".join(f"<div>{line}</div>\n" for line in lines)
    return f'<div style="max-width:{_WIDTH}px;overflow-wrap:break-word">\n{rows}</div>'


def _image(result: Outcome) -> str:
    """The picture of solids, with its own title and legend."""
    source = b64encode(result_picture(result).image("png")).decode()
    return f'<img alt="picture of the mechanism" style="width:100%" src="data:image/png;base64,{source}">'


def _picture(elements: Elements) -> str:
    marks = elements.shown("mechanism")
    canvas = Canvas(elements, marks, START)
    drawn = [blocks_svg(elements, canvas), *(marks_svg(each, canvas) for each in marks)]
    width = min(_WIDTH, 1.5 * _WIDTH * canvas.width / canvas.height)
    style = f'style="display:block;width:100%;max-width:{width:.0f}px;background:#fff"'
    item = '<li style="display:inline-block;margin-right:1em">'
    listed = "".join(f"{item}{entry}</li>" for entry in legend_svg(marks))
    keys = f'<ul style="list-style:none;margin:0;padding:0;font-size:.9em">{listed}</ul>'
    return canvas.svg(f"picture of {elements.title}", drawn, style) + keys
