"""Decide if a scene is stable, and if a load factor exists, by separate optimisation programs.

- ``dead_load`` and ``diagnosis``: decide if the scene is stable under its dead load. If it is unstable, find
  the friction or strength that would stabilise it.
- ``existence``: decide if a load factor exists, and prove it if none exists.
- ``reserves``: compute how much friction, and how much of its joints, a stable scene can lose.
"""
