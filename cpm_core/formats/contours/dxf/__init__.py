"""DXF: drawings for CAD, their frame and their colors."""
