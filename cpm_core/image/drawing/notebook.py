"""What notebooks show of an object: its picture, and the line that `repr` gives."""

from __future__ import annotations

from cpm_core.image.drawing.raster import in_html


class Pictured:
    """An object that has a picture.

    A class that derives from it gives the picture by `_repr_png_`, which notebooks and consoles of IPython ask for.
    """

    def _repr_png_(self) -> bytes:
        raise NotImplementedError

    def _repr_html_(self) -> str:
        return in_html(self._repr_png_(), repr(self))
