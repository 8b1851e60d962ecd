"""Colours have one home."""

from __future__ import annotations

from pathlib import Path

import masonry_opt
from masonry_opt.drawing import colours
from masonry_opt.drawing.colours import SERIES

PACKAGE = Path(masonry_opt.__file__).parent


def test_no_other_module_has_colours_of_its_own():
    named = {colours.BLUE, colours.VERMILION, colours.BLUISH_GREEN, colours.REDDISH_PURPLE, colours.ORANGE}
    named |= {colours.SKY_BLUE, colours.BLACK}
    assert set(SERIES) == named
    assert len(SERIES) == len(named) == 7
    home = PACKAGE / "drawing" / "colours.py"
    others = [path for path in PACKAGE.rglob("*.py") if path != home]
    assert len(others) > 100
    repeated = named - {colours.BLACK}
    assert not [
        path for path in others if any(colour in path.read_text("utf-8").upper() for colour in repeated)
    ]
