"""NRRD: volumes of 3D Slicer and others, whose header pynrrd reads."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.formats.common.printable import printable
from cpm_core.formats.images import resolution
from cpm_core.formats.images.choice import FIRST, Choice
from cpm_core.formats.images.decoded import Decoded, UnreadableError, from_samples
from cpm_core.formats.images.medical.content import Packing, beside, values_of
from cpm_core.formats.images.stacks.stack import Stack, as_planes, plane_of
from cpm_core.image.geometry import Convention, Geometry, from_affine
from cpm_core.parameters.quotation import shown

FORMAT = "NRRD"
READS = {".nrrd": "NRRD volume", ".nhdr": "NRRD volume of two files"}

_MAGIC = b"NRRD000"
_PACKINGS: dict[str, Packing] = {"raw": "raw", "gzip": "deflate", "gz": "deflate", "bzip2": "bzip2", "bz2": "bzip2"}
_TEXT = ("ascii", "text", "txt")
_IN_SPACE, _COLORS, _TIME = ("domain", "space"), ("rgb-color", "rgba-color"), "time"
_SPACES: dict[str, tuple[Convention, tuple[float, float, float]]] = {
    "left-posterior-superior": ("LPS", (1.0, 1.0, 1.0)),
    "lps": ("LPS", (1.0, 1.0, 1.0)),
    "right-anterior-superior": ("RAS", (1.0, 1.0, 1.0)),
    "ras": ("RAS", (1.0, 1.0, 1.0)),
    "left-anterior-superior": ("LPS", (1.0, -1.0, 1.0)),
    "las": ("LPS", (1.0, -1.0, 1.0)),
}
"""Coordinates of a patient -> those that they are taken as, and what turns around for that."""


def reads(head: bytes, _path: Path) -> bool:
    """Whether the first bytes of a file are those of an NRRD volume."""
    return head.startswith(_MAGIC)


def read(path: Path, choice: Choice = FIRST) -> Decoded:
    """Read one plane of a volume; see `plane_of`."""
    return plane_of(stack(path, choice), choice)


def stack(path: Path, _choice: Choice = FIRST) -> Stack:
    """Open a volume; its columns are the first axis of the file that lies in space, its planes the third.

    Raises
    ------
    UnreadableError
        When the axes are not those of volumes.
    """
    name = printable(path.name)
    import nrrd  # only here, because it takes long to import

    with path.open("rb") as stream:
        header = nrrd.read_header(stream)
        begin = stream.tell()
    sizes = [int(size) for size in header["sizes"]]
    if min(sizes) < 1 or len(sizes) != int(header["dimension"]):
        raise ValueError("the axes are not valid")
    roles = _roles(header, sizes, name)
    kind = np.dtype(nrrd.reader._TYPEMAP_NRRD2NUMPY[header["type"]])
    kind = kind.newbyteorder(">" if header.get("endian") == "big" else "<")
    stored = _Stored(path, begin, header, tuple(sizes[::-1]), kind)
    size = {role: sizes[axis] for role, axis in roles.items()}
    columns, rows, planes = size["col"], size["row"], size.get("plane", 1)
    stored.check()
    spacing, unit, geometry, notes = _place(header, roles)
    order = [roles[role] for role in ("time", "channel", "plane", "row", "col", "color") if role in roles]
    shape = (size.get("time", 1), size.get("channel", 1), planes, rows, columns, size.get("color", 1))

    def take(time: int, channel: int, first: int, end: int) -> Decoded:
        whole = stored.values().T.transpose(order).reshape(shape)
        part = np.array(whole[time, channel, first:end])
        if shape[-1] == 1:
            return Decoded(part[..., 0])
        samples = part.reshape(-1, columns, shape[-1])
        found = from_samples(samples[..., :3], samples[..., 3] if shape[-1] == 4 else None)
        return as_planes(found, (end - first, rows, columns))

    return Stack(
        name,
        (planes, rows, columns),
        take,
        float(kind.itemsize * shape[-1]),
        shape[0],
        shape[1],
        spacing,
        unit,
        geometry,
        notes=notes,
        otherwise=planes // 2,
    )


class _Stored(NamedTuple):
    """The values of a file behind or beside a header: shape with the slowest axis first, and type."""

    path: Path
    begin: int
    header: Any
    shape: tuple[int, ...]
    kind: np.dtype[Any]

    def check(self) -> None:
        """Raise an error when there are fewer values than there should be, as far as that is known unpacked."""
        if _PACKINGS.get(str(self.header["encoding"]).lower()) == "raw":
            self.values()
        elif self.path.stat().st_size < 2 or math.prod(self.shape) < 1:
            raise ValueError("there are no values")

    def values(self) -> NDArray[Any]:
        """Read them, or those of a file that is not packed where they are used."""
        header, encoding = self.header, str(self.header["encoding"]).lower()
        named = header.get("data file", header.get("datafile"))
        file, offset = self.path, self.begin
        if named is not None:
            if str(named).split()[0].upper() == "LIST" or "%" in str(named):
                raise UnreadableError(
                    f"{file.name} keeps its planes in files of their own: save it as one file, .nrrd."
                )
            file, offset = beside(file, str(named)), 0
        skipped = int(header.get("byte skip", header.get("byteskip", 0)))
        if int(header.get("line skip", header.get("lineskip", 0))) or (skipped and encoding not in ("raw",)):
            raise UnreadableError(
                f"{self.path.name} skips a part of {shown(file.name)}, which is not read: save it again."
            )
        if encoding in _TEXT:
            with file.open("rb") as stream:
                stream.seek(offset)
                text = np.array(stream.read().split(), dtype=self.kind)
            return text.reshape(self.shape)
        if encoding not in _PACKINGS:
            raise UnreadableError(
                f"{self.path.name} is packed as {shown(encoding)}, which is not read: save it as gzip."
            )
        return values_of(file, skipped if skipped < 0 else offset + skipped, self.shape, self.kind, _PACKINGS[encoding])


def _roles(header: Any, sizes: list[int], name: str) -> dict[str, int]:
    """Which axis of the file is which of ours; the axes that lie in space are columns, rows, planes in this order."""
    kinds = [str(kind).lower() for kind in header.get("kinds", ["???"] * len(sizes))]
    vectors = header.get("space directions")
    if vectors is not None:
        in_space = [vector is not None and bool(np.isfinite(vector).all()) for vector in vectors]
    elif any(kind in _IN_SPACE for kind in kinds):
        in_space = [kind in _IN_SPACE for kind in kinds]
    else:
        named = [kind == _TIME or kind in _COLORS or kind.endswith(("list", "vector")) for kind in kinds]
        in_space = [not other and sum(not o for o in named[:axis]) < 3 for axis, other in enumerate(named)]
    if sum(in_space) == 4 and in_space[-1]:  # ITK writes times as a fourth axis of space
        in_space[-1], kinds[-1] = False, _TIME
    roles = dict(zip(("col", "row", "plane"), [axis for axis, lies in enumerate(in_space) if lies], strict=False))
    for axis, lies in enumerate(in_space):
        if lies:
            continue
        color = kinds[axis] in _COLORS and sizes[axis] in (3, 4)
        last = axis == len(sizes) - 1 and kinds[axis] == "???"
        role = "color" if color else "time" if kinds[axis] == _TIME or last else "channel"
        if role in roles:
            role = next((other for other in ("channel", "time") if other not in roles), role)
        if role in roles:
            raise UnreadableError(f"{name} has the axes {shown(tuple(sizes))}: save one volume of it.")
        roles[role] = axis
    if "row" not in roles or sum(in_space) > 3 or len(in_space) != len(sizes):
        raise UnreadableError(f"{name} has {sum(in_space)} axes in space, but a volume has two or three.")
    return roles


def _place(
    header: Any, roles: dict[str, int]
) -> tuple[tuple[float, float, float], str | None, Geometry | None, tuple[str, ...]]:
    """Size of a voxel, its unit, and where the volume lies, where the file tells."""
    axes = [roles[role] for role in ("col", "row", "plane") if role in roles]
    space = str(header.get("space", "")).lower().removesuffix("-time")
    units = header.get("space units", [])
    unit = next((found for found in map(resolution.known_unit, map(str, units)) if found), None)
    vectors = header.get("space directions")
    if vectors is None:
        told = header.get("spacings", [math.nan] * len(header["sizes"]))
        sides = [abs(float(told[axis])) for axis in axes] + [1.0]
        if not all(math.isfinite(side) and side > 0.0 for side in sides):
            return (1.0, 1.0, 1.0), None, None, ()
        own = [str(name) for name in header.get("units", [])]
        unit = next(
            (found for found in (resolution.known_unit(own[axis]) for axis in axes if axis < len(own)) if found), unit
        )
        return (sides[2], sides[1], sides[0]), unit, None, ()
    along = np.array([vectors[axis] for axis in axes], float)[:, :3]
    if along.shape != (3, 3):
        lengths = [*np.linalg.norm(along, axis=1).tolist(), 1.0]
        return (lengths[2], lengths[1], lengths[0]), unit, None, ()
    origin = np.array(header.get("space origin", np.zeros(3)), float)[:3]
    convention, turned = _SPACES.get(space, ("LPS", (1.0, 1.0, 1.0)))
    affine = np.eye(4)
    affine[:3, :3], affine[:3, 3] = along.T, origin
    affine[:3] *= np.array(turned)[:, None]
    try:
        geometry, spacing = from_affine(affine, convention)
    except ValueError:
        return (1.0, 1.0, 1.0), None, None, ("Its matrix is not valid, so that it is not known where it lies.",)
    if space in _SPACES:
        return spacing, unit or "mm", geometry, ()
    return spacing, unit, None, ()
