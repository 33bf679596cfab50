"""Level sets: contours that are the zero of a function on the pixels, which an equation moves."""
