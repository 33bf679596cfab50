"""OME-Zarr: multiscale images, any part of which can be read or written by itself (OME-NGFF 0.4 and 0.5)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.formats.common.content import UnreadableError, missing_package_message
from cpm_core.formats.common.printable import make_printable
from cpm_core.formats.images import resolution
from cpm_core.formats.images.decoded import MAXIMUM_PIXELS, DecodedImage
from cpm_core.formats.images.reading import Reading, select_index, select_series
from cpm_core.formats.images.stack import Stack
from cpm_core.numerics.grids import Window
from cpm_core.numerics.types import Extent, JsonDict, Texts, record
from cpm_core.parameters.formatting import format_size

FILE_KINDS = {".zarr": "OME-Zarr image"}

_ZARR_MARKERS = ("zarr.json", ".zgroup", ".zarray")
"""Files one of which marks a Zarr folder."""

_TILE_SIDE = 256
"""Side of the tiles that are written, a quarter of it in volumes [px]; a file holds the tiles of a shard."""

_MAX_COARSEST_SIDE = 512
"""Largest side of the coarsest level that is written, a quarter of it in volumes [px]."""

_OME_VERSION = "0.5"
"""Version of OME-NGFF that is written."""

_AXIS_LETTERS = "tczyx"
"""Axes that an image may have, in the order in which they are written."""


def is_zarr(folder: Path) -> bool:
    """Return whether a folder is a Zarr array or group."""
    return any((folder / mark).is_file() for mark in _ZARR_MARKERS)


@record
class MultiscaleImage:
    """An image at several resolutions, none of which has been read.

    Attributes
    ----------
    name : str
        Name of the file.
    arrays : tuple of zarr.Array
        The levels, finest first.
    axes : str
        One letter for each axis of the arrays, t, c, z, y or x, in the order in which they are stored.
    spacing : tuple of float
        Size of a voxel of the finest level along (plane, row, col), in `unit`.
    unit : str or None
        Unit of length; None if unknown.
    series : tuple of str
        Names of all images of the file; empty if it holds only one.
    series_number : int
        Index of this image among them, from 0.
    """

    name: str
    arrays: tuple[Any, ...]
    axes: str
    spacing: tuple[float, float, float] = (1.0, 1.0, 1.0)
    unit: str | None = None
    series: Texts = ()
    series_number: int = 0

    def axis_length(self, axis: str, level: int = 0) -> int:
        """Return the length of an axis given by its letter; 1 if there is none."""
        return int(self.arrays[level].shape[self.axes.index(axis)]) if axis in self.axes else 1

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the finest level."""
        return self.axis_length("y"), self.axis_length("x")

    def read_planes(self, level: int, time: int, channel: int, planes: slice, window: Window) -> NDArray[Any]:
        """Read part of a level at a time and in a channel, shape (planes, rows, columns)."""
        chosen: dict[str, int | slice] = {"t": time, "c": channel, "z": planes, "y": window[0], "x": window[1]}
        found: NDArray[Any] = np.asarray(self.arrays[level][tuple(chosen[axis] for axis in self.axes)])
        stored = [axis for axis in self.axes if axis in "zyx"]
        found = found.transpose([stored.index(axis) for axis in "zyx" if axis in stored])
        return found if "z" in stored else found[None]

    def find_finer_planes(self, level: int, time: int, channel: int, plane: int) -> tuple[FinerPlane, ...]:
        """Find a plane in the levels before one, finest first, as long as each has twice as many rows as the next."""
        found: list[FinerPlane] = []
        while level > 0 and abs(self.axis_length("y", level - 1) - 2 * self.axis_length("y", level)) <= 1:
            level -= 1
            found.insert(0, FinerPlane(self, level, time, channel, plane))
        return tuple(found)

    def read_window(self, window: Window, reading: Reading) -> NDArray[Any]:
        """Read a window of the finest level, shape of the window: of all planes, or the selected or first one."""
        chosen = (("time", reading.time, "t"), ("channel", reading.channel, "c"), ("page", reading.page, "z"))
        time, channel, plane = (
            select_index(what, given, self.axis_length(at), 0, self.name) for what, given, at in chosen
        )
        if len(window) == 3:
            return self.read_planes(0, time, channel, window[0], window[1:])
        return self.read_planes(0, time, channel, slice(plane, plane + 1), window)[0]


