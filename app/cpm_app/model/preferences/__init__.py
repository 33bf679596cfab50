"""Preferences of the user, each with its name, kind, default, limits and words."""
