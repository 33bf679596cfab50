"""Menu View: layers, looks, mosaic, animations."""
