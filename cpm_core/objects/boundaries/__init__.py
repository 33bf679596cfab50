"""Boundaries: unambiguous closed contours, and the lines that the outline of an object follows."""
