"""Closed forms of the semicircular arch under its own weight, of infinitely many voussoirs or so many."""

import math
from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

#: Angles from the crown (radians) among which the touching or sliding joint is looked for.
_JOINTS = np.linspace(0.05, 1.5, 200_001)


def least_thickness_ratio(weights: str, joints: np.ndarray = _JOINTS) -> float:
    """Least thickness over radius of the arch that hinges.

    The thrust passes the back at crown and springings, at R + t/2, and touches the intrados, r = R − t/2, at
    one of the joints between. With R = 1, η = t/R and a weight of 1 per angle, what is between the crown and
    a joint at the angle β weighs β, and its moment about the joint's intrados is β r sin β − ℓ (1 − cos β),
    ℓ the distance of the weights from the centre (of sectors 1 + η²/12). The crown's thrust has the lever
    1 + η/2 − r cos β there, and by balance about the springing's extrados it is π/2 − ℓ / (1 + η/2).

    Parameters
    ----------
    weights: "centreline": spread along the centreline, as Cocchetti & Rizzi (2020) do (0.107426);
        "sector": at the true centroids, as Milankovitch did (0.107478).
    joints: their angles from the crown (radians).
    """

    def surplus(eta: float) -> float:
        inner, outer, lever = 1 - eta / 2, 1 + eta / 2, _lever(weights, eta)
        moment = joints * inner * np.sin(joints) - lever * (1 - np.cos(joints))
        return _springing_thrust(weights, eta) - float((moment / (outer - inner * np.cos(joints))).max())

    return _root(surplus, 0.02, 0.3)


def least_friction_to_hinge(weights: str) -> float:
    """Friction where mode I ends: |s| / n at the springings at the least thickness."""
    return _springing_thrust(weights, least_thickness_ratio(weights)) / (math.pi / 2)


def least_friction_to_stand() -> float:
    """Friction where mode III begins: the part above some joint slides down and pushes the rest apart.

    That needs the thrust β / tan(β + φ) at the crown; the springings resist μ π / 2.
    """

    def surplus(friction: float) -> float:
        thrust = _JOINTS / np.tan(_JOINTS + math.atan(friction))
        return friction * math.pi / 2 - float(thrust.max())

    return _root(surplus, 0.05, 1.0)


def _springing_thrust(weights: str, eta: float) -> float:
    """Thrust through the back of crown and springings, over weight per angle."""
    return math.pi / 2 - _lever(weights, eta) / (1 + eta / 2)


def _lever(weights: str, eta: float) -> float:
    """Distance of the weights from the centre, over the radius."""
    return 1.0 if weights == "centreline" else 1 + eta**2 / 12


def _root(of: Callable[[float], float], low: float, high: float) -> float:
    return float(brentq(of, low, high, xtol=1e-13))
