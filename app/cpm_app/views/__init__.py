"""The views: the main window, the canvas with its layers and tools, and the panels."""
