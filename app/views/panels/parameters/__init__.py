"""The panel of parameters: a slider each, explained in words and by an illustration."""
