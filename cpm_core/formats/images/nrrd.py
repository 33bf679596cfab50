"""NRRD: volumes of 3D Slicer and other programs, read by pynrrd."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.formats.common.content import UnreadableError
from cpm_core.formats.common.printable import make_printable
from cpm_core.formats.images import resolution
from cpm_core.formats.images.decoded import DecodedImage, decode_bands
from cpm_core.formats.images.reading import Reading
from cpm_core.formats.images.stack import (
    Stack,
    VolumePosition,
    check_memory,
    decode_header_line,
    find_data_file,
    position_from_affine,
)
from cpm_core.numerics.types import Array, Numbers
from cpm_core.parameters.formatting import quote_value

FILE_KINDS = {".nrrd": "NRRD volume", ".nhdr": "NRRD volume of two files"}

_AXIS_ROLES = ("time", "channel", "plane", "row", "col", "color")
"""Roles that an axis of a file may have, in our order."""

_SPACE_KINDS = ("domain", "space")
"""Kinds of spatial axes."""

_COLOR_KINDS = ("rgb-color", "rgba-color")
"""Kinds of color axes."""

_TIME_KIND = "time"
"""Kind of the axis of time."""

_SPACE_CONVENTIONS = {
    "left-posterior-superior": "LPS",
    "right-anterior-superior": "RAS",
    "left-anterior-superior": "LAS",
}
"""Names of spaces -> their conventions."""


def can_read(head: bytes, _path: Path) -> bool:
    """Return whether a file begins like an NRRD volume."""
    return head.startswith(b"NRRD000")


def open_image_file(path: Path, _reading: Reading) -> Stack:
    """Open a volume: the spatial axes of the file are columns, rows and planes."""
    import nrrd  # only here, because it takes long to import

    name = make_printable(path.name)
    with path.open("rb") as stream:
        header = nrrd.read_header(map(decode_header_line, iter(stream.readline, b"")))  # pynrrd makes m of µm
        begin = stream.tell()
    itemsize = np.dtype(nrrd.reader._TYPEMAP_NRRD2NUMPY[header["type"]]).itemsize
    named = next((key for key in ("data file", "datafile") if key in header), None)
    if named is not None:
        header[named] = str(find_data_file(path, str(header[named])).absolute())  # pynrrd seeks others by the header

    def read_values() -> Numbers:
        check_memory(tuple(map(int, header["sizes"])), itemsize, name)
        with path.open("rb") as stream:
            stream.seek(begin)
            return np.asarray(nrrd.read_data(header, stream, str(path)))

    return build_stack(name, header, itemsize, read_values)


def build_stack(name: str, header: Any, itemsize: int, read_values: Callable[[], Numbers]) -> Stack:
    """Build a stack from a header of NRRD; `read_values` reads all, of shape ``sizes``, each of `itemsize` bytes.

    Raises
    ------
    UnreadableError
        When the axes are not those of volumes.
    """
    sizes = [int(size) for size in header["sizes"]]
    if min(sizes) < 1:
        raise ValueError("the axes are not valid")
    roles = _assign_roles(header, sizes, name)
    spacing, unit, geometry, notes = _parse_position(header, roles)
    size = {role: sizes[axis] for role, axis in roles.items()}
    shape = tuple(size.get(role, 1) for role in _AXIS_ROLES)
    order = [roles[role] for role in _AXIS_ROLES if role in roles]

    def read_planes(time: int, channel: int, first: int, end: int) -> DecodedImage:
        part = np.array(read_values().transpose(order).reshape(shape)[time, channel, first:end])
        return DecodedImage(part[..., 0]) if shape[-1] == 1 else decode_bands(part)

    return Stack(
        name,
        (shape[2], shape[3], shape[4]),
        read_planes,
        float(itemsize * shape[-1]),
        shape[0],
        shape[1],
        spacing,
        unit,
        geometry,
        notes=notes,
    )


def _assign_roles(header: Any, sizes: list[int], name: str) -> dict[str, int]:
    """Assign roles to the axes of a file; spatial axes are columns, rows and planes, in this order."""
    kinds = [str(kind).lower() for kind in header.get("kinds", ["???"] * len(sizes))]
    vectors = header.get("space directions")
    if vectors is not None:
        in_space = [vector is not None and bool(np.isfinite(vector).all()) for vector in vectors]
    elif any(kind in _SPACE_KINDS for kind in kinds):
        in_space = [kind in _SPACE_KINDS for kind in kinds]
    else:
        named = [kind == _TIME_KIND or kind in _COLOR_KINDS or kind.endswith(("list", "vector")) for kind in kinds]
        in_space = [not other and sum(not o for o in named[:axis]) < 3 for axis, other in enumerate(named)]
    if sum(in_space) == 4 and in_space[-1]:  # ITK writes time as a fourth spatial axis
        in_space[-1], kinds[-1] = False, _TIME_KIND
    if not 2 <= sum(in_space) <= 3 or len(in_space) != len(sizes):
        raise UnreadableError(f"{name} has {sum(in_space)} axes in space, but a volume has two or three.")
    roles = dict(zip(("col", "row", "plane"), [axis for axis, lies in enumerate(in_space) if lies], strict=False))
    for axis in (axis for axis, lies in enumerate(in_space) if not lies):
        color = kinds[axis] in _COLOR_KINDS and sizes[axis] in (3, 4)
        last = axis == len(sizes) - 1 and kinds[axis] == "???"
        wanted = "color" if color else "time" if kinds[axis] == _TIME_KIND or last else "channel"
        role = next((one for one in (wanted, "channel", "time") if one not in roles), None)
        if role is None:
            raise UnreadableError(f"{name} has the axes {quote_value(tuple(sizes))}: save one volume of it.")
        roles[role] = axis
    return roles


def _parse_position(header: Any, roles: dict[str, int]) -> VolumePosition:
    """Parse voxel size and position from a header."""
    axes = [roles[role] for role in ("plane", "row", "col") if role in roles]
    vectors, world = header.get("space directions"), [*map(str, header.get("space units", [])), "", "", ""][:3]
    if vectors is None:
        given, own = header.get("spacings", [math.nan] * len(header["sizes"])), header.get("units", [])
        units = [str(own[axis]) if axis < len(own) else world[-1] for axis in axes]
        sides, unit = resolution.spacing_from_sizes([abs(float(given[axis])) for axis in axes], units)
    else:
        scale, unit = resolution.spacing_from_sizes((1.0, 1.0, 1.0), world)
        along: Array = np.array([vectors[axis] for axis in axes], float)[:, :3] * scale
        sides = tuple(np.linalg.norm(along, axis=1).tolist())
    if not all(math.isfinite(side) and side > 0.0 for side in sides):
        return (1.0, 1.0, 1.0), None, None, ()
    plane, row, col = (1.0, *sides)[-3:]
    space = str(header.get("space", "")).lower().removesuffix("-time")
    space = _SPACE_CONVENTIONS.get(space, space.upper())
    if vectors is None or along.shape != (3, 3) or space not in _SPACE_CONVENTIONS.values():
        return (plane, row, col), unit, None, ()
    affine = np.eye(4)
    affine[:3, :3] = along[::-1].T
    affine[:3, 3] = np.array(header.get("space origin", np.zeros(3)), float)[:3] * scale
    if space == "LAS":
        affine[1] *= -1.0
    return position_from_affine(affine, "RAS" if space == "RAS" else "LPS", (plane, row, col), unit or "mm")
