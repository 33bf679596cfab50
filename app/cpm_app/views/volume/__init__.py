"""Volumes in the window."""
