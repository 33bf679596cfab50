"""What a plot is made of: curves, discs, markers, labels and their pens."""
