"""Readers of drawings and meshes, each of which makes a scene; and the writer of DXF drawings."""
