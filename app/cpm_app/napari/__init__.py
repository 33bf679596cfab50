"""The plugin for napari: contours and surfaces as layers, read, written, and found from shapes that are drawn there.

It uses the library alone, and nothing of the window. napari finds it by its manifest, ``napari.yaml``.
"""
