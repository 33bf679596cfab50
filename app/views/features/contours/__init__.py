"""Menu Contours: review, table and comparison with a ground truth."""
