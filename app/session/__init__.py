"""What happens: the one door for edits and runs, undo, and the worker thread; no widgets."""
