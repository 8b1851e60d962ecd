"""Tests of joints with limited strength, against closed forms and a program of fibres."""

from functools import cache

import numpy as np
import pytest
import scipy.sparse as sp
from scenes import block_on_floor, small_wall, solved
from scipy.optimize import linprog

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.faces import CHORDS, LARGEST_CHORD_ERROR, chord_rates, crushing_energy, parabola

BY_PARABOLA = [("static", {}), ("kinematic", {})]
BY_CHORDS = [
    ("static", {"solver": "highs"}),
    ("static", {"model": "pyomo"}),
    ("kinematic", {"model": "pyomo"}),
    ("nonassociative", {}),
    ("coulomb", {}),
    ("coulomb", {"search": 0.02}),
]


def block(strength: float) -> mo.Scene:
    return block_on_floor(width=1.0, height=2.0, friction=2.0).replace(strength=strength)


@pytest.mark.parametrize("strength", [2.0, 10.0, 1000.0])
@pytest.mark.parametrize(("method", "how"), BY_PARABOLA)
def test_a_solid_block_crushes_at_its_toe(method, how, strength):
    """A block of weight 1 turns about the middle of its crushed toe: λ = (b − W/f_c)/h.

    The toe has the length W/f_c, and its middle is b/2 − W/(2 f_c) from the centroid.
    """
    result = mo.solve(block(strength), method, **how)
    assert result.required() == pytest.approx((1.0 - 1.0 / strength) / 2.0, rel=1e-8)
    assert result.certificate.worst < 1e-8


@pytest.mark.parametrize(("method", "how"), BY_CHORDS)
def test_chords_err_on_the_safe_side_and_by_no_more_than_they_say(method, how):
    result = mo.solve(block(2.0), method, **how)
    missed = 1 - result.required() / ((1.0 - 1.0 / 2.0) / 2.0)
    assert -1e-9 <= missed <= LARGEST_CHORD_ERROR
    assert result.certificate.worst < (1e-3 if method == "nonassociative" else 1e-8)


@pytest.mark.slow
def test_no_loop_is_needed_however_strong_the_stones():
    """Exact states are found for a thick arch (kN, m) whose stones carry 1,500 times its collapse load.

    1 kN acts downwards at a third of the arch. Slacks of crushing grow with the strength, and must not hide
    the load at the start.
    """
    loads = {"unit_weight": 20, "point_loads": [mo.PointLoad(voussoir=2, force=(0, -1))]}
    ring = mo.Arch(radius=3, thickness=0.6, angles=(0, 180), voussoirs=7, weights="sector", **loads)
    for dilatancy in (0.0, 0.6):
        joints = mo.JointDefaults(friction=0.6, dilatancy=dilatancy, strength=1e6)
        result = solved(mo.Scene(joints=joints, blocks=ring.blocks()), descent=dilatancy == 0.0)
        assert result.exact
        assert result.load_factor <= result.associative * (1 + 1e-7)
    assert result.load_factor == pytest.approx(result.associative, rel=1e-7)


def test_what_chords_miss():
    x = np.geomspace(1e-9, 1.0, 200_000)[:-1]
    by_chords = (np.multiply.outer(CHORDS.slope, x) + CHORDS.constant[:, None]).min(axis=0)
    missed = 1 - by_chords / parabola(x, np.ones_like(x))
    assert missed.min() > -1e-12
    assert 0.98 * LARGEST_CHORD_ERROR < missed.max() <= LARGEST_CHORD_ERROR
    low = x < 1e-4
    assert missed[low].max() < 1e-4


def test_rates_of_chords_follow_any_motion_and_dissipate_least():
    rng = np.random.default_rng(3)
    opening, rotation = rng.normal(size=(2, 400)) * np.exp(rng.normal(size=(2, 400)))
    p = chord_rates(opening, rotation)
    assert p.min() >= 0
    assert (p.sum(axis=0) * CHORDS.slope).sum(axis=1) == pytest.approx(opening, abs=1e-12)
    assert (p[1] - p[0]).sum(axis=1) == pytest.approx(rotation, abs=1e-12)
    # The energy of the polygon is the largest over its knots, at which neighbouring chords meet.
    knots = np.diff(CHORDS.constant) / -np.diff(CHORDS.slope)
    x = np.concatenate([[0.0], knots, [1.0]])
    moment = (np.multiply.outer(CHORDS.slope, x) + CHORDS.constant[:, None]).min(axis=0)
    most = (np.abs(rotation)[:, None] * moment - opening[:, None] * x).max(axis=1)
    assert (p * CHORDS.constant).sum(axis=(0, 2)) == pytest.approx(most, abs=1e-12)


def test_energy_of_the_parabola_is_the_greatest_of_all_forces():
    rng = np.random.default_rng(4)
    opening, rotation = rng.normal(size=(2, 300))
    x = np.linspace(0, 1, 20_001)
    most = (np.abs(rotation)[:, None] * x * (1 - x) - opening[:, None] * x).max(axis=1)
    assert crushing_energy(opening, rotation) == pytest.approx(most, abs=1e-7)
    still = crushing_energy(np.array([1.0, -2.0, 0.0]), np.zeros(3))
    assert still == pytest.approx([0.0, 2.0, 0.0])


