"""The free particles: their state, starting points, neighbors and coverage, and the Coulomb force, eq. (9)."""
