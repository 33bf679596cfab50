"""How things stand, and what follows from it for what the window shows and enables."""
