"""``cpm export``: the command, and what it takes from files and sessions."""
