"""Reach of a start: its area, up to the edges that enclose it, and the fields of a run limited by it."""
