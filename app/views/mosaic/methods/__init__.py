"""The comparison of methods: up to four of them side by side on the image, from the start that is drawn."""

from app.views.mosaic.methods.dialog import CompareDialog

__all__ = ["CompareDialog"]
