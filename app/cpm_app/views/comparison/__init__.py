"""Comparison of results: the panel with their table, and the divider on the canvas."""
