"""The free particles: their state, initialization, neighbors and coverage, and the Coulomb force, eq. (9)."""
