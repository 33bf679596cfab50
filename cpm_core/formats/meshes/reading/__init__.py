"""Reading of surfaces and center lines: a module for each format, `mesh_file` and `tree` for what files become."""
