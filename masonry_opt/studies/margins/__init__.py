"""Margins other than load: the least or the greatest of any number at which a scene still stands."""
