"""Collapse load factor of masonry: rigid blocks, dry Coulomb joints, linear programming.

>>> import masonry_opt as mo
>>> result = mo.solve("cases/ferris_tinloi/wall_1.toml")

after Gilbert, Casapulla & Ahmed (2006), Computers and Structures 84, 873-887.
"""

from importlib import import_module as _import_module
from pathlib import Path as _Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from masonry_opt.analysis import solve
    from masonry_opt.answer.certificate import Certificate
    from masonry_opt.answer.result import Result
    from masonry_opt.answer.status import Status
    from masonry_opt.duality import DualityReport, check
    from masonry_opt.errors import CaseError, MasonryError, OptionError
    from masonry_opt.explain.stressed_joints import stressed_joints
    from masonry_opt.scene import (
        Arch,
        Block,
        Facade,
        Joint,
        JointDefaults,
        PointLoad,
        Reference,
        Scene,
        Wall,
        load,
        save,
    )
    from masonry_opt.studies.compare.api import compare

__all__ = [
    "Arch",
    "Block",
    "CaseError",
    "Certificate",
    "DualityReport",
    "Facade",
    "Joint",
    "JointDefaults",
    "MasonryError",
    "OptionError",
    "PointLoad",
    "Reference",
    "Result",
    "Scene",
    "Status",
    "Wall",
    "check",
    "compare",
    "load",
    "save",
    "solve",
    "stressed_joints",
]

#: Where the names are that are not of the scene. They are imported when first asked for: the modelling
#: languages take seconds, in which the command must be able to end on Ctrl-C.
_HOMES = {
    "CaseError": "errors",
    "Certificate": "answer.certificate",
    "DualityReport": "duality",
    "MasonryError": "errors",
    "OptionError": "errors",
    "Result": "answer.result",
    "Status": "answer.status",
    "check": "duality",
    "compare": "studies.compare.api",
    "solve": "analysis",
    "stressed_joints": "explain.stressed_joints",
}

# The folder models/ lies beside this one in a clone, and inside it once installed. Python started in a clone
# takes this folder for the package, whatever is installed: it must find the models there too.
_CLONE = _Path(__file__).parent.parent
if not (_Path(__file__).parent / "models").is_dir() and (_CLONE / "models" / "__init__.py").is_file():
    __path__.append(str(_CLONE))


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(f"module 'masonry_opt' has no attribute '{name}'")
    value = getattr(_import_module(f"masonry_opt.{_HOMES.get(name, 'scene')}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return list(__all__)
