"""Files of surfaces, for programs of radiology, printing and display."""
