"""Menu Edit: what is drawn, modes, undo."""
