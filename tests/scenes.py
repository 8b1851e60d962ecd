"""Scenes, paths and solves that several tests share."""

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import masonry_opt as mo
from masonry_opt.cli import main
from masonry_opt.effort import Effort
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.result import Result
from masonry_opt.scene.blocks import rectangle
from masonry_opt.solution.reasons import Code
from masonry_opt.solution.solution import Solution
from masonry_opt.solvers.driver import Driver
from masonry_opt.solvers.registry import find_solver

CASES = Path(__file__).parent.parent / "cases"
ALL_CASES = sorted(CASES.glob("*/*.toml"))
#: Folders of small cases of every kind, each of which is checked for duality in fast tests.
CHECKED = ("closed_forms", "gilbert", "livesley", "meriam_kraige", "oppenheim")
WALLS = [CASES / "ferris_tinloi" / f"wall_{number}.toml" for number in range(1, 7)]
#: The same as parameters of tests: the first is fast, others take seconds.
TABLE_1 = [
    pytest.param(path, id=path.stem, marks=pytest.mark.slow if number else ())
    for number, path in enumerate(WALLS)
]


def block_on_floor(
    width: float = 1.0, height: float = 2.0, friction: float = 0.6, **block: object
) -> mo.Scene:
    """One block of weight 1 on a fixed floor, live load = weight to the right at its centroid."""
    properties = {"weight": 1.0, "live": (1.0, 0.0)} | block
    A = mo.Block(name="A", vertices=rectangle(0, width, 0, height), **properties)
    return on_floor(A, friction=friction)


def on_floor(*blocks: mo.Block, friction: float = 0.6, **keys: Any) -> mo.Scene:
    """Blocks on a fixed floor."""
    floor = mo.Block(name="floor", vertices=rectangle(-5, 6, -1, 0), fixed=True)
    return mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=[*blocks, floor], **keys)


def axles_on_a_beam(friction):
    """A block across two supports, with one axle on the road along its top."""
    blocks = [
        mo.Block(name="beam", vertices=[(-1, 0), (1, 0), (1, 1), (-1, 1)], weight=1.0),
        mo.Block(name="west", vertices=[(-1, -1), (-0.5, -1), (-0.5, 0), (-1, 0)], fixed=True),
        mo.Block(name="east", vertices=[(0.25, -1), (0.5, -1), (0.5, 0), (0.25, 0)], fixed=True),
    ]
    axles = [mo.Axles(name="cart", loads=[1.0], road=[(-1, 1), (1, 1)])]
    return mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=blocks, axles=axles)


def two_blocks(friction: float = 0.1) -> mo.Scene:
    """Fig. 6 of the paper: B rests on a rough support and on A, which is pushed out."""
    rough = float("inf")
    return mo.Scene(
        joints=mo.JointDefaults(friction=friction),
        blocks=[
            mo.Block(name="A", vertices=[(2, 0), (5, 0), (5, 1), (2, 1)], weight=1, live=(1, 0)),
            mo.Block(name="B", vertices=[(0, 1), (3, 1), (3, 2), (0, 2)], weight=1),
            mo.Block(name="floor", vertices=[(1, -1), (9, -1), (9, 0), (1, 0)], fixed=True),
            mo.Block(name="support", vertices=[(0, 0), (1, 0), (1, 1), (0, 1)], fixed=True),
        ],
        exceptions=[mo.Joint(between=("B", "support"), friction=rough)],
    )


def small_wall(courses: int = 4, length: int = 3, friction: float = 0.65, **joints: float) -> mo.Scene:
    """A running-bond wall of 4 × 1.75 blocks, live load = weight, horizontal."""
    half = [0.5, *[1.0] * (length - 1), 0.5]
    full = [1.0] * length
    wall = mo.Wall(
        block=(4, 1.75),
        weight=1,
        live=(1, 0),
        courses=[half if row % 2 == 0 else full for row in range(courses)],
    )
    return mo.Scene(joints=mo.JointDefaults(friction=friction, **joints), blocks=wall.blocks())


def declared(
    problem: Problem,
    formulation: str = "static",
    language: str = "cvxpy",
    solver: str | None = None,
    limits: ShearLimits | None = None,
    of_load: bool = False,
) -> Driver:
    """Eq. (9) or eq. (10) of a problem, with an effort of its own."""
    driver = Driver(problem, formulation, find_solver(language, solver), Effort(), of_load)
    if limits is not None:
        driver.set_shear_limits(limits)
    return driver


def forces_of(assembly: Assembly, which: str = "dead") -> np.ndarray:
    """Force and moment about the centroid of each movable block, in the scene's units, shape (b, 3)."""
    problem = assembly.problem
    unit = problem.force_unit * np.array([1, 1, problem.length_unit])
    return getattr(problem, which).reshape(-1, 3) * unit


_loaded = cache(mo.load)
_SOLVED: dict[tuple[object, ...], Result] = {}


def solved(scene: mo.Scene | Path, method: str = "coulomb", **options: Any) -> Result:
    """``mo.solve``, once for each scene, method and options: results do not change.

    The incremental load factor is left out unless asked for.
    """
    scene = _loaded(scene) if isinstance(scene, Path) else scene
    key = (repr((scene.model_dump(), scene.load_case)), method, *sorted(options.items()))
    if key not in _SOLVED:
        _SOLVED[key] = mo.solve(scene, method, **({"incremental": False} | options))
    return _SOLVED[key]


