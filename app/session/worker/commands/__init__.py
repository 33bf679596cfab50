"""Commands to the worker, by what they concern."""
