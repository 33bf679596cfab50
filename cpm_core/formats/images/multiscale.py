"""Images at several resolutions, any part of which is read by itself: OME-Zarr, whole slides and other pyramids."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.formats.images.decoded import DecodedImage, decode_bands
from cpm_core.formats.images.reading import Reading, select_index
from cpm_core.image.colors import LUMINANCE_CHOICE, gray_from_color
from cpm_core.numerics.grids import Window
from cpm_core.numerics.types import Texts, record


@record
class MultiscaleImage:
    """An image at several resolutions, none of which has been read.

    Attributes
    ----------
    name : str
        Name of the file.
    arrays : tuple
        The levels, finest first, each an array of which indices and slices read parts.
    axes : str
        One letter for each axis of the arrays, t, c, z, y, x, or s for red, green, blue and opacity, in the order in
        which they are stored.
    spacing : tuple of float
        Size of a voxel of the finest level along (plane, row, col), in `unit`.
    unit : str or None
        Unit of length; None if unknown.
    series : tuple of str
        Names of all images of the file; empty if it holds only one.
    series_number : int
        Index of this image among them, from 0.
    channel_styles : tuple of (str, str)
        As in `Stack`.
    """

    name: str
    arrays: tuple[Any, ...]
    axes: str
    spacing: tuple[float, float, float] = (1.0, 1.0, 1.0)
    unit: str | None = None
    series: Texts = ()
    series_number: int = 0
    channel_styles: tuple[tuple[str, str], ...] = ()

    def axis_length(self, axis: str, level: int = 0) -> int:
        """Return the length of an axis given by its letter; 1 if there is none."""
        return int(self.arrays[level].shape[self.axes.index(axis)]) if axis in self.axes else 1

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the finest level."""
        return self.axis_length("y"), self.axis_length("x")

    def read_planes(self, level: int, time: int, channel: int, planes: slice, window: Window) -> DecodedImage:
        """Read part of a level at a time and in a channel: gray levels of shape (planes, rows, columns), and colors."""
        chosen: dict[str, int | slice] = {"t": time, "c": channel, "z": planes, "y": window[0], "x": window[1]}
        found = np.asarray(self.arrays[level][tuple(chosen.get(axis, slice(None)) for axis in self.axes)])
        stored = [axis for axis in self.axes if axis in "zyxs"]
        found = found.transpose([stored.index(axis) for axis in "zyxs" if axis in stored])
        found = found if "z" in stored else found[None]
        return decode_bands(found) if "s" in stored else DecodedImage(found)

    def find_finer_planes(self, level: int, time: int, channel: int, plane: int) -> tuple[FinerPlane, ...]:
        """Find a plane at resolutions finer than a level, finest first, each with twice as many rows as the next."""
        found: list[FinerPlane] = []
        while level > 0:
            ratio = self.axis_length("y", level - 1) / self.axis_length("y", level)
            step = 2 ** round(np.log2(ratio)) // 2
            if step < 1 or abs(ratio - 2 * step) * self.axis_length("y", level) > 2 * step:
                break
            level -= 1
            while step:
                found.insert(0, FinerPlane(self, level, time, channel, plane, step))
                step //= 2
        return tuple(found)

    def read_window(self, window: Window, reading: Reading) -> NDArray[Any]:
        """Read a window of the finest level, shape of the window: of all planes, or the selected or first one."""
        chosen = (("time", reading.time, "t"), ("channel", reading.channel, "c"), ("page", reading.page, "z"))
        time, channel, plane = (
            select_index(what, given, self.axis_length(at), 0, self.name) for what, given, at in chosen
        )
        planes = window[0] if len(window) == 3 else slice(plane, plane + 1)
        found = self.read_planes(0, time, channel, planes, window[-2:])
        values = found.values
        if found.colors is not None and reading.color != LUMINANCE_CHOICE:
            values, _ = gray_from_color(values, found.colors, reading.color)
        return values if len(window) == 3 else values[0]


@record
class FinerPlane:
    """A plane of a level, or every so many pixels of it (`step`), parts of which are read on demand."""

    levels: MultiscaleImage
    level: int
    time: int
    channel: int
    plane: int
    step: int = 1

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of rows and columns."""
        rows, columns = (-(-self.levels.axis_length(axis, self.level) // self.step) for axis in "yx")
        return rows, columns

    def __getitem__(self, window: Window) -> NDArray[Any]:
        """Read the gray levels of a window."""
        rows, columns = (slice(side.start * self.step, side.stop * self.step) for side in window)
        planes = slice(self.plane, self.plane + 1)
        found = self.levels.read_planes(self.level, self.time, self.channel, planes, (rows, columns))
        return found.values[0, :: self.step, :: self.step]
