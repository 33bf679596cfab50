"""Runs as a part of a session file."""
