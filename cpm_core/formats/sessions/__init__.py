"""Session files: shapes, parameters and objects, as readable JSON."""
