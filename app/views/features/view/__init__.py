"""Menu View: layers, appearance, mosaic, animations."""
