"""The line below the image, and what the status bar shows of the canvas."""
