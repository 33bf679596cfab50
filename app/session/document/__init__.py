"""The document while it is edited: undo, and what an edit does to a run that is under way."""
