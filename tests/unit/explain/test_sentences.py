"""Every reason has its sentence; a few of them word for word."""

from __future__ import annotations

import re
from math import inf

import pytest
from scenes import overhanging, pressed_down, two_blocks

import masonry_opt as mo
from masonry_opt.answer.reasons import Code, reason
from masonry_opt.explain.sentences import message

#: A value of each name that a reason has, as ``solve`` gives it.
VALUES = {
    "associative": 0.6,
    "attempt": 2,
    "attempts": 3,
    "blocks": ["A"],
    "bound": 0.25,
    "by": 1e-6,
    "candidates": 12,
    "count": 7,
    "epsilon": 3e-9,
    "exact": True,
    "fall": 1e-3,
    "first": str(mo.Status.CYCLING),
    "forces": True,
    "friction": True,
    "gap": 1e-4,
    "highest": 0.5,
    "in_vain": False,
    "interrupted": True,
    "joints": 9000,
    "kinematic_cuts": 1,
    "load_factor": 0.5,
    "lowest": 0.4,
    "number": 3,
    "pairs": [["A", "B"]],
    "period": 2,
    "rates": 100.0,
    "remedies": ["beta=0.3"],
    "residuals": {"flow": 0.1},
    "static_cuts": 2,
    "status": str(mo.Status.LOCKED),
    "steps": 27,
    "time_limit": 60.0,
    "why": str(Code.NO_STATICS),
    "word": "unknown",
}


@pytest.mark.parametrize("code", Code)
def test_every_code_has_a_sentence(code):
    # A residual is a reason of NOT_REFINED alone.
    part = code is Code.RESIDUAL
    given = reason(Code.NOT_REFINED, **VALUES | {"why": str(code)}) if part else reason(code, **VALUES)
    sentence = message([given])
    assert len(sentence.split()) >= (1 if code is Code.EXACT else 3)
    assert not re.search(r"[{}]|\bNone\b|Code\.", sentence)


#: By code: a reason, and what it must read as.
WORDS = {
    Code.FALLS: (
        reason(Code.FALLS, blocks=["A", "B"], friction=False),
        "the dead load alone moves blocks 'A', 'B': support what falls",
    ),
    Code.JOINTS: (
        reason(Code.JOINTS, status=str(mo.Status.UNLIMITED), pairs=[[f"{n}", "X"] for n in range(8)]),
        "the joints that carry it: '0'–'X', '1'–'X', '2'–'X', '3'–'X', '4'–'X' and 3 more",
    ),
    Code.BEGAN_AGAIN: (
        reason(Code.BEGAN_AGAIN, first="solver failed", remedies=["alpha=0.1", "beta=0.3"], in_vain=True),
        "the first run ended 'solver failed', so the loop began again with alpha=0.1, then with beta=0.3: "
        "in vain",
    ),
    Code.NOT_CERTIFIED: (
        reason(Code.NOT_CERTIFIED, load_factor=0.4, residuals={"work": inf}),
        "the answer found, 0.4, is not borne out by its certificate (the live load drives nothing): try "
        "another solver, and look for weights or lengths of very different size",
    ),
    Code.REPEATS: (
        reason(Code.REPEATS, period=2, lowest=0.25, highest=0.3, exact=False),
        "the loop repeats itself every 2 sub-problems, between load factors 0.25 and 0.3: lower 'beta'",
    ),
    Code.NOT_REFINED: (
        reason(Code.NOT_REFINED, why=str(Code.NO_KINEMATICS)),
        "not refined: kinematics allow no mechanism",
    ),
    Code.TOO_LARGE: (
        reason(Code.TOO_LARGE, joints=9000),
        "with 9000 joints the loop is quicker than a pass",
    ),
    Code.EXACT: (reason(Code.EXACT, fall=-1e-4), "exact, 1.0e-04 above its start, which is not exact"),
}


@pytest.mark.parametrize("code", WORDS)
def test_words(code):
    given, words = WORDS[code]
    assert message([given]) == words


def test_several_reasons_are_one_message():
    result = mo.solve(two_blocks(), "nonassociative")
    assert result.message == "in 6 sub-problems; with an exact state on their mechanism"
    assert result.message == message(result.reasons)
    assert re.fullmatch(r"in \d+ Newton steps", mo.solve(two_blocks(), descent=False).message)
    exact = mo.solve(two_blocks()).message
    assert re.fullmatch(r"in \d+ Newton steps; exact, 2\.7e-04 below its start", exact)
    assert mo.solve(two_blocks(), "static").message == ""
    falls = mo.solve(overhanging(), "nonassociative", solver="highs").message
    assert falls == "the dead load alone moves block 'A': support what falls"
    carried = mo.solve(pressed_down()).message
    assert carried.endswith("; the joints that carry it: 'A'–'floor'")
