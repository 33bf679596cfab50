"""The command ``cpm skeleton``: the skeletons in an image, and the center lines in a volume."""
