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
#: Folders of small cases; fast tests check the duality of each case.
CHECKED = ("closed_forms", "gilbert", "livesley", "meriam_kraige", "oppenheim")
WALLS = [CASES / "ferris_tinloi" / f"wall_{number}.toml" for number in range(1, 7)]
#: The six walls as test parameters; walls 2 to 6 are slow.
TABLE_1 = [
    pytest.param(path, id=path.stem, marks=pytest.mark.slow if number else ())
    for number, path in enumerate(WALLS)
]


def block_between_walls(friction: float) -> mo.Scene:
    """Return a block of weight 4 that hangs between two walls, without a force that presses them onto it."""
    return mo.Scene(
        blocks=[
            mo.Block(name="left", vertices=rectangle(-1, 0, -1, 3), fixed=True),
            mo.Block(name="right", vertices=rectangle(2, 3, -1, 3), fixed=True),
            mo.Block(name="hanging", vertices=rectangle(0, 2, 0, 2), weight=4),
        ],
        joints={"friction": friction},
    )


def block_on_floor(
    width: float = 1.0, height: float = 2.0, friction: float = 0.6, **block: object
) -> mo.Scene:
    """Return a block of weight 1 on a fixed floor, pushed to the right at its centroid by its weight."""
    properties = {"weight": 1.0, "live": (1.0, 0.0)} | block
    A = mo.Block(name="A", vertices=rectangle(0, width, 0, height), **properties)
    return on_floor(A, friction=friction)


def on_floor(*blocks: mo.Block, friction: float = 0.6, **keys: Any) -> mo.Scene:
    """Return a scene of the given blocks on a fixed floor."""
    floor = mo.Block(name="floor", vertices=rectangle(-5, 6, -1, 0), fixed=True)
    return mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=[*blocks, floor], **keys)


def axles_on_a_beam(friction):
    """Return a block across two supports, with one axle on the road along its top."""
    blocks = [
        mo.Block(name="beam", vertices=[(-1, 0), (1, 0), (1, 1), (-1, 1)], weight=1.0),
        mo.Block(name="west", vertices=[(-1, -1), (-0.5, -1), (-0.5, 0), (-1, 0)], fixed=True),
        mo.Block(name="east", vertices=[(0.25, -1), (0.5, -1), (0.5, 0), (0.25, 0)], fixed=True),
    ]
    axles = [mo.Axles(name="cart", loads=[1.0], road=[(-1, 1), (1, 1)])]
    return mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=blocks, axles=axles)


def two_blocks(friction: float = 0.1) -> mo.Scene:
    """Return Fig. 6 of the paper: B rests on a rough support and on A, which is pushed out."""
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
    """Return a running-bond wall of 4 × 1.75 blocks; the live load is the weight, horizontally."""
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
    """Return a driver of eq. (9) or eq. (10) of a problem, with a new count of its effort."""
    driver = Driver(problem, formulation, find_solver(language, solver), Effort(), of_load)
    if limits is not None:
        driver.set_shear_limits(limits)
    return driver


def forces_of(assembly: Assembly, which: str = "dead") -> np.ndarray:
    """Return the load on each movable block, as force and moment about its centroid, shape (b, 3).

    Values are in the units of the scene.
    """
    problem = assembly.problem
    unit = problem.force_unit * np.array([1, 1, problem.length_unit])
    return getattr(problem, which).reshape(-1, 3) * unit


_loaded = cache(mo.load)
_SOLVED: dict[tuple[object, ...], Result] = {}


def solved(scene: mo.Scene | Path, method: str = "coulomb", **options: Any) -> Result:
    """Call ``mo.solve`` once for each scene, method and options, and return the stored result afterwards.

    The incremental load factor is not computed unless ``incremental=True``. Tests that patch the package call
    ``mo.solve`` instead, because the stored results do not depend on patches.
    """
    scene = _loaded(scene) if isinstance(scene, Path) else scene
    key = (repr((scene.model_dump(), scene.load_case)), method, *sorted(options.items()))
    if key not in _SOLVED:
        _SOLVED[key] = mo.solve(scene, method, **({"incremental": False} | options))
    return _SOLVED[key]


def values_of(answer: Result | Solution, code: Code) -> dict[str, Any] | None:
    """Return the values of the reason with the given code; None if the answer has no such reason."""
    return next((reason.values for reason in answer.reasons if reason.code is code), None)