ARCH = mo.Arch(
    radius=1, thickness=0.2, angles=(0, 180), voussoirs=15, unit_weight=1, weights="sector", live=(1, 0)
)

#: Scenes with strengths at which crushing takes up to half of the load factor.
SCENES = {
    "wall": small_wall(friction=0.65, strength=8.0),
    "column": small_wall(courses=5, length=1, friction=2.0, strength=5.0),
    "arch": mo.Scene(joints=mo.JointDefaults(friction=0.6, strength=6.0), blocks=ARCH.blocks()),
}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize(("method", "how"), BY_PARABOLA)
def test_parabola_against_fibres(name, method, how):
    """λ agrees to 2e-4 with a second formulation: stresses 0 ≤ σ ≤ f_c on 200 fibres per joint, solved by
    SciPy."""
    result = solved(SCENES[name], method, **how)
    assert result.required() == pytest.approx(by_fibres(name), rel=2e-4)
    assert result.certificate.worst < 1e-6


@pytest.mark.parametrize("name", SCENES)
def test_strength_lowers_the_load_factor_towards_none(name):
    scene = SCENES[name]
    factors = []
    for much in (1.0, 10.0, 1e2, 1e4):
        stronger = scene.replace(strength=much * scene.joints.strength)
        factors.append(solved(stronger, "static").required())
    assert (np.diff(factors) > -1e-8).all()
    assert factors[0] < 0.98 * factors[-1]
    unlimited = solved(scene.replace(strength=None), "static").required()
    assert factors[-1] == pytest.approx(unlimited, rel=5e-4)


@pytest.mark.slow
def test_a_load_history_and_the_loop_end_in_exact_states():
    scene = SCENES["column"]
    associative = solved(scene, "static", solver="highs").required()
    for method, how in (("coulomb", {"descent": False}), ("nonassociative", {})):
        result = solved(scene, method, **how)
        assert result.required() <= associative * (1 + 1e-7)
        assert result.certificate.worst < (1e-3 if method == "nonassociative" else 1e-8)


@pytest.mark.slow
def test_with_associative_flow_a_load_history_reproduces_the_chords_optimum():
    wall = small_wall(2, 2, friction=0.65, dilatancy=0.65, strength=8.0)
    chords = solved(wall, "static", solver="highs").required()
    assert solved(wall, "coulomb", descent=False).required() == pytest.approx(chords, rel=1e-8)


@pytest.mark.slow
def test_values_are_held_against_those_of_their_own_law():
    """Load factors are compared under the same law of crushing.

    The parabola's λ is higher in this scene. The Coulomb answer has chords, and its associative load factor
    does too.
    """
    scene = SCENES["arch"]
    parabola, chords = solved(scene, "static"), solved(scene, "static", solver="highs")
    assert (parabola.crushing, chords.crushing) == ("parabola", "chords")
    assert 1.002 * chords.load_factor < parabola.load_factor < 1.01 * chords.load_factor
    for result in (solved(scene), mo.solve(scene, "coulomb", start=parabola)):
        assert result.crushing == "chords"
        assert result.associative == pytest.approx(chords.load_factor, rel=1e-7)
        assert result.load_factor <= result.associative * (1 + 1e-7)
    assert mo.check(scene).table["load_factor"].to_numpy() == pytest.approx(chords.load_factor, rel=1e-7)
    assert solved(block_on_floor()).crushing == ""


def test_the_bracket_refuses_what_it_does_not_know():
    with pytest.raises(mo.OptionError, match="strength"):
        solved(block(5.0), "global")


@cache
def by_fibres(name: str, fibres: int = 200) -> float:
    """Return the largest λ of a program of a scene in which each joint consists of fibres, by SciPy.

    The constraints are B q + λ f_L + f_D = 0, |s| ≤ μ n, n = Σ σ ΔL, m = Σ σ ΔL y and 0 ≤ σ ≤ f_c. The force
    of a fibre is represented by two forces at the ends of the joint.
    """
    scene = SCENES[name]
    assembly = assemble(scene)
    problem, c = assembly.problem, assembly.problem.joints
    share = (np.arange(fibres) + 0.5) / fibres
    one = sp.eye_array(c)
    n_of, first, second = (sp.kron(one, of[None, :]) for of in (np.ones(fibres), 1 - share, share))
    B = problem.B.tocsc()
    equal = sp.hstack([B[:, :c] @ first + B[:, c : 2 * c] @ second, B[:, 2 * c :], problem.live[:, None]])
    slide = sp.diags_array(problem.friction) @ n_of
    within = sp.vstack([sp.hstack([-slide, sign * one, np.zeros((c, 1))]) for sign in (1, -1)])
    strength = scene.joints.strength * assembly.joints.extent / problem.force_unit / fibres
    bounds = [(0, most) for most in np.repeat(strength, fibres)] + [(None, None)] * (c + 1)
    cost = np.zeros(c * fibres + c + 1)
    cost[-1] = -1
    solved = linprog(cost, A_ub=within, b_ub=np.zeros(2 * c), A_eq=equal, b_eq=-problem.dead, bounds=bounds)
    return float(-solved.fun)
