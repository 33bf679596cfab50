"""Files of microscopes: CZI of Zeiss, LIF of Leica and ND2 of Nikon, each read by a package of its own."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cpm_core.formats.common.content import UnreadableError
from cpm_core.formats.common.printable import make_printable
from cpm_core.formats.images import resolution
from cpm_core.formats.images.decoded import DecodedImage, check_pixel_count, decode_bands
from cpm_core.formats.images.reading import Reading, select_series
from cpm_core.formats.images.stack import Stack
from cpm_core.numerics.packages import require_package
from cpm_core.numerics.types import Numbers

FILE_KINDS = {".czi": "CZI file of Zeiss", ".lif": "LIF file of Leica", ".nd2": "ND2 file of Nikon"}

_STORED_ROLES = ("plane", "row", "col", "color")
"""Roles of the axes of what is read at once, in our order."""


class _Scene(NamedTuple):
    """An image of a file.

    Attributes
    ----------
    name : str
        Its name.
    sizes : dict
        Letter of each axis, in the order in which they are stored -> its length.
    steps : dict
        Letter of an axis in space -> distance of its pixels [m], where the file states it.
    dtype : numpy.dtype
        Type of the samples.
    read_part : callable
        Reads a part by index, or by slice, of each axis that is named; axes of length 1 may be missing in it.
    channel_styles : tuple of (str, str)
        As in `Stack`.
    """

    name: str
    sizes: Mapping[str, int]
    steps: Mapping[str, float]
    dtype: np.dtype[Any]
    read_part: Callable[[Mapping[str, int | slice]], Numbers]
    channel_styles: tuple[tuple[str, str], ...] = ()


def _list_czi_scenes(file: Any) -> list[_Scene]:
    """List the scenes of a CZI, whose axes begin anywhere; scans in fields are put together."""

    def list_scene(number: int, scene: Any) -> _Scene:
        begin = dict(zip(scene.dims, scene.start, strict=True))

        def read_part(part: Mapping[str, int | slice]) -> Numbers:
            chosen = {
                axis: slice(at.start + begin[axis], at.stop + begin[axis])
                if isinstance(at, slice)
                else at + begin[axis]
                for axis, at in part.items()
            }
            return np.asarray(scene(**chosen).asarray())

        return _Scene(f"scene {number + 1}", scene.sizes, scene.coord_scales, scene.dtype, read_part)

    return [list_scene(number, scene) for number, scene in enumerate(file.scenes.values())]


def _list_lif_images(file: Any) -> list[_Scene]:
    """List the images of a LIF."""

    def list_image(image: Any) -> _Scene:
        steps = {
            axis: abs(float(image.coords[axis][1] - image.coords[axis][0])) for axis in "ZYX" if axis in image.coords
        }
        return _Scene(
            image.name, image.sizes, steps, image.dtype, lambda part: np.asarray(image.frames(**part).asarray())
        )

    return [list_image(image) for image in file.images]


def _list_nd2_positions(file: Any) -> list[_Scene]:
    """List the positions of an ND2, which are images of their own."""
    volume = file.metadata.channels[0].volume
    stated = (one.channel for one in file.metadata.channels)
    styles = tuple((make_printable(one.name), one.color.as_hex()) for one in stated)
    known = zip("XYZ", volume.axesCalibrated, volume.axesCalibration, strict=True)
    sizes, steps = dict(file.sizes), {axis: 1e-6 * step for axis, is_known, step in known if is_known}
    count, data = sizes.pop("P", 1), file.to_dask()

    def list_position(number: int) -> _Scene:
        def read_part(part: Mapping[str, int | slice]) -> Numbers:
            chosen = {"P": number, **part}
            return np.asarray(data[tuple(chosen.get(axis, slice(None)) for axis in file.sizes)])

        return _Scene(f"position {number + 1}", sizes, steps, file.dtype, read_part, styles)

    return [list_position(number) for number in range(count)]


_READERS: dict[bytes, tuple[str, str, Callable[[Any], list[_Scene]]]] = {
    b"ZISRAWFILE": ("czifile", "CziFile", _list_czi_scenes),
    b"p\0\0\0": ("liffile", "LifFile", _list_lif_images),
    b"\xda\xce\xbe\x0a": ("nd2", "ND2File", _list_nd2_positions),
}
"""First bytes of a file -> the package that reads it, its class for files, and what lists the images of one."""


def can_read(head: bytes, _path: Path) -> bool:
    """Return whether a file begins like one of these."""
    return head.startswith(tuple(_READERS))


def open_image_file(path: Path, reading: Reading) -> Stack:
    """Open an image of a file: the last two of its axes in space are rows and columns.

    Raises
    ------
    UnreadableError
        When the package that reads it is missing, or it has more axes than planes, rows, columns, times and channels.
    """
    name = make_printable(path.name)
    with path.open("rb") as stream:
        head = stream.read(10)
    package, kind, list_scenes = next(reader for mark, reader in _READERS.items() if head.startswith(mark))
    require_package(package, name)
    open_file = getattr(importlib.import_module(package), kind)
    with open_file(path) as file:
        scenes = [scene._replace(name=make_printable(scene.name)) for scene in list_scenes(file)]
    names = tuple(scene.name for scene in scenes)
    number = select_series(reading, names, name)
    scene = scenes[number]
    roles = _assign_roles(scene.sizes, name)
    size = {role: scene.sizes[axis] for role, axis in roles.items()}
    check_pixel_count(name, size["row"], size["col"])
    sides = [scene.steps.get(roles.get(role, ""), 0.0) for role in ("plane", "row", "col")]
    (row, col), unit = resolution.spacing_from_sizes([1e6 * side for side in sides[1:]], 2 * [resolution.MICROMETER])
    deep = 1e6 * sides[0] if unit else 0.0
    order = [role for role in _STORED_ROLES if role in roles]

    def read_planes(time: int, channel: int, first: int, end: int) -> DecodedImage:
        chosen: dict[str, int | slice] = {"time": time, "channel": channel, "plane": slice(first, end)}
        with open_file(path) as file:
            part = {roles[role]: at for role, at in chosen.items() if role in roles}
            found = list_scenes(file)[number].read_part(part)
        left = [role for role in roles if role in order]
        found = found.reshape([end - first if role == "plane" else size[role] for role in left])
        found = found.transpose([left.index(role) for role in order])
        found = found if "plane" in order else found[None]
        return decode_bands(found) if "color" in order else DecodedImage(found)

    return Stack(
        name,
        (size.get("plane", 1), size["row"], size["col"]),
        read_planes,
        float(scene.dtype.itemsize * size.get("color", 1)),
        size.get("time", 1),
        size.get("channel", 1),
        (deep or row, row, col),
        unit,
        notes=() if reading.series or len(names) == 1 else (f"Only the first of its {len(names)} series was taken.",),
        series=names,
        series_number=number,
        has_plane_spacing=deep > 0.0,
        channel_styles=scene.channel_styles,
    )


def _assign_roles(sizes: Mapping[str, int], name: str) -> dict[str, str]:
    """Assign roles to the axes of an image, in the order in which they are stored: wavelengths are channels as well."""
    space = [axis for axis in sizes if axis in "ZYX"]
    if len(space) < 2:
        raise UnreadableError(f"{name} has the axes {''.join(sizes)}: save one volume or plane of it.")
    known = dict(zip(("col", "row", "plane"), reversed(space), strict=False))
    known |= {role: axis for role, axis in (("time", "T"), ("channel", "C"), ("color", "S")) if axis in sizes}
    for axis in (axis for axis, length in sizes.items() if axis not in known.values() and length > 1):
        free = next((role for role in ("channel", "time") if role not in known), None)
        if free is None:
            raise UnreadableError(f"{name} has the axes {''.join(sizes)}: save one volume or plane of it.")
        known[free] = axis
    given = {axis: role for role, axis in known.items()}
    return {given[axis]: axis for axis in sizes if axis in given}
