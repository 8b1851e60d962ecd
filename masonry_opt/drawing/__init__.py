"""Pictures and pages of scenes and results, both from one list of elements to draw."""
