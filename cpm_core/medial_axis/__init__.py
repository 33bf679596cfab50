"""The medial axis between edges: boundary, Voronoi diagram, foreground, polarity, strips, pruning, disks."""
