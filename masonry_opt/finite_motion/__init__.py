"""Capacity curves of mechanisms at finite displacements, and the kinematic checks of building codes.

This package computes the motion of a mechanism from the onset of collapse down to λ = 0, for hinging
mechanisms in the plane (``path``) and for one body that rotates about an edge in space (``edge``). Sliding
mechanisms are not supported. The package also displaces the blocks of a scene whose supports have settled by
given amounts (``settled_state``).
"""
