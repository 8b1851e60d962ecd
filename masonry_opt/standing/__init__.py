"""Decide questions beside the load factor, by programs of their own.

- ``dead_load`` and ``diagnosis``: is the scene stable under its dead load, and if not, what would hold it?
- ``existence``: does a load factor exist, and if not, which proof is there?
"""
