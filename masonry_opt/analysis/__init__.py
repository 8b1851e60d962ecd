"""The analyses: a scene and a method to a result."""
