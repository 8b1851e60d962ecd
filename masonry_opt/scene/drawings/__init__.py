"""Drawings: outlines in DXF and solids in COMPAS JSON, to scenes; and scenes to DXF."""
