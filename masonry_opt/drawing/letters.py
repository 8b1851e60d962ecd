"""Letters that a picture's font does not have: matplotlib would warn of each."""

from __future__ import annotations

from functools import cache

from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.text import Text

#: What is drawn for each, and what is said of it.
_BOX = "\N{WHITE SQUARE}"
NOTE = f"{_BOX}: a letter that the font of pictures does not have; matplotlib.rcParams['font.family'] sets it"


def boxed(text: str, font: FontProperties | None = None) -> str:
    """The text with a box for each letter that a font (the usual one), and those after it, lack."""
    if text.isascii():
        return text
    font = font or FontProperties()
    known = {ord("\n")}
    for family in font.get_family():
        own = font.copy()
        own.set_family(family)
        known |= _letters(findfont(own))
    return "".join(letter if ord(letter) in known else _BOX for letter in text)


@cache
def _letters(path: str) -> frozenset[int]:
    """The letters of a font's file, as code points."""
    return frozenset(get_font(path).get_charmap())


def replace_missing(figure: Figure) -> bool:
    """Draw boxes for such letters in all of a figure's texts but labels of ticks; whether there were any."""
    replaced = False
    for text in figure.findobj(Text):
        if (shown := boxed(text.get_text(), text.get_fontproperties())) != text.get_text():
            text.set_text(shown)
            replaced = True
    return replaced
