"""Method "mcp", the default: exact Coulomb states near the end of a load history, and the lowest of them."""
