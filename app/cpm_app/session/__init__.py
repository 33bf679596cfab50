"""The session: editing, undo, the run, and the worker thread; no widgets."""
