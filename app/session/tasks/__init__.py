"""Long tasks beside the run: each on a thread of its own, with progress and cancel."""
