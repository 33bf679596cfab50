"""Boundaries: closed contours that are certain, and the lines that the outline of an object follows."""
