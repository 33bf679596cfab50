"""The pages of a stack: the line that chooses one, and the table of what was found on all."""
