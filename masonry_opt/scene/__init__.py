"""Scenes: blocks and joints as a user describes them, and the case files that hold them."""
