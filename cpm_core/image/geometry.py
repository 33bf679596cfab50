"""Geometry: the position of pixels or voxels in space, as medical files give it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.numerics.real_numbers import as_real_array, check_finite_number
from cpm_core.numerics.types import Array, Sides, frozen
from cpm_core.parameters.formatting import format_repr, quote_value

Convention = Literal["LPS", "RAS"]
"""Directions of x, y and z: to the Left, Posterior (back) and Superior (head) of a patient, or Right, Anterior and
Superior."""

CONVENTIONS = ("LPS", "RAS")

Triple = tuple[float, float, float]

Matrix = tuple[tuple[float, ...], ...]
"""Rows of a matrix."""

SCANNER_CODE = 1
"""Code of NIfTI for positions in the coordinates of the scanner."""

_LPS_TO_RAS = np.array([-1.0, -1.0, 1.0])
"""Signs that turn coordinates of one convention into those of the other."""

_COPLANAR_VOLUME = 1e-6
"""Volume spanned by three unit vectors under which they count as coplanar."""

_MIN_LEADING = 0.1
"""Component of an axis from which it leads to a direction, about 6 degrees."""

_PATIENT_DIRECTIONS = (("L", "R"), ("P", "A"), ("S", "I"))
"""Patient directions in which each coordinate of LPS grows and falls."""


@frozen
class Geometry:
    """Position and orientation of an image; the size of a voxel is the image's own, `Image.spacing`.

    The defaults are for a picture: the first pixel at zero, columns to the left, rows to the back and planes to the
    head.

    Attributes
    ----------
    origin : tuple of float
        Position (x, y, z) of the center of the first voxel, in the unit of the image's spacing.
    directions : tuple of tuple of float
        Unit vectors (x, y, z) along the axes (plane, row, col), normalized; the one of the row axis leads from a row
        to the next.
    convention : {"LPS", "RAS"}
        Where x, y and z point, as in the file that it comes from.
    depth : float
        Distance of neighboring planes in the unit of the image's spacing, for an image that is one plane of a volume.
    to_qform : tuple of tuple of float, or None
        Matrix from positions (x, y, z, 1) to those by the qform of a NIfTI, where that differs from its sform, shape
        (4, 4).
    codes : tuple of int
        Codes of a NIfTI for what its sform and its qform refer to; 0 for one that it does not state.

    Raises
    ------
    ValueError
        When these are no finite numbers, or the directions lie in one plane.

    Examples
    --------
    >>> geometry = cpm.Geometry(origin=(10.0, 20.0, 30.0))
    >>> geometry
    <Geometry origin (10, 20, 30) in LPS, axes to S P L>
    >>> geometry.affine((2.0, 0.5, 0.5)).shape, geometry.starting_at((1, 0, 0), (2.0, 0.5, 0.5)).origin
    ((4, 4), (10.0, 20.0, 32.0))
    >>> geometry.scaled(10.0).origin
    (100.0, 200.0, 300.0)
    >>> bool((geometry.qform_affine((2.0, 0.5, 0.5)) == geometry.affine((2.0, 0.5, 0.5))).all())  # else in some NIfTI
    True
    >>> geometry.letters, geometry.ends[0], geometry.oblique, geometry.slant
    (('S', 'P', 'L'), ('I', 'S'), 0.0, 0.0)
    >>> geometry.oblique_ends[0]
    ('I', 'S')
    """

    origin: Triple = (0.0, 0.0, 0.0)
    directions: tuple[Triple, Triple, Triple] = ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
    convention: Convention = "LPS"
    depth: float = 1.0
    to_qform: Matrix | None = None
    codes: tuple[int, int] = (SCANNER_CODE, SCANNER_CODE)

    def __post_init__(self) -> None:
        origin, directions = as_real_array(self.origin), as_real_array(self.directions)
        if origin.shape != (3,) or not np.isfinite(origin).all():
            raise ValueError(f"The origin is {quote_value(self.origin)} but must be three finite numbers, (x, y, z).")
        if directions.shape != (3, 3) or not np.isfinite(directions).all():
            raise ValueError(f"The directions are {quote_value(self.directions)} but must be three vectors (x, y, z).")
        lengths = np.linalg.norm(directions, axis=1)
        if not lengths.all() or abs(np.linalg.det(directions / lengths[:, None])) < _COPLANAR_VOLUME:
            raise ValueError(
                f"The directions are {quote_value(self.directions)} and lie in one plane: give three that do not."
            )
        _check_convention(self.convention)
        check_finite_number("depth", self.depth, lambda depth: depth > 0.0, "a number above 0")
        one = np.abs(lengths - 1.0) < 1e-12  # unit vectors stay equal to the bit
        directions = directions / np.where(one, 1.0, lengths)[:, None]
        object.__setattr__(self, "origin", tuple(origin.tolist()))
        object.__setattr__(self, "directions", tuple(map(tuple, directions.tolist())))

    def affine(self, spacing: Sides, convention: Convention | None = None) -> Array:
        """Return the matrix from voxels (plane, row, col, 1) to positions (x, y, z, 1), shape (4, 4).

        Parameters
        ----------
        spacing : tuple of float
            Size of a voxel along (plane, row, col), or of a pixel along (row, col).
        convention : {"LPS", "RAS"}, optional
            Where x, y and z point; by default as in the file.

        Raises
        ------
        ValueError
            For another convention.
        """
        sides = np.array((self.depth, *spacing)[-3:])
        matrix = np.eye(4)
        matrix[:3, :3] = np.array(self.directions).T * sides
        matrix[:3, 3] = self.origin
        return self._turn(matrix, convention)

    def qform_affine(self, spacing: Sides, convention: Convention | None = None) -> Array:
        """Return the matrix of `affine` by the qform of a NIfTI; the same for all other files."""
        matrix = self.affine(spacing)
        return self._turn(matrix if self.to_qform is None else np.array(self.to_qform) @ matrix, convention)

    def _turn(self, matrix: Array, convention: Convention | None) -> Array:
        """Turn a matrix to positions of a convention, by default the own."""
        if convention is not None:
            _check_convention(convention)
        return matrix if convention in (None, self.convention) else np.r_[_LPS_TO_RAS, 1.0][:, None] * matrix

    def starting_at(self, voxels: ArrayLike, spacing: Sides) -> Geometry:
        """Return the geometry of the part of an image that begins at a voxel (plane, row, col), shape (3,)."""
        matrix = self.affine(spacing)
        x, y, z, _ = (matrix @ np.r_[as_real_array(voxels), 1.0]).tolist()
        return replace(self, origin=(x, y, z))

    def scaled(self, factor: float) -> Geometry:
        """Return the geometry in another unit of length, `factor` of which make one of the present unit."""
        x, y, z = self.origin
        found = replace(self, origin=(factor * x, factor * y, factor * z), depth=factor * self.depth)
        if self.to_qform is None:
            return found
        turn = np.array(self.to_qform)
        turn[:3, 3] *= factor
        return replace(found, to_qform=freeze_matrix(turn))

    @property
    def letters(self) -> tuple[str, str, str]:
        """Patient direction to which each axis (plane, row, col) roughly leads: L, R, P, A, S (head) or I (feet).

        Each axis gets another one. Where two axes are nearest to the same direction, the nearer one gets it.
        """
        from nibabel.orientations import aff2axcodes  # noqa: PLC0415 - needed where an image has a place only

        plane, row, col = aff2axcodes(self.affine((1.0, 1.0, 1.0), "RAS"))
        return plane, row, col

    @property
    def ends(self) -> tuple[tuple[str, str], tuple[str, str], tuple[str, str]]:
        """Letters of the directions at which each axis (plane, row, col) begins and ends."""
        other = {one: end for pair in _PATIENT_DIRECTIONS for one, end in (pair, pair[::-1])}
        plane, row, col = ((other[letter], letter) for letter in self.letters)
        return plane, row, col

    @property
    def oblique_ends(self) -> tuple[tuple[str, str], ...]:
        """All letters of the directions at which each axis begins and ends, the nearest direction first.

        An axis that leads to the head and, by more than 6 degrees, to the back begins at "IA" and ends at "SP".
        """
        found = []
        for along in self.affine((1.0, 1.0, 1.0), "LPS")[:3, :3].T:
            order = [index for index in np.argsort(-np.abs(along)) if abs(along[index]) >= _MIN_LEADING]
            begin, end = ("".join(_PATIENT_DIRECTIONS[index][int((along[index] > 0.0) == first)] for index in order)
                          for first in (True, False))  # fmt: skip
            found.append((begin, end))
        return tuple(found)

    @property
    def oblique(self) -> float:
        """Largest angle between an axis and the direction in `letters` that is nearest to it [degrees]."""
        return math.degrees(math.acos(min(float(np.abs(self.directions).max(axis=1).min()), 1.0)))

    @property
    def slant(self) -> float:
        """Largest deviation of the angle between two axes from a right one [degrees]."""
        along = np.array(self.directions)
        return math.degrees(math.asin(min(float(np.abs(along @ along.T)[np.triu_indices(3, 1)].max()), 1.0)))

    def __repr__(self) -> str:
        origin = ", ".join(f"{place:.6g}" for place in self.origin)
        return format_repr("Geometry", f"origin ({origin}) in {self.convention}", f"axes to {' '.join(self.letters)}")


def geometry_from_affine(affine: Any, convention: Convention) -> tuple[Geometry, Triple]:
    """Read geometry and spacing (plane, row, col) from a matrix (col, row, plane, 1) -> (x, y, z, 1), shape (4, 4)."""
    matrix = as_real_array(affine)
    along = matrix[:3, 2::-1].T
    plane, row, col = np.linalg.norm(along, axis=1).tolist()
    return Geometry(tuple(matrix[:3, 3].tolist()), along, convention), (plane, row, col)  # type: ignore[arg-type]


def freeze_matrix(matrix: Array) -> Matrix:
    """Return a matrix as tuples, which can be compared and hashed."""
    return tuple(map(tuple, matrix.tolist()))


def _check_convention(given: object) -> None:
    """Raise ValueError unless a value is the name of a convention."""
    if not isinstance(given, str) or given not in CONVENTIONS:
        raise ValueError(f'The convention is {quote_value(given)} but must be "LPS" or "RAS".')
