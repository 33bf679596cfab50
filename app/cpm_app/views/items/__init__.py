"""Graphics items of the canvas: curves, discs, markers, labels, and their pens."""
