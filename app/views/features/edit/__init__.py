"""Menu Edit: drawing, modes, undo."""
