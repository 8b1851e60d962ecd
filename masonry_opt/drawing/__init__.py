"""Scenes and results as elements, made once, and the two ways to show them: pictures and pages."""
