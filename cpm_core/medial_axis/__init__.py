"""The medial axis of the regions between edges: boundary, Voronoi diagram, foreground, pruning, disks."""
