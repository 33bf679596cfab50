"""Features of the session beside a run: contour review, ground truth, parameter sweeps, skeletons, navigation."""
