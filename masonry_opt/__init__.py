"""Collapse load factor of masonry: rigid blocks, dry Coulomb joints, linear programming.

>>> import masonry_opt as mo
>>> result = mo.solve("cases/ferris_tinloi/wall_1.toml")

after Gilbert, Casapulla & Ahmed (2006), Computers and Structures 84, 873-887.
"""

from importlib import import_module as _import_module
from pathlib import Path as _Path

#: Where each name is; type checkers read it in __init__.pyi. Names are imported when first wanted: the
#: modelling languages take seconds, in which the command must be able to end on Ctrl-C, and analyses need no
#: study.
_HOMES = {
    "analysis": ("solve",),
    "answer.answer": ("Certificate",),
    "result": ("Result",),
    "answer.reasons": ("Status",),
    "duality": ("DualityReport", "check"),
    "errors": ("CaseError", "MasonryError", "OptionError"),
    "drawing.pictures": ("draw",),
    "exports.export": ("export",),
    "finite_motion.capacity": ("Capacity", "capacity"),
    "finite_motion.kinematic_check": ("KinematicCheck",),
    "problem.assembly": ("assemble",),
    "scene.arch": ("Arch", "PointLoad"),
    "scene.blocks": ("Block", "Reference"),
    "scene.case_file": ("load", "save"),
    "scene.drawings.compas": ("read_compas",),
    "scene.drawings.mesh_files": ("read_mesh",),
    "scene.drawings.dxf": ("read_dxf", "write_dxf"),
    "scene.extrude": ("extrude",),
    "scene.joints": ("Joint", "JointDefaults"),
    "scene.loads": ("Earthquake", "EdgeLoad", "Load", "LoadCase", "Prop", "Tie"),
    "scene.road": ("Axles", "Backing", "Fill"),
    "scene.scene": ("Scene",),
    "scene.solid_generators.plan": ("Plan",),
    "scene.solid_generators.round": ("Dome", "Shaft"),
    "scene.solid_generators.stretches": ("Opening", "PlanWall"),
    "scene.solid_generators.vaults": ("Barrel", "Groin"),
    "scene.solids": ("Part", "Solid", "box"),
    "scene.walls": ("Column", "Facade", "Wall"),
    "studies.compare.comparison": ("compare",),
    "studies.crossing.crossing": ("Crossing", "crossing"),
    "studies.load_cases.cases": ("directions", "solve_cases"),
    "studies.many.least": ("least", "most"),
    "studies.many.sample": ("Sample", "sample"),
    "studies.many.sweep": ("sweep",),
    "studies.report.report": ("report",),
    "studies.settle.settle": ("Settlement", "settle"),
}

__all__ = sorted(name for names in _HOMES.values() for name in names)

# The folder models/ lies beside this one in a clone, and inside it once installed. Python started in a clone
# takes this folder for the package, whatever is installed: it must find the models there too.
_CLONE = _Path(__file__).parent.parent
if not (_Path(__file__).parent / "models").is_dir() and (_CLONE / "models" / "__init__.py").is_file():
    __path__.append(str(_CLONE))


def __getattr__(name: str) -> object:
    for home, names in _HOMES.items():
        if name in names:
            value = getattr(_import_module(f"masonry_opt.{home}"), name)
            globals()[name] = value
            return value
    raise AttributeError(f"module 'masonry_opt' has no attribute '{name}'")


def __dir__() -> list[str]:
    return __all__
