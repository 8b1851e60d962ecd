"""Scenes with other values of their numbers: sweeps, random samples, and thresholds of stability."""
