"""Files of contours, one module per format."""
