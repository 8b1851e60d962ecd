"""The push: its law against the problem's faces, its load factors against known ones, its end exact."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from atlas.large_scenes import rubble
from atlas.random_scenes import random_scene
from contact_dynamics import onset
from mappings import mapped, mirrored
from scenes import (
    CASES,
    KINDS_OF_JOINTS,
    WALLS,
    block_on_floor,
    irregular,
    overhanging,
    small_wall,
    two_blocks,
)

import masonry_opt as mo
from masonry_opt.answer.answer import certified
from masonry_opt.methods.push.blocks import Blocks
from masonry_opt.methods.push.laws import FORCES, Cell, Law, compliance, takes
from masonry_opt.methods.push.path import End, Path
from masonry_opt.methods.push.push import Ended, push
from masonry_opt.methods.push.settling import settling
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import Problem

#: Load factors from rest of the walls of Table 1, and of others.
WALLS_AT_RAY = [0.641541, 0.563943, 0.355817, 0.263736, 0.214512, 0.296500]
AT_RAY = {
    "gilbert/two_blocks": 0.18844,
    "livesley/wedges": 1.28034,
    "closed_forms/pulled_stone": 1.60690,
    "examples/arch_on_piers": 0.13274,
    "goodman_bray/slope": 0.79876,
    "page/prestwood": 0.51883,
    "paterson_zwick/harmonic_3": 1 / 9,
    "bridges/arch_with_fill": 77.7566,
}

#: Scenes of every law: of those of ``KINDS_OF_JOINTS``, and others.
OF_EVERY_LAW = KINDS_OF_JOINTS | {
    "both": small_wall(3, 2, strength=6.0, dilatancy=0.2, cohesion=0.02),
    "associative": small_wall(3, 2, dilatancy=0.65),
    "smooth": small_wall(3, 2, friction=0.0, cohesion=0.1),
    "contracts": small_wall(3, 2, dilatancy=-0.3),
    "limited forces": mo.load(CASES / "bridges" / "arch_with_fill.toml"),
}


def problem_of(scene: mo.Scene | str) -> Problem:
    return assemble(mo.load(CASES / f"{scene}.toml") if isinstance(scene, str) else scene).problem


def of_law(scene: mo.Scene) -> tuple[Problem, Law]:
    """A problem with contacts that give, and its law."""
    problem = problem_of(scene)
    giving = compliance(problem)
    return replace(problem, compliance=giving), Law.of(problem, giving)


def cell_of(law: Law, trial: np.ndarray) -> Cell:
    """The cell of trial forces, (3, m), whose boundaries none of them is beyond: of all of each slider."""
    faces, slides = (of.copy() for of in law.inside)
    for slider in range(len(slides)):
        known = np.append(trial[:, slider], [0.0, 1.0])
        some = np.flatnonzero(law.normals[:, :, slider].any(axis=1)).tolist()
        half = len(some) // 2
        corners = [(face, face + 1) for face in some[:-1] if face + 1 != half]
        corners += [(0, half), (half - 1, 2 * half - 1)] if some else []
        senses = (-1, 0, 1) if np.isfinite(law.limits[:, slider]).any() else (0,)
        for at, sense in product([(), *((face,) for face in some), *corners], senses):
            faces[:, slider], slides[slider] = np.isin(np.arange(len(faces)), at), sense
            if (law.column(Cell(faces, slides), slider)[3:] @ known >= -1e-9).all():
                break
        else:
            pytest.fail(f"no cell of slider {slider}")
    return Cell(faces, slides)


def forces(law: Law, trial: np.ndarray, cell: Cell) -> np.ndarray:
    known = np.concatenate([trial, np.zeros((1, trial.shape[1])), np.ones((1, trial.shape[1]))])
    return np.einsum("rkm,km->rm", law.table(cell)[FORCES], known)


@pytest.mark.parametrize("name", OF_EVERY_LAW)
def test_forces_are_those_of_the_problems_faces(name):
    """z ≥ 0, p ≥ 0, z·p = 0 and Bᵀd + E q = D p under any motion, and ∂q/∂q~ by differences."""
    problem, law = of_law(OF_EVERY_LAW[name])
    rng = np.random.default_rng(0)
    for size in (0.3, 3.0, 30.0):
        d = size * rng.normal(size=problem.dead.size)
        q0 = law.of_problem(law.of_sliders(rng.uniform(0, 3, problem.B.shape[1])))
        problem = replace(problem, settled=q0)
        trial = law.of_sliders(q0 - problem.B.T @ d / problem.compliance)
        cell = cell_of(law, trial)
        q = law.of_problem(forces(law, trial, cell))
        p = problem.rates(d, problem.dilatancy, q)
        assert problem.slacks(q).min() > -1e-9
        assert np.abs(problem.departure(d, p, problem.dilatancy, q)).max() < 1e-9 * size
        assert problem.energy(q, p) < 1e-7 * size
        step = 1e-6 * rng.normal(size=trial.shape)
        step[:2, law.joints :] = 0.0
        moved = forces(law, trial + step, cell_of(law, trial + step)) - forces(law, trial, cell)
        by_slope = np.einsum("rkm,km->rm", law.table(cell)[FORCES, :3], step)
        assert np.abs(moved - by_slope).max() < 1e-9


@pytest.mark.parametrize("name", OF_EVERY_LAW)
def test_every_point_of_a_path_is_a_state_of_contacts_that_give(name):
    problem, law = of_law(OF_EVERY_LAW[name])
    rng = np.random.default_rng(0)
    loose = law.loosened(1e-7 * rng.uniform(0.5, 1, law.stiffness.shape))
    path = settling(problem, loose)
    assert path.follow(-1, 10_000) is End.FREE
    settled = path.by(law).forces
    problem = replace(problem, settled=law.of_problem(settled))
    assert np.abs(problem.unbalanced(0.0, problem.settled)).max() < 1e-10
    live = problem.live / problem.live_norm
    still = np.zeros(problem.dead.size)
    path = Path(loose, Blocks(problem, law, live), settled, problem.dead, live, law.inside, still)
    for most in (3, 10, 25):
        if path.follow(1, most) is not End.BUDGET:
            break
        point = path.by(law, drive=path.drive)
        q = law.of_problem(point.forces)
        answer = certified(problem, point.load_factor / problem.live_norm, q, point.d)
        assert answer.certificate.yield_ < 1e-5
        assert max(answer.certificate.equilibrium, answer.certificate.flow) < 1e-6


@pytest.mark.parametrize(("wall", "by"), list(zip(WALLS, WALLS_AT_RAY, strict=True)))
def test_walls_of_table_1_end_on_a_ray(wall, by):
    found = assert_exact(problem_of(mo.load(wall)))
    assert found.load_factor == pytest.approx(by, abs=6e-7)
    assert found.peak == pytest.approx(found.load_factor, rel=1e-6)
    assert found.deep_fall is None


@pytest.mark.parametrize("case", AT_RAY)
def test_cases_end_on_a_ray(case):
    assert assert_exact(problem_of(case)).load_factor == pytest.approx(AT_RAY[case], rel=3e-5)


def assert_exact(problem: Problem):
    """A push that ends on a ray, whose state is exact."""
    found = push(problem)
    assert found.ended is Ended.RAY
    answer = certified(problem, found.load_factor, found.q, found.d)
    assert answer.exact
    assert answer.certificate.worst < 1e-9
    assert problem.live @ found.d == pytest.approx(problem.live_norm, rel=1e-12)
    return found


@pytest.mark.parametrize("kind", ["wall", "arch", "tessellation"])
def test_the_load_factor_is_that_of_the_scene_mirrored_turned_round_and_stretched(kind):
    scene = random_scene(kind, 300002)
    as_it_is = push(problem_of(scene)).load_factor
    order = np.random.default_rng(1).permutation(len(scene.blocks))
    for other in (
        mapped(scene, mirrored, mirrored),
        mapped(scene, order=order),
        mapped(scene, lambda v: (3 * v[0], 3 * v[1]), length=3.0, dead=7.0, live=7.0),
    ):
        assert push(problem_of(other)).load_factor == pytest.approx(as_it_is, rel=1e-9)


def test_the_looseness_of_limits_leaves_nothing_behind():
    problem = problem_of("ferris_tinloi/wall_3")
    one, other = (push(problem, seed=seed) for seed in (1, 2))
    assert one.load_factor == pytest.approx(other.load_factor, rel=1e-12)
    np.testing.assert_allclose(one.q, other.q, atol=1e-9)


@pytest.mark.parametrize("strength", [2.0, 10.0])
def test_a_solid_block_crushes_at_its_toe(strength):
    """λ = (b - W/f_c)/h, less what chords miss."""
    scene = block_on_floor(width=1.0, height=2.0, friction=2.0)
    scene = scene.model_copy(update={"joints": mo.JointDefaults(friction=2.0, strength=strength)})
    found = assert_exact(problem_of(scene))
    assert found.load_factor == pytest.approx((1 - 1 / strength) / 2, rel=7e-3)


def test_a_block_slides_at_its_friction_and_tips_about_its_toe():
    assert push(problem_of(block_on_floor(friction=0.3))).load_factor == pytest.approx(0.3, rel=1e-12)
    assert push(problem_of(block_on_floor(friction=0.6))).load_factor == pytest.approx(0.5, rel=1e-12)


def test_how_a_push_ends():
    falls = push(problem_of(overhanging()))
    assert (falls.ended, falls.load_factor) == (Ended.NOT_SETTLED, None)
    jams = push(problem_of(block_on_floor(live=(0.0, -1.0))))
    assert (jams.ended, jams.load_factor) == (Ended.JAM, None)
    assert push(problem_of("ferris_tinloi/wall_1"), events=20).ended is Ended.BUDGET


def test_an_end_with_the_load_drawn_back_is_told():
    """Its path turns at u > 0 and goes to u < 0: where the highest load falls."""
    found = push(problem_of(random_scene("tessellation", 300004)))
    assert found.ended is Ended.BACK
    assert found.folds > 0
    assert found.peak > found.load_factor


@pytest.mark.slow
def test_a_load_that_grows_passes_the_falls_of_the_path_up_to_its_highest():
    """In contact dynamics, whatever the ray is, here of a ninth less, of far less, and below zero."""
    scenes = [random_scene("tessellation", seed) for seed in (910017, 910061, 910064)]
    problems = [problem_of(scene) for scene in (*scenes, rubble(40, 910006))]
    found = [push(problem) for problem in problems]
    assert [of.deep_fall is not None for of in found] == [True, False, False, True]
    assert [of.load_factor < 0.9 * of.peak for of in found] == [True, True, True, False]
    highest = [of.peak for of in found]
    brought_down = onset(problems, [of.settled for of in found], highest)
    assert highest == pytest.approx(brought_down, rel=0.01)


def test_events_tell_what_joints_do():
    found = push(problem_of(two_blocks()))
    assert [event.what for event in found.events] == ["slides", "slides"]
    assert found.events[-1].load_factor / problem_of(two_blocks()).live_norm == pytest.approx(
        found.load_factor, rel=1e-6
    )


def test_what_the_push_does_not_take():
    assert takes(problem_of(irregular()))
    assert not takes(problem_of("space/corner_wall"))
    assert not takes(problem_of(small_wall(friction=1e5)))
    assert not takes(problem_of(small_wall(dilatancy=0.2, dilatancy_stress=(0.1, 1.0))))
