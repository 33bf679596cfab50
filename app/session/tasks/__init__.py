"""Long tasks beside the run: each on a separate thread, with progress and cancel."""
