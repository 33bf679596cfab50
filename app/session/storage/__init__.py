"""What outlives the program: preferences, presets, session files, autosave and recovery."""