def irregular() -> mo.Scene:
    """Return two stones whose edges all differ, on a sloping support."""
    return mo.Scene(
        joints=mo.JointDefaults(friction=0.7),
        blocks=[
            mo.Block(name="A", vertices=[(0, 0), (3, 1), (2.5, 2.5), (0.2, 2)], weight=3, live=(1, 0.5)),
            mo.Block(name="B", vertices=[(0.2, 2), (2.5, 2.5), (1, 4)], weight=2),
            mo.Block(name="ground", vertices=[(-3, -1), (6, 2), (6, -3)], fixed=True),
        ],
    )


def overhanging(beyond: float = 1.0) -> mo.Scene:
    """Return a block that falls under its weight: its centroid is ``beyond`` past the edge of its base."""
    edge = 1.5 - beyond
    return mo.Scene(
        joints=mo.JointDefaults(friction=0.6),
        blocks=[
            mo.Block(name="A", vertices=[(0, 0), (3, 0), (3, 1), (0, 1)], weight=1, live=(1, 0)),
            mo.Block(name="base", vertices=[(-3, -1), (edge, -1), (edge, 0), (-3, 0)], fixed=True),
        ],
    )


def pressed_down() -> mo.Scene:
    """Return a block on the ground with a live load straight down, which does no work in any motion."""
    return block_on_floor(live=(0.0, -1.0))


def on_a_corner() -> mo.Scene:
    """Return a wedge with its corner on the ground, a block next to it, and a beam that rests on both."""
    return mo.Scene(
        joints=mo.JointDefaults(friction=0.6),
        blocks=[
            mo.Block(name="wedge", vertices=[(1, 0), (2, 2), (0, 2)], weight=1, live=(1, 0)),
            mo.Block(name="block", vertices=[(3, 0), (5, 0), (5, 2), (3, 2)], weight=3, live=(3, 0)),
            mo.Block(name="beam", vertices=[(0, 2), (5, 2), (5, 3), (0, 3)], weight=4, live=(4, 0)),
            mo.Block(name="ground", vertices=[(-2, -1), (8, -1), (8, 0), (-2, 0)], fixed=True),
        ],
    )


#: Scenes with joints of different kinds: joints that cannot slide, with cohesion, with dilatancy, with
#: limited strength, and without length.
KINDS_OF_JOINTS = {
    "one joint cannot slide": two_blocks(),
    "nothing slides": small_wall(3, 2, friction=float("inf")),
    "cohesion": small_wall(3, 2, cohesion=0.05),
    "no cohesion": small_wall(3, 2),
    "dilatancy": small_wall(3, 2, dilatancy=0.1),
    "strength": small_wall(3, 2, strength=8.0),
    "corner on an edge": on_a_corner(),
}

#: Scenes whose joints have no strength, because the bracket refuses joints that have one.
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
    """Set ``sys.argv`` as if the command had been typed."""
    monkeypatch.setattr("sys.argv", ["masonry-opt", *map(str, arguments)])


def run_command(monkeypatch: Any, capsys: Any, *arguments: object) -> tuple[int, str, str]:
    """Run the command line, and return its exit code, standard output and standard error."""
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
    """Runs the command line and checks its exit code."""

    monkeypatch: Any
    capsys: Any

    def __call__(self, *arguments: object, code: int | None = 0) -> str:
        """Return standard output; if ``code`` is None, any exit code is accepted."""
        ended, out, error = run_command(self.monkeypatch, self.capsys, *arguments)
        assert code in (ended, None), error
        return out

    def json(self, *arguments: object, code: int = 0) -> dict[str, Any]:
        """Return the JSON object on standard output."""
        return json.loads(self(*arguments, "--json", code=code))

    def warned(self, *arguments: object, code: int = 0) -> list[str]:
        """Return the warnings on standard error, and assert that standard output has none."""
        ended, out, error = run_command(self.monkeypatch, self.capsys, *arguments)
        assert ended == code, error
        assert "warning: " not in out
        lines = error.splitlines()
        return [line.removeprefix("warning: ") for line in lines if line.startswith("warning: ")]

    def refused(self, *arguments: object, code: int = 2) -> str:
        """Return standard error, and assert that standard output is empty."""
        ended, out, error = run_command(self.monkeypatch, self.capsys, *arguments)
        assert (ended, out) == (code, "")
        return error
