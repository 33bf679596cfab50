"""Surfaces in the coordinates of files: positions (x, y, z) of a patient, in a unit of length.

These are LPS, as in ITK: x grows to the patient's left, y to the back and z to the head; or RAS by choice, where x
grows to the right and y to the front. A volume whose position is not known begins at zero, with its columns along x,
its rows along y and its planes along z of LPS. The label volume of the same result (`formats/masks/nifti.py`) lies at
the same place. Files say so by ``SPACE=LPS`` or ``SPACE=RAS``, as 3D Slicer does.
"""

from __future__ import annotations

import math
import re
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.result import Result
from cpm_core.formats.common.provenance import PROGRAM, Outcome, facts_of, text_of
from cpm_core.formats.images.resolution import factor, in_ascii, known_unit
from cpm_core.image.geometry import Convention, Geometry
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array, Sides, Single, Texts, frozen
from cpm_core.parameters import DEFAULTS

_FINE = 1e-3
"""How far a position in a file may be from where it is [smallest sides of a voxel]."""

_SPACE = re.compile(r"\bSPACE\s*[=:]\s*(LPS|RAS)\b")
_UNIT = re.compile(r"\bUNIT\s*[=:]\s*([^\s;]+)")


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
    title : str
        The same in few letters, for files with little room: with the hash of the image, and the parameters that differ
        from the defaults.
    numbers : ndarray of int32, shape (F,), or None
        Number of the object that each triangle bounds, where objects have their own.
    decimals : int
        Decimals that a text of positions needs.
    """

    points: NDArray[np.floating]
    normals: Single
    faces: NDArray[np.int32]
    notes: Texts
    title: str
    numbers: NDArray[np.int32] | None
    decimals: int


def mesh_of(result: Outcome, space: Convention = "LPS") -> Mesh:
    """The surface of a result in LPS or RAS; ValueError when it has none."""
    surface = result.surface if isinstance(result, Result) else None
    if surface is None or not len(surface.faces):
        raise ValueError(f"{result.source} has no surface: only runs on volumes find one.")
    facts = facts_of(result)
    notes = PROGRAM, f"SPACE={space}", f"UNIT={in_ascii(surface.unit, 'voxel')}", text_of(facts)
    image, parameters = facts["image"], facts.get("parameters", {})
    known = {"IMAGE": image.get("sha256", image.get("array_sha256", "")), "METHOD": facts.get("method", "")}
    known |= {name: value for name, value in parameters.items() if DEFAULTS.get(name) != value}
    title = [*notes[:3], *(f"{name}={value}" for name, value in known.items() if value != "")]
    matrix = (result.geometry or Geometry()).affine(surface.spacing, space)[:3, :3]
    # normals stay normal to what has been sheared, too; a mirrored volume reverses the sense of rotation
    turned = (surface.normals * surface.spacing) @ np.linalg.inv(matrix)
    lengths = np.linalg.norm(turned, axis=1, keepdims=True)
    faces = surface.faces if np.linalg.det(matrix) > 0.0 else surface.faces[:, ::-1]
    points = positions(surface.vertices, surface.spacing, result.geometry, space)
    coarse = np.abs(points).max() * np.finfo(np.float32).eps > _FINE * min(surface.spacing)
    return Mesh(
        points if coarse else points.astype(np.float32),
        (turned / np.where(lengths > 0.0, lengths, 1.0)).astype(np.float32),
        faces.astype(np.int32),
        notes,
        " ".join(title),
        None if surface.numbers is None else surface.numbers.astype(np.int32),
        decimals_for(surface.spacing),
    )


def decimals_for(spacing: Sides) -> int:
    """How many decimals place a vertex to less than a thousandth of a voxel."""
    return max(0, math.ceil(-math.log10(_FINE * min(spacing))))


def positions(places: Array, spacing: Sides, geometry: Geometry | None, space: Convention = "LPS") -> Array:
    """Places (plane, row, col) in voxels as (x, y, z) in LPS or RAS."""
    matrix = (geometry or Geometry()).affine(spacing, space)
    return places @ matrix[:3, :3].T + matrix[:3, 3]


@frozen
class Place:
    """How positions of a file become voxels.

    Attributes
    ----------
    spacing : tuple of float
        Size of a voxel along (plane, row, col).
    unit : str or None
        Its unit.
    matrix : ndarray, shape (4, 4)
        From voxels (plane, row, col, 1) to positions (x, y, z, 1), in the unit of the file.
    scale : float
        How many units of `spacing` one unit of the file is.
    """

    spacing: Sides
    unit: str | None
    matrix: Array
    scale: float

    @property
    def mirrored(self) -> bool:
        """Whether a triangle that turns to the left in the file turns to the right in voxels."""
        return bool(np.linalg.det(self.matrix[:3, :3]) < 0.0)

    def voxels(self, positions: Array) -> Array:
        """Positions (x, y, z) as places (plane, row, col) [voxels]."""
        return np.asarray(np.linalg.solve(self.matrix[:3, :3], (positions - self.matrix[:3, 3]).T).T)


def place_of(head: str, image: Image | None, space: Convention | None) -> tuple[Place, Texts]:
    """How positions of a file become voxels, by the beginning of the file and by the volume, and what was assumed.

    What the file says of LPS and RAS is overruled by `space`. Without a volume voxels have sides of one unit of the
    file.
    """
    notes = []
    if space is None:
        if named := _SPACE.search(head):
            space = "LPS" if named[1] == "LPS" else "RAS"
        else:
            notes.append("It does not state where x, y and z point: LPS is taken; the other choice is RAS.")
    named = _UNIT.search(head)
    unit = known_unit(named[1]) if named else None
    spacing: Sides = (1.0, 1.0, 1.0)
    geometry, own = Geometry(), unit
    if image is not None:
        if len(image.shape) != 3:
            raise ValueError(
                f"{image.source} is no volume, but surfaces and center lines lie in volumes: open a volume."
            )
        spacing, geometry, own = image.spacing, image.geometry or geometry, image.unit
    length = known_unit(own) if own else None
    scale = 1.0
    if unit is not None and length is not None:
        scale = factor(unit, length)
    elif image is not None and length is not None:
        notes.append(f"It does not state its unit of length: {own}, that of the volume, is taken.")
    matrix = geometry.scaled(1.0 / scale).affine(tuple(side / scale for side in spacing), space or "LPS")
    return Place(spacing, own, matrix, scale), tuple(notes)
