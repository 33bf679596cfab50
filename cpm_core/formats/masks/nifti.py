"""NIfTI: the label mask for ITK-SNAP and other programs of radiology."""

from __future__ import annotations

import gzip
import struct

import numpy as np
import scipy

from cpm_core.contours.result import Result
from cpm_core.formats.common.provenance import PROGRAM, facts_of, text_of
from cpm_core.formats.masks.labels import labels_of
from cpm_core.image.geometry import Geometry
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.numerics.types import Array

_HEADER, _BEGINNING, _STEP = 348, 352, 16
_COMMENT = 6
"""Kind of an extension that is a text."""
_DATATYPES = {np.dtype(np.uint16): (512, 16), np.dtype(np.uint32): (768, 32)}
_UNKNOWN, _METER, _MILLIMETER, _MICROMETER = 0, 1, 2, 3
_UNITS = {
    "nm": (_MICROMETER, 1e-3),
    "µm": (_MICROMETER, 1.0),
    "mm": (_MILLIMETER, 1.0),
    "cm": (_MILLIMETER, 10.0),
    "m": (_METER, 1.0),
}
_SCANNER = 1
_SQUARE = 0.05
"""How far axes may be from right angles for a rotation to tell their directions [degrees]."""


def encode(result: Result | Skeleton, *, outlines: bool = False) -> bytes:
    """Make a NIfTI-1 file, columns first, from the label mask of a result or a skeleton: one slice, or a volume.

    It lies where its image lies, voxel upon voxel. Where that is not known columns run to the patient's left, rows to
    the back and planes to the head, as in a picture that is opened without a position, so that mask and picture
    coincide. Micrometers, millimeters and meters are kept, other units converted to the nearest of them. How the labels
    were found is a comment behind the header. ValueError when there is nothing to paint.
    """
    mask = labels_of(result, outlines=outlines)
    planes, rows, cols = (1, *mask.shape)[-3:]
    code, bits = _DATATYPES[mask.dtype]
    unit, factor = _UNITS.get(result.unit or "", (_UNKNOWN, 1.0))
    geometry = (result.geometry or Geometry(depth=1.0 / factor)).scaled(factor)
    spacing = tuple(size * factor for size in result.spacing)
    affine = geometry.affine(spacing, "RAS")[:3, [2, 1, 0, 3]]  # columns first
    turn, *rotation = _rotation(affine[:, :3]) if geometry.slant < _SQUARE else (1.0, 0.0, 0.0, 0.0)
    comment = _comment(text_of(facts_of(result)).encode("ascii"))
    header = struct.pack(
        "<i10s18sihcB8h3f4h8f3fhcB4f2i80s24s2h6f4f4f4f16s4s",
        *(_HEADER, b"", b"", 0, 0, b"r", 0),
        *(3, cols, rows, planes, 1, 1, 1, 1),  # number of axes and their lengths
        *(0.0, 0.0, 0.0, 0, code, bits, 0),
        *(turn, *np.linalg.norm(affine[:, :3], axis=0), 0.0, 0.0, 0.0, 0.0),  # handedness and the size of a voxel
        *(float(_BEGINNING + len(comment)), 1.0, 0.0, 0, b"\0", unit),
        *(0.0, 0.0, 0.0, 0.0, 0, 0),
        *(f"label mask, {PROGRAM}".encode("ascii"), b""),
        *(_SCANNER if geometry.slant < _SQUARE else 0, _SCANNER),
        *(*rotation, *affine[:, 3]),
        *affine.ravel(),
        *(b"", b"n+1\0"),
    )
    extended = struct.pack("<4B", 1, 0, 0, 0)
    return header + extended + comment + mask.astype(mask.dtype.newbyteorder("<")).tobytes()


def _rotation(columns: Array) -> tuple[float, float, float, float]:
    """Sense of three axes at right angles, and the parts b, c and d of the quaternion of their rotation."""
    unit = columns / np.linalg.norm(columns, axis=0)
    turn = 1.0 if np.linalg.det(unit) > 0.0 else -1.0
    b, c, d, _ = scipy.spatial.transform.Rotation.from_matrix(unit * (1.0, 1.0, turn)).as_quat(canonical=True).tolist()
    return turn, b, c, d


def _comment(text: bytes) -> bytes:
    """A text as an extension of the header, filled with zeros to a multiple of 16 bytes."""
    size = -(-(8 + len(text)) // _STEP) * _STEP
    return struct.pack("<2i", size, _COMMENT) + text.ljust(size - 8, b"\0")


def encode_packed(result: Result | Skeleton, *, outlines: bool = False) -> bytes:
    """Compress what `encode` makes; the same result always gives the same bytes."""
    return gzip.compress(encode(result, outlines=outlines), mtime=0)
