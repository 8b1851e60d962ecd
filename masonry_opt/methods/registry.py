"""Every method by name. Adding one is one entry."""

from __future__ import annotations

from masonry_opt.methods.associative import KINEMATIC, STATIC
from masonry_opt.methods.bracket.method import GLOBAL
from masonry_opt.methods.loop.method import NONASSOCIATIVE
from masonry_opt.methods.mcp.method import MCP
from masonry_opt.methods.mpec import MPEC
from masonry_opt.methods.refined.method import REFINED

METHODS = {method.name: method for method in (STATIC, KINEMATIC, NONASSOCIATIVE, MCP, MPEC, REFINED, GLOBAL)}

#: The method of whoever names none.
DEFAULT = MCP.name
