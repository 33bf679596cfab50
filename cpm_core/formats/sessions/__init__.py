"""Session files: shapes, parameters and the review of contours, as readable JSON."""
