"""What the user can prefer: each preference with its name, kind, default, limits and words."""
