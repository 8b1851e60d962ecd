"""Which blocks of meshes are supports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from masonry_opt.scene.blocks import Name, Number, Record
from masonry_opt.scene.drawings.meshes import Mesh

#: Supports have one of these words in the name of their layer or object.
FIXED = ("fixed", "support")


class Supports(Record):
    """Which blocks are supports beside those drawn so: see :func:`read_mesh` and :func:`read_compas`."""

    fixed: list[Name] = []
    fixed_below: Number | None = None


def listed(names: Sequence[str]) -> str:
    """The first ten names, as messages list them."""
    return ", ".join(names[:10]) + (", ..." if len(names) > 10 else "")


def with_supports(meshes: Sequence[Mesh], which: Supports, words: Sequence[str] = ()) -> list[Mesh]:
    """The blocks, those a support that are one already, are named, reach down to a height, or have one of the
    words in their name or that of their layers.

    Raises ValueError if a name is none of theirs, or nothing is a support.
    """
    names = [mesh.name for mesh in meshes]
    if unknown := [name for name in which.fixed if name not in names]:
        raise ValueError(f"'fixed': no block '{unknown[0]}' (blocks: {listed(names)})")
    below = -np.inf if which.fixed_below is None else which.fixed_below
    lowest = [float(mesh.points[:, 2].min()) for mesh in meshes]
    found = [
        replace(
            mesh,
            fixed=mesh.fixed
            or mesh.name in which.fixed
            or low <= below
            or any(word.casefold() in f"{mesh.name} {mesh.layers}".casefold() for word in words),
        )
        for mesh, low in zip(meshes, lowest, strict=True)
    ]
    if not any(mesh.fixed for mesh in found):
        raise ValueError(
            f"no block is a support: name them by 'fixed' (blocks: {listed(names)}), or take those that "
            f"reach down to a height by 'fixed_below' (the lowest corner is at z = {min(lowest):.6g})"
        )
    return found
