"""Fields for numbers: one to type in, and a slider with marks."""
