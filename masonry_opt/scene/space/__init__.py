"""Rigid polyhedral blocks in space: their faces, convex parts and shapes."""
