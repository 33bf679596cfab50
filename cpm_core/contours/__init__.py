"""Contours: their points, measurements, agreement with one another and with a ground truth, and the user's review."""
