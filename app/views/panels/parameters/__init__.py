"""The panel of parameters: one slider eachand explained in words."""
