"""Surfaces in the coordinates of files: positions (x, y, z) of a patient, in the unit of the spacing.

These are LPS, as in ITK: x grows to the patient's left, y to the back and z to the head; or RAS by choice, where x
grows to the right and y to the front. A volume whose position is not known begins at zero, with its columns along x,
its rows along y and its planes along z of LPS. The label volume of the same result (`formats/masks/nifti.py`) lies at
the same place. Files say so by ``SPACE=LPS`` or ``SPACE=RAS``, as 3D Slicer does.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.result import Result
from cpm_core.formats.common.printable import printable
from cpm_core.formats.common.provenance import PROGRAM, facts_of, text_of
from cpm_core.image.geometry import Convention, Geometry
from cpm_core.medial_axis.skeleton import Skeleton
from cpm_core.numerics.types import Array
from cpm_core.parameters import DEFAULTS

_FINE = 1e-3
"""How far a position in a file may be from where it is [smallest sides of a voxel]."""


class Mesh(NamedTuple):
    """A surface in the coordinates of files.

    Attributes
    ----------
    points : ndarray of float32 or float64, shape (N, 3)
        Positions (x, y, z); of double precision where a volume is so far from zero that single precision is coarse.
    normals : ndarray of float32, shape (N, 3)
        Unit vectors outward.
    faces : ndarray of int32, shape (F, 3)
        Corners, counter-clockwise as seen from outside.
    notes : tuple of str
        Lines of ASCII: program, coordinates, unit, and how the surface was found.
    origin : str
        The same in few letters, for files with little room: the hash of the image, then what differs from the defaults.
    numbers : ndarray of int32, shape (F,), or None
        Number of the object that each triangle bounds, where objects have their own.
    decimals : int
        Decimals that a text of positions needs.
    """

    points: NDArray[np.floating]
    normals: NDArray[np.float32]
    faces: NDArray[np.int32]
    notes: tuple[str, ...]
    origin: str
    numbers: NDArray[np.int32] | None
    decimals: int


def mesh_of(result: Result | Skeleton, space: Convention = "LPS") -> Mesh:
    """The surface of a result in LPS or RAS; ValueError when it has none."""
    surface = result.surface if isinstance(result, Result) else None
    if surface is None or not len(surface.faces):
        raise ValueError(f"{result.source} has no surface: only runs on volumes find one.")
    unit = {"µm": "um"}.get(surface.unit or "", surface.unit or "voxel")
    facts = facts_of(result)
    notes = (PROGRAM, f"SPACE={space}", f"UNIT={unit}", text_of(facts))
    matrix = (result.geometry or Geometry()).affine(surface.spacing, space)[:3, :3]
    # normals stand on what has been sheared, too; a mirrored volume reverses the sense of rotation
    turned = (surface.normals * surface.spacing) @ np.linalg.inv(matrix)
    lengths = np.linalg.norm(turned, axis=1, keepdims=True)
    faces = surface.faces if np.linalg.det(matrix) > 0.0 else surface.faces[:, ::-1]
    points = positions(surface.vertices, surface.spacing, result.geometry, space)
    coarse = np.abs(points).max() * np.finfo(np.float32).eps > _FINE * min(surface.spacing)
    return Mesh(
        points if coarse else points.astype(np.float32),
        (turned / np.where(lengths > 0.0, lengths, 1.0)).astype(np.float32),
        faces.astype(np.int32),
        tuple(printable(note).encode("ascii", "replace").decode() for note in notes),
        _in_short(facts),
        None if surface.numbers is None else surface.numbers.astype(np.int32),
        decimals_for(surface.spacing),
    )


def _in_short(facts: Mapping[str, Any]) -> str:
    """The hash of the image, the method, and the parameters that are not the default ones."""
    image = facts["image"]
    digits = image.get("sha256", image.get("array_sha256", ""))
    changed = {name: value for name, value in facts.get("parameters", {}).items() if DEFAULTS.get(name) != value}
    told = [*([f"IMAGE={digits}"] if digits else []), f"METHOD={facts.get('method', '')}"]
    return " ".join([*told, *(f"{name}={value}" for name, value in changed.items())])


def decimals_for(spacing: tuple[float, ...]) -> int:
    """How many decimals place a vertex to less than a thousandth of a voxel."""
    return max(0, math.ceil(-math.log10(_FINE * min(spacing))))


def positions(places: Array, spacing: tuple[float, ...], geometry: Geometry | None, space: Convention = "LPS") -> Array:
    """Places (plane, row, col) in voxels as (x, y, z) in LPS or RAS."""
    matrix = (geometry or Geometry()).affine(spacing, space)
    return np.asarray(places @ matrix[:3, :3].T + matrix[:3, 3])
