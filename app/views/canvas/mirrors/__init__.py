"""Views over the canvas that show the same place in another way: a wipe between two results, and a magnifier."""
