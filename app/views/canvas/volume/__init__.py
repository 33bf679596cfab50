"""Volumes on the canvas: the line that chooses a slice, and the slices beside the canvas."""
