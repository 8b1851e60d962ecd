"""The loop of section 4.2: the six steps; beside them when to stop, the exact end and remedies."""
