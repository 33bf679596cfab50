"""Plugin for napari: contours and surfaces as layers, read, written, and found from shapes drawn there.

It uses the library alone, not the window. napari finds it by its manifest, ``napari.yaml``.
"""
