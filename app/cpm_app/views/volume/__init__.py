"""The view of a volume in space."""
