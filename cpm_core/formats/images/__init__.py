"""Files of images that can be read."""
