"""Menu Contours: review, table and comparison with a truth."""
