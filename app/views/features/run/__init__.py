"""Menu Run: run and pause, parameters, timeline, tasks."""
