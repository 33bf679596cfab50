"""The mosaic: runs of one image with different parameters side by side, of which the user chooses one."""

from app.views.mosaic.dialog import MosaicDialog

__all__ = ["MosaicDialog"]
