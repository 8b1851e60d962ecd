"""Collapse load factor of masonry: rigid blocks, dry Coulomb joints, linear programming.

>>> import masonry_opt as mo
>>> result = mo.solve("cases/ferris_tinloi/wall_1.toml")

after Gilbert, Casapulla & Ahmed (2006), Computers and Structures 84, 873-887.
"""

from importlib import import_module as _import_module
from pathlib import Path as _Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from masonry_opt.analysis import solve as solve
    from masonry_opt.answer.certificate import Certificate as Certificate
    from masonry_opt.answer.result import Result as Result
    from masonry_opt.answer.status import Status as Status
    from masonry_opt.duality import DualityReport as DualityReport
    from masonry_opt.duality import check as check
    from masonry_opt.errors import CaseError as CaseError
    from masonry_opt.errors import MasonryError as MasonryError
    from masonry_opt.errors import OptionError as OptionError
    from masonry_opt.explain.stressed_joints import stressed_joints as stressed_joints
    from masonry_opt.scene.arch import Arch as Arch
    from masonry_opt.scene.arch import PointLoad as PointLoad
    from masonry_opt.scene.blocks import Block as Block
    from masonry_opt.scene.blocks import Joint as Joint
    from masonry_opt.scene.blocks import JointDefaults as JointDefaults
    from masonry_opt.scene.blocks import Reference as Reference
    from masonry_opt.scene.case_file import load as load
    from masonry_opt.scene.case_file import save as save
    from masonry_opt.scene.facade import Facade as Facade
    from masonry_opt.scene.scene import Scene as Scene
    from masonry_opt.scene.wall import Wall as Wall
    from masonry_opt.studies.compare.api import compare as compare

#: Where each name is. They are imported when first wanted: the modelling languages take seconds, in which the
#: command must be able to end on Ctrl-C, and analyses alone need no study.
_HOMES = {
    "analysis": ("solve",),
    "answer.certificate": ("Certificate",),
    "answer.result": ("Result",),
    "answer.status": ("Status",),
    "duality": ("DualityReport", "check"),
    "errors": ("CaseError", "MasonryError", "OptionError"),
    "explain.stressed_joints": ("stressed_joints",),
    "scene.arch": ("Arch", "PointLoad"),
    "scene.blocks": ("Block", "Joint", "JointDefaults", "Reference"),
    "scene.case_file": ("load", "save"),
    "scene.facade": ("Facade",),
    "scene.scene": ("Scene",),
    "scene.wall": ("Wall",),
    "studies.compare.api": ("compare",),
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
