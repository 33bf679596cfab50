"""Faces: the small regions that contours, barriers and the ridges of the edge map cut an image into."""
