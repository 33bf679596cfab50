"""Menu File: open, save, export, clipboard, preferences, recovery."""
