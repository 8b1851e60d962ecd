"""Joints of a scene: where its blocks touch, along edges in the plane and over faces in space."""