def values_of(answer: Result | Solution, code: Code) -> dict[str, Any] | None:
    """The values of the reason with that code; None if it is not among those given."""
    return next((reason.values for reason in answer.reasons if reason.code is code), None)


def irregular() -> mo.Scene:
    """Three stones with no two edges alike, on a sloping support."""
    return mo.Scene(
        joints=mo.JointDefaults(friction=0.7),
        blocks=[
            mo.Block(name="A", vertices=[(0, 0), (3, 1), (2.5, 2.5), (0.2, 2)], weight=3, live=(1, 0.5)),
            mo.Block(name="B", vertices=[(0.2, 2), (2.5, 2.5), (1, 4)], weight=2),
            mo.Block(name="ground", vertices=[(-3, -1), (6, 2), (6, -3)], fixed=True),
        ],
    )


def overhanging(beyond: float = 1.0) -> mo.Scene:
    """A block whose centroid lies so far beyond the edge that bears it: it falls under its own weight."""
    edge = 1.5 - beyond
    return mo.Scene(
        joints=mo.JointDefaults(friction=0.6),
        blocks=[
            mo.Block(name="A", vertices=[(0, 0), (3, 0), (3, 1), (0, 1)], weight=1, live=(1, 0)),
            mo.Block(name="base", vertices=[(-3, -1), (edge, -1), (edge, 0), (-3, 0)], fixed=True),
        ],
    )


def pressed_down() -> mo.Scene:
    """A block on the ground with a live load straight down, which no motion lets do work."""
    return block_on_floor(live=(0.0, -1.0))


def on_a_corner() -> mo.Scene:
    """A wedge with its corner on the ground and a block beside it, under a beam that both bear."""
    return mo.Scene(
        joints=mo.JointDefaults(friction=0.6),
        blocks=[
            mo.Block(name="wedge", vertices=[(1, 0), (2, 2), (0, 2)], weight=1, live=(1, 0)),
            mo.Block(name="block", vertices=[(3, 0), (5, 0), (5, 2), (3, 2)], weight=3, live=(3, 0)),
            mo.Block(name="beam", vertices=[(0, 2), (5, 2), (5, 3), (0, 3)], weight=4, live=(4, 0)),
            mo.Block(name="ground", vertices=[(-2, -1), (8, -1), (8, 0), (-2, 0)], fixed=True),
        ],
    )


#: Scenes whose joints differ in kind: some cannot slide, none can, all have cohesion, all dilate, all can be
#: crushed, one has no length.
KINDS_OF_JOINTS = {
    "one joint cannot slide": two_blocks(),
    "nothing slides": small_wall(3, 2, friction=float("inf")),
    "cohesion": small_wall(3, 2, cohesion=0.05),
    "no cohesion": small_wall(3, 2),
    "dilatancy": small_wall(3, 2, dilatancy=0.1),
    "strength": small_wall(3, 2, strength=8.0),
    "corner on an edge": on_a_corner(),
}

#: Those whose joints bear any pressure, which the bracket asks for.
UNCRUSHED = {name: scene for name, scene in KINDS_OF_JOINTS.items() if scene.joints.strength is None}


#: A case file of a block that slides or hinges on its base.
GOOD = """
[joints]
friction = 0.6
[[block]]
name = "A"
vertices = [[0, 0], [1, 0], [1, 1], [0, 1]]
weight = 1.0
live = [1.0, 0.0]
[[block]]
name = "base"
vertices = [[-4, -1], [9, -1], [9, 0], [-4, 0]]
fixed = true
"""


def type_command(monkeypatch: Any, *arguments: object) -> None:
    """As if the command had been typed."""
    monkeypatch.setattr("sys.argv", ["masonry-opt", *map(str, arguments)])


def run_command(monkeypatch: Any, capsys: Any, *arguments: object) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of the command line."""
    type_command(monkeypatch, *arguments)
    code: Any = 0
    try:
        main()
    except SystemExit as end:
        code = end.code or 0
    captured = capsys.readouterr()
    return code, captured.out, captured.err


@dataclass(frozen=True)
class Command:
    """The command line, held to its exit code."""

    monkeypatch: Any
    capsys: Any

    def __call__(self, *arguments: object, code: int | None = 0) -> str:
        """Return standard output; any exit code will do if ``code`` is None."""
        ended, out, error = run_command(self.monkeypatch, self.capsys, *arguments)
        assert code in (ended, None), error
        return out

    def json(self, *arguments: object, code: int = 0) -> dict[str, Any]:
        """The one object on standard output."""
        return json.loads(self(*arguments, "--json", code=code))

    def warned(self, *arguments: object, code: int = 0) -> list[str]:
        """Return the warnings on standard error, where standard output has none."""
        ended, out, error = run_command(self.monkeypatch, self.capsys, *arguments)
        assert ended == code, error
        assert "warning: " not in out
        lines = error.splitlines()
        return [line.removeprefix("warning: ") for line in lines if line.startswith("warning: ")]

    def refused(self, *arguments: object, code: int = 2) -> str:
        """Standard error, where nothing is printed."""
        ended, out, error = run_command(self.monkeypatch, self.capsys, *arguments)
        assert (ended, out) == (code, "")
        return error
