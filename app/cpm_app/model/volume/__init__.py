"""Volumes in the window: the slices that are shown, and their content."""
