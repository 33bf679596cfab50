"""Reading of DXF: its group codes, its entities, and the drawing as a whole."""
