"""Compute collapse load factors of masonry: rigid blocks with dry Coulomb joints, by linear programming.

>>> import masonry_opt as mo
>>> scene = mo.load("cases/ferris_tinloi/wall_1.toml")
>>> result = mo.solve(scene)
>>> print(result)

Six functions that most users need
    load, draw, solve, sweep, report, save
Studies of many loads, positions of axles, supports or values of parameters
    solve_cases, directions, crossing, settle, capacity, sample, least, most
Files of other programs
    read_dxf, write_dxf, read_mesh, read_compas, export
Scenes and their records
    Scene, Block, JointDefaults, Joint, Load, EdgeLoad, LoadCase, Earthquake, Tie, Prop, Fill, Backing, Axles,
    UniformLoad, Reference; in space Solid, Part, box, extrude
Generators of many blocks
    Wall, Facade, Arch, PointLoad, Column; in space Plan, PlanWall, Opening, Barrel, Dome, Groin, Shaft
Research
    certify, prove_least, check_proof, check, compare, assemble
Settings of methods
    IncrementalSettings, SearchSettings, ProofBudget
Results
    Result, Status, Certificate, StateCheck, LeastLoadFactor, DualityReport, Sample, Crossing, Capacity,
    KinematicCheck, Settlement
Errors
    MasonryError, CaseError, OptionError

Each function has its own help, such as ``help(mo.solve)``. The method is described by Gilbert, Casapulla &
Ahmed (2006), Computers and Structures 84, 873-887.
"""

import ast as _ast
from importlib import import_module as _import_module
from pathlib import Path as _Path

#: Map from each public name to its module, read from the stub file (.pyi). A module is imported when a name
#: is first used, because importing all modules takes seconds.
_HOMES = {
    alias.name: node.module
    for node in _ast.parse(_Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")).body
    if isinstance(node, _ast.ImportFrom)
    for alias in node.names
}

__all__ = sorted(_HOMES)

# In a clone of the repository, the folder models/ is next to the package, not inside it. Add the root of the
# clone to the package's search path, so that models/ is found.
_CLONE = _Path(__file__).parent.parent
if not (_Path(__file__).parent / "models").is_dir() and (_CLONE / "models" / "__init__.py").is_file():
    __path__.append(str(_CLONE))


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version  # its import takes 0.03 s

        return version("masonry_opt")
    if name not in _HOMES:
        raise AttributeError(f"module 'masonry_opt' has no attribute '{name}'")
    value = getattr(_import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
