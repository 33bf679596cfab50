"""Volumes on the canvas: the line that chooses a slice; the view in space has its place here as well."""
