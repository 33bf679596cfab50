"""Reading of contours: a module for each format, `contour_file` for the choice among them."""
