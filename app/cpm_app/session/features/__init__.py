"""Features of the session in addition to a run: review, ground truth, objects, pages, slices, timeline."""
