"""If equilibrium alone determines all forces, one load factor above zero is proven to be the only one."""

import math

import pytest
from atlas.random_scenes import random_scene
from claims import other_state
from scenes import CASES, block_on_floor, on_floor, rectangle
from speeds import slow_after

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.reporting.load_factors import LEAST, own_name
from masonry_opt.solution.only_state import is_only_load_factor

#: Load factors by hand, which the comments of the case files derive.
DETERMINATE = {"buttress": 4 / 3, "dam_overturns": 2.028, "dam_slides": 1.17}


@pytest.mark.parametrize("name", DETERMINATE)
def test_the_default_prints_least_proven(name: str) -> None:
    result = mo.solve(CASES / f"closed_forms/{name}.toml")
    assert result.load_factor == pytest.approx(DETERMINATE[name], rel=1e-3)
    assert result.solution.is_only_state
    assert own_name(result) == LEAST
    assert "equilibrium alone fixes all forces, so no other λ above zero is possible" in result.summary


def test_the_loop_prints_least_proven() -> None:
    result = mo.solve(CASES / "closed_forms/buttress.toml", "nonassociative", incremental=False)
    assert result.load_factor == pytest.approx(4 / 3, rel=1e-6)
    assert result.solution.is_only_state
    assert own_name(result) == LEAST


def test_indeterminate_forces_prove_nothing(no_proof: None) -> None:
    result = mo.solve(CASES / "gilbert/two_blocks.toml")
    assert not result.solution.is_only_state
    assert own_name(result) != LEAST


def test_a_load_factor_of_no_collapse_is_not_proven() -> None:
    """The block slides at λ = 0.3. No condition is at yield at 0.2, and one condition is violated at 0.4."""
    problem = assemble(block_on_floor(friction=0.3)).problem
    assert [is_only_load_factor(problem, λ) for λ in (0.2, 0.3, 0.4)] == [False, True, False]


def test_a_block_that_slides_under_any_load_refutes_the_claim() -> None:
    """A tower overturns at λ = 0.5, and a wedge on a slope of tan α = μ slides under any multiple of its
    weight.

    Every load factor from 0 on is therefore one of collapse, although equilibrium determines all forces.
    """
    slope = 0.25
    tower = mo.Block(name="tower", vertices=rectangle(0, 1, 0, 2), weight=1, live=(1, 0))
    wedge = mo.Block(name="wedge", vertices=[(7, 0), (8, slope), (7, 2)], weight=1, live=(0, -1))
    ramp = mo.Block(name="ramp", vertices=[(6.9, -0.025), (6.9, -1), (9, -1), (9, 0.5)], fixed=True)
    alone = on_floor(tower, friction=slope * 4)
    both = alone.replace(
        blocks=[*alone.blocks, wedge, ramp],
        exceptions=[mo.Joint(between=("wedge", "ramp"), friction=slope)],
    )
    assert is_only_load_factor(assemble(alone).problem, 0.5)
    problem = assemble(both).problem
    assert problem.statics_fix_forces
    assert other_state(assemble(both)) == pytest.approx(0, abs=1e-6)
    assert not is_only_load_factor(problem, 0.5)


def test_a_tie_at_its_strength_under_any_load_refutes_the_claim() -> None:
    """A weight of 1 hangs from a tie of strength 2 or 1, next to a block that slides at λ = 0.3. With a
    strength of 1, the tie yields at every λ, so 0.3 is not the only load factor."""
    sliding = mo.Block(name="A", vertices=rectangle(0, 1, 0, 2), weight=1, live=(1, 0))
    hanging = mo.Block(name="hung", vertices=rectangle(7, 8, 0, 1), weight=1)
    beam = mo.Block(name="beam", vertices=rectangle(7, 8, 3, 4), fixed=True)
    scene = on_floor(sliding, friction=0.3)
    tie = {"between": ("hung", "beam"), "at": ((7.5, 0.9), (7.5, 3.1))}
    for strength, proven in ((2.0, True), (1.0, False)):
        ties = [mo.Tie(**tie, strength=strength)]
        problem = assemble(scene.replace(blocks=[*scene.blocks, hanging, beam], ties=ties)).problem
        assert is_only_load_factor(problem, 0.3) is (proven and problem.statics_fix_forces)
        assert problem.statics_fix_forces


@pytest.mark.parametrize("seed", slow_after(2, range(7_320_000, 7_320_006)))
def test_a_second_program_finds_no_lower_state(seed: int) -> None:
    """For stacks of two to eight stones, a mixed-integer program looks for states below the proven load
    factor."""
    scene = random_scene("stack", seed)
    result = mo.solve(scene, incremental=False)
    if not result.solution.is_only_state:
        assert not (result.exact and assemble(scene).problem.statics_fix_forces)
        return
    assert result.assembly.problem.load_factor_scale.equal(result.load_factor, result.associative)
    lower = other_state(assemble(scene), result.load_factor * (1 - 1e-4))
    assert lower is None or math.isclose(lower, result.load_factor, rel_tol=1e-4)
