"""Surfaces in the coordinates of files: (x, y, z) = (col, row, plane), in the unit of the spacing.

These are LPS, as in ITK: columns run to the patient's left, rows to the back and planes to the head. The label volume
of the same result (`formats/masks/nifti.py`) lies at the same place. Files say so by ``SPACE=LPS``, as 3D Slicer does.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.result import Result
from cpm_core.formats.printable import printable
from cpm_core.formats.provenance import PROGRAM, facts_of, text_of
from cpm_core.medial_axis.skeleton import Skeleton

SPACE = "SPACE=LPS"


class Mesh(NamedTuple):
    """A surface in the coordinates of files.

    Attributes
    ----------
    points, normals : ndarray of float32, shape (N, 3)
        Positions (x, y, z), and unit vectors outward.
    faces : ndarray of int32, shape (F, 3)
        Corners, counter-clockwise as seen from outside.
    notes : tuple of str
        Lines of ASCII: program, coordinates, unit, and how the surface was found.
    """

    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    faces: NDArray[np.int32]
    notes: tuple[str, ...]


def mesh_of(result: Result | Skeleton) -> Mesh:
    """The surface of a result; ValueError when it has none."""
    surface = result.surface if isinstance(result, Result) else None
    if surface is None or not len(surface.faces):
        raise ValueError(f"{result.source} has no surface: only runs on volumes find one.")
    unit = {"µm": "um"}.get(surface.unit or "", surface.unit or "voxel")
    notes = (PROGRAM, SPACE, f"UNIT={unit}", text_of(facts_of(result)))
    return Mesh(
        (surface.vertices * surface.spacing)[:, ::-1].astype(np.float32),
        surface.normals[:, ::-1].astype(np.float32),
        surface.faces[:, ::-1].astype(np.int32),  # the order of the axes is reversed, and with it the sense of rotation
        tuple(printable(note).encode("ascii", "replace").decode() for note in notes),
    )
