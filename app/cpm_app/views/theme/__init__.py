"""Colors, color maps and icons of the light and the dark theme."""
