"""Outlines: the closed boundaries of objects, to a fraction of a pixel."""
