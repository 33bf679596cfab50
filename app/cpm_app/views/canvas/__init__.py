"""The canvas: what is drawn on an image, and the tools that draw."""
