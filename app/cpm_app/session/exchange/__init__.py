"""Messages between the worker thread and the window, and the slots that hold them."""
