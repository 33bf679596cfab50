"""Curves in the plane through particles: along the ridges of an edge map, or through points only."""
