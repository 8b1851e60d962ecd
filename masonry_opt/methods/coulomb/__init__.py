"""Method "coulomb", the default: the list of steps that look for the lowest exact collapse state."""
