"""Surfaces in the coordinates of files: positions (x, y, z) of a patient, in a unit of length.

These are LPS by default, as in ITK: x increases to the patient's left, y to the back and z to the head; or RAS, where x
increases to the right and y to the front. A volume of unknown position begins at zero, with its columns along x, its
rows along y and its planes along z of LPS, like the label volume of the same result (`formats/masks/nifti.py`). Files
state ``SPACE=LPS`` or ``SPACE=RAS``, as in 3D Slicer.
"""

from __future__ import annotations

import math
import re
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.formats.common.provenance import PROGRAM_NAME, Outcome, describe_provenance, dump_provenance
from cpm_core.formats.images.resolution import ascii_unit, conversion_factor, find_unit
from cpm_core.image.geometry import Convention, Geometry
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array, Sides, Single, Texts, frozen
from cpm_core.parameters import DEFAULT_VALUES

_POSITION_TOLERANCE = 1e-3
"""Largest rounding error of a position in a file [smallest side of a voxel]."""

_SPACE_PATTERN = re.compile(r"\bSPACE\s*[=:]\s*(LPS|RAS)\b")
"""Statement of a file on the directions of x, y and z."""

_UNIT_PATTERN = re.compile(r"\bUNIT\s*[=:]\s*([^\s;]+)")
"""Statement of a file on its unit."""


class ExportMesh(NamedTuple):
    """A surface in the coordinates of files.

    Attributes
    ----------
    points : ndarray of float32 or float64, shape (N, 3)
        Positions (x, y, z); float64 if single precision is too coarse so far from zero.
    normals : ndarray of float32, shape (N, 3)
        Outward unit normals.
    faces : ndarray of int32, shape (F, 3)
        Corners, counterclockwise as seen from outside.
    notes : tuple of str
        Lines of ASCII: program, coordinates, unit, and provenance.
    title : str
        The same in short, for files with little room: with the hash of the image, and the parameters that differ from
        the defaults.
    numbers : ndarray of int32, shape (F,), or None
        Number of the object that each triangle bounds, if objects are numbered.
    decimals : int
        Decimals needed to write positions as text.
    """

    points: NDArray[np.floating]
    normals: Single
    faces: NDArray[np.int32]
    notes: Texts
    title: str
    numbers: NDArray[np.int32] | None
    decimals: int


def build_mesh(result: Outcome, space: Convention = "LPS") -> ExportMesh:
    """Build the mesh of a result in LPS or RAS; ValueError when it has no surface."""
    surface = result.surface
    if surface is None or not len(surface.faces):
        raise ValueError(f"{result.source} has no surface: only runs on volumes find one.")
    facts = describe_provenance(result)
    notes = PROGRAM_NAME, f"SPACE={space}", f"UNIT={ascii_unit(surface.unit, 'voxel')}", dump_provenance(facts)
    image, parameters = facts["image"], facts.get("parameters", {})
    known = {"IMAGE": image.get("sha256", image.get("array_sha256", "")), "METHOD": facts.get("method", "")}
    known |= {name: value for name, value in parameters.items() if DEFAULT_VALUES.get(name) != value}
    title = [*notes[:3], *(f"{name}={value}" for name, value in known.items() if value != "")]
    matrix = (result.geometry or Geometry()).affine(surface.spacing, space)[:3, :3]
    # the inverse transpose keeps normals perpendicular under shear; a mirrored volume reverses the orientation of faces
    turned = (surface.normals * surface.spacing) @ np.linalg.inv(matrix)
    lengths = np.linalg.norm(turned, axis=1, keepdims=True)
    faces = surface.faces if np.linalg.det(matrix) > 0.0 else surface.faces[:, ::-1]
    points = to_file_coordinates(surface.vertices, surface.spacing, result.geometry, space)
    coarse = np.abs(points).max() * np.finfo(np.float32).eps > _POSITION_TOLERANCE * min(surface.spacing)
    return ExportMesh(
        points if coarse else points.astype(np.float32),
        (turned / np.where(lengths > 0.0, lengths, 1.0)).astype(np.float32),
        faces.astype(np.int32),
        notes,
        " ".join(title),
        None if surface.numbers is None else surface.numbers.astype(np.int32),
        count_decimals(surface.spacing),
    )


