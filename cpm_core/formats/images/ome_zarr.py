"""OME-Zarr: multiscale images, any part of which can be read or written by itself (OME-NGFF 0.4 and 0.5)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.formats.common.content import UnreadableError
from cpm_core.formats.common.printable import make_printable
from cpm_core.formats.images import resolution
from cpm_core.formats.images.multiscale import MultiscaleImage
from cpm_core.formats.images.reading import Reading, select_series
from cpm_core.formats.images.stack import Stack, stack_from_levels
from cpm_core.numerics.grids import Window
from cpm_core.numerics.packages import require_package
from cpm_core.numerics.types import Extent, JsonDict

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


def open_multiscale(path: Path, reading: Reading = Reading()) -> MultiscaleImage:  # noqa: B008 - a frozen value
    """Open an image in a Zarr folder; UnreadableError when it holds none, or the package zarr is missing."""
    require_package("zarr", path.name)
    import zarr

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
    number = select_series(reading, series, name) if series else 0
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
    known = dict(group.attrs)
    channels = known.get("ome", known).get("omero", {}).get("channels", ())
    styles = tuple(
        (make_printable(one.get("label", "")), f"#{one['color']}".lower() if one.get("color") else "")
        for one in channels
    )
    return MultiscaleImage(name, levels, letters, spacing, unit, series, number, styles)  # type: ignore[arg-type]


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
    return stack_from_levels(open_multiscale(path, reading))


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


def write_window(path: Path, window: Window, values: NDArray[Any]) -> None:
    """Write a window of the finest level; `values` has the shape of the window."""
    import zarr

    zarr.open_group(path, mode="r+")["0"][window] = values


def halve_window(path: Path, level: int, window: Window) -> None:
    """Fill a window of a level with every second pixel of the previous level along each axis."""
    import zarr

    group = zarr.open_group(path, mode="r+")
    finer = tuple(slice(2 * side.start, 2 * side.stop) for side in window)
    group[str(level)][window] = group[str(level - 1)][finer][(slice(None, None, 2),) * len(window)]
