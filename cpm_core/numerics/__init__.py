"""What the model computes with: compiled loops and their cache, threads, and the geometry of lines in the plane."""
