"""State of the run, and what the window shows and enables in each state."""
