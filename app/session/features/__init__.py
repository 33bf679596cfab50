"""What the session offers beside a run: review of contours, comparison with a truth, sweeps, skeletons, navigation."""
