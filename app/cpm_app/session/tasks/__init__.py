"""Long tasks next to the run: each on a separate thread, with progress and cancel."""
