"""Collapse load factor of masonry: rigid blocks, dry Coulomb joints, linear programming.

>>> import masonry_opt as mo
>>> scene = mo.load("cases/ferris_tinloi/wall_1.toml")
>>> result = mo.solve(scene)
>>> print(result)

Six functions that most users need
    load, draw, solve, sweep, report, save
Studies of many loads, positions, supports or values
    solve_cases, directions, crossing, settle, capacity, sample, least, most
Files of other programs
    read_dxf, write_dxf, read_mesh, read_compas, export
Scenes and their records
    Scene, Block, JointDefaults, Joint, Load, EdgeLoad, LoadCase, Earthquake, Tie, Prop, Fill, Backing, Axles,
    Reference; in space Solid, Part, box, extrude
Generators of many blocks
    Wall, Facade, Arch, PointLoad, Column; in space Plan, PlanWall, Opening, Barrel, Dome, Groin, Shaft
Research
    check, compare, assemble
Results
    Result, Status, Certificate, DualityReport, Sample, Crossing, Capacity, KinematicCheck, Settlement
Errors
    MasonryError, CaseError, OptionError

Each function has its own help, such as ``help(mo.solve)``. The method is described by Gilbert, Casapulla &
Ahmed (2006), Computers and Structures 84, 873-887.
"""

import ast as _ast
from importlib import import_module as _import_module
from pathlib import Path as _Path

#: Where each name is, as type checkers read it too. Names are imported when first wanted: the modelling
#: languages take seconds, in which the command must be able to end on Ctrl-C, and analyses need no study.
_HOMES = {
    alias.name: node.module
    for node in _ast.parse(_Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")).body
    if isinstance(node, _ast.ImportFrom)
    for alias in node.names
}

__all__ = sorted(_HOMES)

# The folder models/ lies beside this one in a clone, and inside it once installed. Python started in a clone
# takes this folder for the package, whatever is installed: it must find the models there too.
_CLONE = _Path(__file__).parent.parent
if not (_Path(__file__).parent / "models").is_dir() and (_CLONE / "models" / "__init__.py").is_file():
    __path__.append(str(_CLONE))


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'masonry_opt' has no attribute '{name}'")
    value = getattr(_import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
