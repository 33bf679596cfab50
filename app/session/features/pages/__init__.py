"""The pages of a stack: each with its own document and run, and all of them run one after the other."""
