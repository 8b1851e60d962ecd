"""Scenes: blocks and joints as a user describes them, and the case files that hold them."""

from masonry_opt.scene.arch import Arch, PointLoad
from masonry_opt.scene.blocks import Block, Joint, JointDefaults, Reference
from masonry_opt.scene.case_file import load, save
from masonry_opt.scene.facade import Facade
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.wall import Wall

__all__ = [
    "Arch",
    "Block",
    "Facade",
    "Joint",
    "JointDefaults",
    "PointLoad",
    "Reference",
    "Scene",
    "Wall",
    "load",
    "save",
]
