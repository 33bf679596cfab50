"""From particles in a volume to surfaces."""
