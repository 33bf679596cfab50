"""Files of all pages of a stack; `files` chooses the writer."""
