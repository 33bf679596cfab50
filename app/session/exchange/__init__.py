"""What passes between the worker thread and the window: messages, and the places where they are left."""
