"""Where contours and surfaces differ from a ground truth, and what slices show of it."""
