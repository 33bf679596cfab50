"""The mosaic: the same image with other parameters side by side, of which one is picked."""

from app.views.mosaic.dialog import MosaicDialog

__all__ = ["MosaicDialog"]
