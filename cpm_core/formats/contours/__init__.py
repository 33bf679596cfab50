"""Files of contours, a module for each format."""
