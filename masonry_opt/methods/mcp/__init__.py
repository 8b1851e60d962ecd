"""Method "mcp": the Coulomb answer in one interior-point pass over the complementarity problem."""
