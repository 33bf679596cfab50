"""Volumes: which slices are shown, and what a slice shows of a scene."""
