"""How particles move, are inserted and are deleted: eq. (12)-(15) and equilibrium (sections 3.2, 3.3, 3.6)."""
