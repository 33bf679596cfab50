"""Shapes in volumes."""
