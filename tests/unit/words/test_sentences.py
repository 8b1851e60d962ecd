"""Every reason has its sentence; a few of them, with numbers and names to be made, word for word."""

import re
from math import inf

import pytest
from scenes import two_blocks

import masonry_opt as mo
from masonry_opt.answer.reasons import Code, reason
from masonry_opt.words.sentences import message, numeral

#: A value of each name that a reason has, as ``solve`` gives it.
VALUES = {
    "above": 1.44,
    "associative": 0.6,
    "beyond": 0.6,
    "blocks": ["A"],
    "bound": 0.25,
    "by": 1e-6,
    "candidates": 12,
    "count": 7,
    "dilatancy": -2.0,
    "distance": 120.0,
    "draws": 12,
    "elastic": 0.9,
    "epsilon": 3e-9,
    "exact": True,
    "factor": 1.4434,
    "fall": 1e-3,
    "first": str(mo.Status.CYCLING),
    "folds": 4,
    "forces": True,
    "friction": 0.5,
    "change": 2e-3,
    "gap": 1e-4,
    "give": 1e-4,
    "hangs": False,
    "highest": 0.5,
    "in_vain": False,
    "interrupted": True,
    "joints": 9000,
    "kinematic_cuts": 1,
    "last": 0.4,
    "least": 0.4,
    "left_out": 2,
    "length": 0.5,
    "load": "dead",
    "load_factor": 0.5,
    "lowest": 0.4,
    "most": 0.6,
    "normal_forces": [12.5],
    "fixed": True,
    "against": False,
    "names": ["lorry"],
    "number": 3,
    "off": 0.1,
    "pairs": [["A", "B"]],
    "peak": 0.5,
    "deep_fall": (0.4, 0.3),
    "stiffness": (0.4, 0.5),
    "stress": None,
    "without": 1,
    "period": 2,
    "rates": 100.0,
    "ratio": 1000.0,
    "remedies": ["beta=0.3"],
    "residuals": {"flow": 0.1},
    "size": 3.0,
    "softer": 10.0,
    "states": 21,
    "static_cuts": 2,
    "status": str(mo.Status.LOCKED),
    "steps": 27,
    "time_limit": 60.0,
    "widths": [1e-3],
    "word": "unknown",
}


@pytest.mark.parametrize("code", Code)
def test_every_code_has_a_sentence(code):
    sentence = message([reason(code, **VALUES)])
    assert len(sentence.split()) >= 3
    assert not re.search(r"[{}]|\bNone\b|Code\.", sentence)


#: By code: reasons whose numbers and names take some making, and the sentence.
WORDS = {
    Code.FALLS: (
        reason(Code.FALLS, blocks=["A", "B"]),
        "the dead load alone moves blocks 'A', 'B': support what falls",
    ),
    Code.FRICTION_WOULD_HOLD: (
        reason(Code.FRICTION_WOULD_HOLD, pairs=[["A", "B"]], factor=1.44341, above=1.443, hangs=False),
        "'A'–'B' slides: the scene would stand with all friction at least 1.444 times as high",
    ),
    Code.PROVEN: (
        reason(Code.PROVEN, bound=-0.0, load_factor=-3e-17, rates=None, forces=False),
        "proven least: 0 ≤ λ ≤ 0",
    ),
    Code.JOINTS: (
        reason(Code.JOINTS, status=str(mo.Status.UNLIMITED), pairs=[[f"{n}", "X"] for n in range(8)]),
        "the joints that carry it: '0'–'X', '1'–'X', '2'–'X', '3'–'X', '4'–'X' and 3 more",
    ),
    Code.CURVE: (
        reason(Code.CURVE, states=12, left_out=17, peak=0.0424138, last=0.0066129),
        "λ over displacement, in 12 states (17 more were not found), falls from 0.04241 to 0.006613",
    ),
    Code.SPREAD: (
        reason(Code.SPREAD, draws=12, stiffness=(0.15, 0.25), stress=None, without=13),
        "to expect, of 12 draws each: 0.15–0.25 with other stiffness of contacts, none from other "
        "self-stress (13 of these pushes came to no collapse)",
    ),
}


@pytest.mark.parametrize("code", WORDS)
def test_words(code):
    given, words = WORDS[code]
    assert message([given]) == words


def test_several_reasons_are_one_message():
    result = mo.solve(two_blocks(), "nonassociative", max_iterations=2, remedies="none")
    assert len(result.reasons) == 2
    assert result.message == "; ".join(message([reason]) for reason in result.reasons)
    assert mo.solve(two_blocks(), "static").message == ""


@pytest.mark.parametrize(
    ("value", "spec", "text"),
    [
        (-0.0, ".6g", "0"),
        (-4e-8, ".7f", "0.0000000"),
        (-6e-8, ".7f", "-0.0000001"),
        (-0.0, ".1e", "0.0e+00"),
        (-4e-4, "+.3f", "0.000"),
        (4e-4, "+.3f", "0.000"),
        (0.01, "+.3f", "+0.010"),
        (-1e-17, ".6g", "-1e-17"),
        (-inf, ".6g", "-inf"),
        (inf, ".7f", "inf"),
        (1234567.25, ".7f", "1234567.2500000"),
        (1.5e300, ".7f", "1.5000000e+300"),
        (-2e12, "+.3f", "-2.000e+12"),
        (-0.0, "g", "0"),
    ],
)
def test_no_sign_before_a_zero_and_no_digits_that_are_none(value, spec, text):
    assert numeral(value, spec) == text
