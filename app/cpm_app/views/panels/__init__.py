"""The panels next to the canvas, one a module."""
