"""The worker thread: the run, what it records, and what is made of it for the window."""
