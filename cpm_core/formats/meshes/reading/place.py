"""Where the vertices of files lie in a volume: from (x, y, z) in LPS or RAS, in a unit, to voxels."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from cpm_core.formats.images.resolution import factor, known_unit
from cpm_core.image.geometry import Convention, Geometry
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array

_SPACE = re.compile(r"\bSPACE\s*[=:]\s*(LPS|RAS)\b")
_UNIT = re.compile(r"\bUNIT\s*[=:]\s*([^\s;]+)")


@dataclass(frozen=True)
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

    spacing: tuple[float, ...]
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


def place_of(remarks: str, image: Image | None, space: Convention | None) -> tuple[Place, tuple[str, ...]]:
    """How positions of a file become voxels, by what the file remarks and by the volume, and what was assumed.

    What the file says of LPS and RAS is overruled by `space`. Without a volume voxels have sides of one unit of the
    file.
    """
    notes = []
    told = _SPACE.search(remarks)
    known: Convention | None = space or (None if told is None else "LPS" if told[1] == "LPS" else "RAS")
    if known is None:
        notes.append("It does not tell where x, y and z point: LPS is taken; the other choice is RAS.")
    named = _UNIT.search(remarks)
    unit = None if named is None else known_unit(named[1])
    spacing, geometry, own = ((1.0, 1.0, 1.0), None, unit) if image is None else _of_volume(image)
    length = None if own is None else known_unit(own)
    scale = 1.0
    if unit is not None and length is not None:
        scale = factor(unit, length)
    elif image is not None and length is not None:
        notes.append(f"It does not tell its unit of length: {own}, that of the volume, is taken.")
    matrix = (
        (geometry or Geometry()).scaled(1.0 / scale).affine(tuple(side / scale for side in spacing), known or "LPS")
    )
    return Place(spacing, own, matrix, scale), tuple(notes)


def _of_volume(image: Image) -> tuple[tuple[float, ...], Geometry | None, str | None]:
    if len(image.shape) != 3:
        raise ValueError(f"{image.source} is no volume, but surfaces and center lines lie in volumes: open a volume.")
    return image.spacing, image.geometry, image.unit
