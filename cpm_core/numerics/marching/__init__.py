"""Surfaces through values on a grid: marching cubes whose triangles leave no holes."""
