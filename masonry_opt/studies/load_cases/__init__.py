"""Scenes under several live loads: load cases, and earthquakes from all sides."""
