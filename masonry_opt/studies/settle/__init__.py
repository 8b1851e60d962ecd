"""Supports that settle: the least and the greatest reaction with which a scene is stable."""
