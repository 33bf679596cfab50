"""Graphs of points and edges, from which contours are read."""
