"""Capacity curves of mechanisms at finite displacements, and the kinematic checks of building codes.

This package follows a mechanism from the onset of collapse down to λ = 0: hinging mechanisms in the plane
(``path``), and one body that turns about an edge in space (``edge``). Sliding mechanisms are not followed.
It also displaces the blocks of a scene whose supports have settled by given amounts (``settled_state``).
"""
