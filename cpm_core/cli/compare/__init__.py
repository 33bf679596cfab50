"""``cpm compare``: the charged particles and the classical methods on the same image, from the same start."""
