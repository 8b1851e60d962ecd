"""Every method by name. Adding one is one entry."""

from __future__ import annotations

from masonry_opt.methods.task import Method
from masonry_opt.solvers.registry import MATRICES, capable

_ALL = (
    Method("static", "associative:associative", associative=True),
    Method("kinematic", "associative:kinematic", associative=True),
    Method(
        "nonassociative",
        "loop.nonassociative:nonassociative",
        "loop.options:LoopOptions",
        # A vertex has joints without normal force, which the loop then locks: prefer interior points.
        {"cvxpy": (), "pyomo": ("highs-ipm", "highs", "highs-hipo")},
    ),
    Method(
        "mcp",
        "mcp.method:mcp",
        "mcp.method:McpOptions",
        {MATRICES: ("newton",)},
        own_tolerances=True,
    ),
    Method(
        "compliant",
        "push.compliant:compliant",
        "push.compliant:CompliantOptions",
        {MATRICES: ("newton",)},
        own_tolerances=True,
        constant_dilatancy=True,
    ),
    Method(
        "mpec",
        "mpec:mpec",
        "mpec:MpecOptions",
        {"pyomo": capable("pyomo", lambda solver: solver.nonlinear)},
        own_tolerances=True,
        constant_dilatancy=True,
    ),
    Method(
        "refined",
        "refined:refined",
        "refined:RefinedOptions",
        {"cvxpy": ("highs",)},
        own_tolerances=True,
        constant_dilatancy=True,
    ),
    Method(
        "global",
        "bracket.bracket:global_search",
        "bracket.bracket:GlobalOptions",
        {"pyomo": ("highs",)},
        own_tolerances=True,
        constant_dilatancy=True,
        crushing=False,
        limited=False,
        space=False,
    ),
)

METHODS = {method.name: method for method in _ALL}

#: The method of whoever names none.
DEFAULT = "mcp"
