"""Files of label masks, a module for each format."""
