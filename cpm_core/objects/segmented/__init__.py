"""Segmented objects, as a session keeps them: clicks, boundary and class of each, and the union of two."""
