"""Decide if a scene is stable, and if a load factor exists, by separate programs.

- ``dead_load`` and ``diagnosis``: is the scene stable under its dead load, and if not, what would hold it?
- ``existence``: does a load factor exist, and if not, which proof is there?
"""
