"""The Coulomb force between particles, eq. (9): anywhere (`coulomb_force`), in a run (`pair_force`, `mesh_force`)."""
