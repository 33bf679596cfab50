"""Runs beside the run of the session: with other parameters, and of other methods."""
