"""How particles move, appear and disappear: eq. (12)-(15), insertion, deletion and equilibrium (sections 3.2, 3.3)."""
