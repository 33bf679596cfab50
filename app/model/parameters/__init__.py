"""Parameters as controls, and named sets of them."""
