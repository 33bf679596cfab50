"""Files of label masks, one module per format."""
