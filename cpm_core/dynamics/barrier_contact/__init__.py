"""Contact with a barrier: a particle whose step would cross one slides along it, or stays where it is."""