@record
class FinerPlane:
    """A plane of a level, parts of which are read on demand."""

    levels: MultiscaleImage
    level: int
    time: int
    channel: int
    plane: int

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of rows and columns."""
        return self.levels.axis_length("y", self.level), self.levels.axis_length("x", self.level)

    def __getitem__(self, window: Window) -> NDArray[Any]:
        """Read the gray levels of a window."""
        plane = slice(self.plane, self.plane + 1)
        return self.levels.read_planes(self.level, self.time, self.channel, plane, window)[0]


def open_multiscale(path: Path, reading: Reading = Reading()) -> MultiscaleImage:  # noqa: B008 - a frozen value
    """Open an image in a Zarr folder; UnreadableError when it holds none, or the package zarr is missing."""
    try:
        import zarr
    except ImportError:
        raise UnreadableError(missing_package_message(path.name, "zarr", "cpm-particles[scale]")) from None
    name = make_printable(path.name)
    found = zarr.open(path, mode="r")
    if isinstance(found, zarr.Array):
        if found.ndim not in range(2, len(_AXIS_LETTERS) + 1):
            raise UnreadableError(f"{name} has {found.ndim} axes, but an image has two to five.")
        return MultiscaleImage(name, (found,), _AXIS_LETTERS[-found.ndim :])
    series = (
        ()
        if _find_multiscales(found)
        else tuple(sorted((key for key, _ in found.groups()), key=lambda key: (len(key), key)))
    )
    number = select_series(reading.series, series, 0, name) if series else 0
    group = found[series[number]] if series else found
    scales = _find_multiscales(group)
    if not scales:
        raise UnreadableError(f"{name} is a folder of Zarr without an image: name the one in it that has levels.")
    axes = [one if isinstance(one, dict) else {"name": one} for one in scales.get("axes", _AXIS_LETTERS)]
    letters = "".join(one["name"] for one in axes)
    if not set("yx") <= set(letters) <= set(_AXIS_LETTERS):
        raise UnreadableError(f"{name} has the axes {letters}, but an image has rows and columns, y and x.")
    levels = tuple(group[one["path"]] for one in scales["datasets"])
    sizes = (
        dict(zip(letters, _combine_scales(scales["datasets"][0]) * _combine_scales(scales), strict=True))
        if "axes" in scales
        else {}
    )
    named = {one["name"]: str(one.get("unit") or "") for one in axes}
    sides = [float(sizes.get(axis, sizes.get("y", 1.0))) for axis in "zyx"]
    spacing, unit = resolution.spacing_from_sizes(sides, [named.get(axis, "") for axis in "zyx"])
    return MultiscaleImage(name, levels, letters, spacing, unit, series, number)  # type: ignore[arg-type]


def _find_multiscales(group: Any) -> JsonDict:
    """Find the first entry on resolution levels in a group; empty if it has none."""
    known = dict(group.attrs)
    found: Sequence[JsonDict] = known.get("ome", known).get("multiscales", ())
    return dict(found[0]) if found else {}


def _combine_scales(entry: Mapping[str, Any]) -> NDArray[np.float64]:
    """Multiply the scale transformations of an entry, for each axis; 1 without any."""
    scales = [one["scale"] for one in entry.get("coordinateTransformations", ()) if one["type"] == "scale"]
    return np.prod(np.array(scales, dtype=float), axis=0)  # 1 for an empty product


def open_image_file(path: Path, reading: Reading) -> Stack:
    """Open an image at the finest level with a moderate number of pixels."""
    levels = open_multiscale(path, reading)
    planes = levels.axis_length("z")
    fitting = (
        k for k in range(len(levels.arrays)) if math.prod(levels.axis_length(a, k) for a in "zyx") <= MAXIMUM_PIXELS
    )
    level = next(fitting, len(levels.arrays) - 1)
    shape = (levels.axis_length("z", level), levels.axis_length("y", level), levels.axis_length("x", level))

    def read_planes(time: int, channel: int, first: int, end: int) -> DecodedImage:
        values = levels.read_planes(level, time, channel, slice(first, end), (slice(None), slice(None)))
        same = planes == shape[0] and end == first + 1
        return DecodedImage(values, finer=levels.find_finer_planes(level, time, channel, first) if same else ())

    notes: Texts = ()
    if level:
        notes = (
            f"It has {format_size(levels.shape)}, of which level {level} was opened, {shape[1]} x {shape[2]} px; "
            "cpm run with --auto works on all of them.",
        )
    sides = (planes / shape[0], levels.shape[0] / shape[1], levels.shape[1] / shape[2])
    deep, row, col = (size * side for size, side in zip(levels.spacing, sides, strict=True))
    return Stack(
        levels.name,
        shape,
        read_planes,
        float(levels.arrays[level].dtype.itemsize),
        levels.axis_length("t"),
        levels.axis_length("c"),
        (deep, row, col),
        levels.unit,
        notes=notes,
        series=levels.series,
        series_number=levels.series_number,
    )


def create_multiscale(
    path: Path,
    shape: Extent,
    dtype: Any,
    side: int,
    spacing: Sequence[float] = (1.0, 1.0, 1.0),
    unit: str | None = None,
    metadata: Mapping[str, Any] = {},
) -> int:
    """Create an image or volume of zeros with levels of half the size each, and return their number.

    Windows of `side` px, a multiple of 256, can be written concurrently. Pixel centers of a level coincide with those
    of every second plane, row and column of the previous level. `metadata` is added to the metadata.
    """
    import zarr

    group = zarr.open_group(path, mode="w")
    axes, part = _AXIS_LETTERS[-len(shape) :], 1 if len(shape) == 2 else 4
    tile, shard = (_TILE_SIDE // part,) * len(shape), (side,) * len(shape)
    count = 1 + max(math.ceil(math.log2(max(shape) * part / _MAX_COARSEST_SIDE)), 0)
    for level in range(count):
        size = tuple(-(-n // 2**level) for n in shape)
        group.create_array(str(level), shape=size, dtype=dtype, chunks=tile, shards=shard)
    units = {"unit": resolution.long_unit_name(unit)} if unit else {}
    sides = np.array(spacing[-len(shape) :], float)
    levels = [
        {
            "path": str(level),
            "coordinateTransformations": [{"type": "scale", "scale": (sides * 2.0**level).tolist()}],
        }
        for level in range(count)
    ]
    named = [{"name": name, "type": "space", **units} for name in axes]
    scales = [{"name": path.stem, "axes": named, "datasets": levels}]
    group.attrs["ome"] = {"version": _OME_VERSION, "multiscales": scales, **metadata}
    return count


def write_window(path: Path, level: int, window: Window, values: NDArray[Any]) -> None:
    """Write a window of a level; `values` has the shape of the window."""
    import zarr

    zarr.open_group(path, mode="r+")[str(level)][window] = values


def halve_window(path: Path, level: int, window: Window) -> None:
    """Fill a window of a level with every second pixel of the previous level along each axis."""
    import zarr

    group = zarr.open_group(path, mode="r+")
    finer = tuple(slice(2 * side.start, 2 * side.stop) for side in window)
    group[str(level)][window] = group[str(level - 1)][finer][(slice(None, None, 2),) * len(window)]
