"""Features of the session in addition to a run: contours, ground truth, objects, pages, slices, timeline."""
