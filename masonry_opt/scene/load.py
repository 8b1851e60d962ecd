"""Loads on single blocks by name: of blocks that a generator builds, and at points inside a wall."""

from __future__ import annotations

from pydantic import model_validator

from masonry_opt.scene.blocks import Name, NonNegative, Point, Record


class Load(Record):
    """Forces on one block, beside its own, wherever its edges are; several on one block add up.

    Parameters
    ----------
    block:
        Name of a block that is not fixed.
    live:
        Live force ``[fx, fy]``, scaled by the load factor.
    dead:
        Dead force ``[fx, fy]`` beside the weight.
    at:
        The point where both act, ``[x, y]`` (default: the block's centroid).
    weight:
        In place of the block's own weight; once for each block.

    Raises
    ------
    CaseError
        If it says nothing, or gives a point without a force.
    """

    block: Name
    live: Point | None = None
    dead: Point | None = None
    at: Point | None = None
    weight: NonNegative | None = None

    @model_validator(mode="after")
    def _says_something(self) -> Load:
        if self.live is None and self.dead is None:
            if self.at is not None:
                raise ValueError("'at' needs a force: give 'live' or 'dead'")
            if self.weight is None:
                raise ValueError("has no force: give 'live', 'dead' or 'weight'")
        return self
