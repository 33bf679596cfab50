"""What a person has drawn: starts, limits and placed charges."""
