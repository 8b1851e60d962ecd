"""Scenes as users give them: blocks, joints, loads, files and generators, without any mathematics."""
