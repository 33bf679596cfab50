"""Files in the window: the dialogs that ask for them, recent ones, the start screen, the place in a folder."""
