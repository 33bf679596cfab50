"""Preferences, presets, session files, autosave and recovery."""
