"""The desktop program: a model without Qt, a session without widgets, and the views on top."""
