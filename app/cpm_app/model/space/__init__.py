"""The view of a volume in space, drawn without graphics hardware, so that it is the same on every screen and in files.

A camera gives where a position lies in the picture and how far away; what is drawn keeps, for each pixel, the nearest.
"""
