"""Files in the window: recent files, the start screen, and the dialogs of their parts and pixel size."""
