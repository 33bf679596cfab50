"""The document while it is edited: undo, and what an edit changes in a run."""