def count_decimals(spacing: Sides) -> int:
    """Return the number of decimals that place a vertex to less than a thousandth of a voxel."""
    return max(0, math.ceil(-math.log10(_POSITION_TOLERANCE * min(spacing))))


def to_file_coordinates(places: Array, spacing: Sides, geometry: Geometry | None, space: Convention = "LPS") -> Array:
    """Convert positions in voxels to the coordinates of files.

    Parameters
    ----------
    places : ndarray, shape (N, 3)
        Positions (plane, row, col) [voxels].
    spacing : tuple of float
        Size of a voxel along (plane, row, col).
    geometry : Geometry or None
        Position of the volume.
    space : {"LPS", "RAS"}
        Directions of x, y and z.

    Returns
    -------
    ndarray, shape (N, 3)
        Positions (x, y, z) in the unit of `spacing`.
    """
    matrix = (geometry or Geometry()).affine(spacing, space)
    return places @ matrix[:3, :3].T + matrix[:3, 3]


@frozen
class VoxelTransform:
    """Transformation between positions of a file and voxels.

    Attributes
    ----------
    spacing : tuple of float
        Size of a voxel along (plane, row, col).
    unit : str or None
        Its unit.
    matrix : ndarray, shape (4, 4)
        From voxels (plane, row, col, 1) to positions (x, y, z, 1), in the unit of the file.
    scale : float
        Units of `spacing` per unit of the file.
    """

    spacing: Sides
    unit: str | None
    matrix: Array
    scale: float

    @property
    def is_mirrored(self) -> bool:
        """Whether a triangle that is counterclockwise in the file is clockwise in voxels."""
        return bool(np.linalg.det(self.matrix[:3, :3]) < 0.0)

    def to_voxels(self, positions: Array) -> Array:
        """Convert positions (x, y, z), shape (N, 3), to (plane, row, col) [voxels]."""
        return np.asarray(np.linalg.solve(self.matrix[:3, :3], (positions - self.matrix[:3, 3]).T).T)


def find_voxel_transform(head: str, image: Image | None, space: Convention | None) -> tuple[VoxelTransform, Texts]:
    """Find the transformation from positions of a file to voxels, and list what was assumed.

    `head` is the beginning of the file; `space` overrides its statement on LPS and RAS. Without a volume, voxel sides
    are one unit of the file.
    """
    notes = []
    if space is None:
        if named := _SPACE_PATTERN.search(head):
            space = "LPS" if named[1] == "LPS" else "RAS"
        else:
            notes.append("It does not state where x, y and z point: LPS is taken; the other choice is RAS.")
    named = _UNIT_PATTERN.search(head)
    unit = find_unit(named[1]) if named else None
    spacing: Sides = (1.0, 1.0, 1.0)
    geometry, own = Geometry(), unit
    if image is not None:
        if len(image.shape) != 3:
            raise ValueError(
                f"{image.source} is no volume, but surfaces and center lines lie in volumes: open a volume."
            )
        spacing, geometry, own = image.spacing, image.geometry or geometry, image.unit
    length = find_unit(own) if own else None
    scale = 1.0
    if unit is not None and length is not None:
        scale = conversion_factor(unit, length)
    elif image is not None and length is not None:
        notes.append(f"It does not state its unit of length: {own}, that of the volume, is taken.")
    matrix = geometry.scaled(1.0 / scale).affine(tuple(side / scale for side in spacing), space or "LPS")
    return VoxelTransform(spacing, own, matrix, scale), tuple(notes)
