"""A scene under several live loads: its load cases, and earthquakes from all sides."""
