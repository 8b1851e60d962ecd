"""The limit analysis problem as matrices: equilibrium, joint laws, loads, and residuals of states."""
