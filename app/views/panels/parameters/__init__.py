"""The panel of parameters: one slider each, explained in words and by an illustration."""
