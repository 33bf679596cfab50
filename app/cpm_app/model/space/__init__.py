"""The view of a volume in space, drawn without graphics hardware, so that it is the same on every screen and in files.

A camera projects positions into the picture and gives their depth; for each pixel, only what is nearest remains.
"""
