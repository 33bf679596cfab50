"""Export: what is written to a file, and what a format leaves out."""
