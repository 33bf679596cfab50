"""The worker thread: the run, its record, and overlays and contours for the window."""
