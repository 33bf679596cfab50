"""The camera of the view in space: from where a volume is seen, and where its positions lie in the picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy

from cpm_core.numerics import Array
from cpm_core.numerics.types import Numbers, Single, record

_FILLED_FRACTION = 1.0
"""Fraction of the picture's shorter side that the diagonal of a volume fills at first."""

_MIN_SCALE = 1e-6
"""Smallest scale, so that no number overflows [px / unit of length]."""

_MAX_SCALE = 1e6
"""Largest scale, so that no number overflows [px / unit of length]."""

_INITIAL_TILT = -0.45, 0.35
"""Initial angles to the right and down [rad], which show three sides of a volume."""


@record
class Camera:
    """A parallel projection: equal lengths look equal wherever they are, so that a scale bar holds.

    Attributes
    ----------
    center : ndarray, shape (3,)
        Position in the middle of the picture, (plane, row, col) in units of length.
    axes : ndarray, shape (3, 3)
        Unit vectors to the right, down, and away from the viewer, one a row, each along (plane, row, col).
    scale : float
        Pixels per unit of length.
    """

    center: Array
    axes: Array
    scale: float

    @staticmethod
    def facing_box(lengths: Sequence[float], size: tuple[int, int], front: Array | None = None) -> Camera:
        """See all of a box from the origin in a picture of `size` rows and columns.

        `lengths` are the sides of the box along (plane, row, col), in units of length. `front`, shape (3, 3), are the
        axes of the camera before the box is tilted, by default those of the slices across planes.
        """
        sides = np.asarray(lengths, float)
        front = np.eye(3)[::-1] if front is None else front
        scale = _FILLED_FRACTION * min(size) / max(float(np.linalg.norm(sides)), 1e-300)
        return Camera(0.5 * sides, front, _clamp_scale(scale)).rotated(*_INITIAL_TILT)

    def rotated(self, right: float, down: float) -> Camera:
        """Rotate the volume, as a ball under a finger that moves to the right and down by these angles [rad]."""
        return self._rotated(0.0, -right, 0.0)._rotated(down, 0.0, 0.0)

    def rolled(self, angle: float) -> Camera:
        """Rotate the picture about its middle, clockwise [rad]."""
        return self._rotated(0.0, 0.0, -angle)

    def _rotated(self, *about: float) -> Camera:
        """Rotate about the axes of the picture, without accumulating rounding errors over many small turns."""
        turn = scipy.spatial.transform.Rotation.from_rotvec(about).as_matrix()
        left, _, right = np.linalg.svd(turn @ self.axes)
        return replace(self, axes=left @ right)

    def translated(self, right: float, down: float) -> Camera:
        """Move the volume in the picture [px]."""
        return replace(self, center=self.center - (right * self.axes[0] + down * self.axes[1]) / self.scale)

    def zoomed(self, factor: float, right: float = 0.0, down: float = 0.0) -> Camera:
        """Enlarge, so that the place at this offset from the middle of the picture [px] stays where it is."""
        scale = _clamp_scale(self.scale * factor)
        true = scale / self.scale
        return replace(self.translated(-right, -down), scale=scale).translated(right, down) if true != 1.0 else self

    def enlarged(self, factor: float) -> Camera:
        """Return the same view for a picture with `factor` times as many rows and columns."""
        return replace(self, scale=self.scale * factor)

    def project(self, positions: Numbers, size: tuple[int, int]) -> Single:
        """Project positions (N, 3) in units of length into a picture: column, row and depth [px], shape (N, 3)."""
        away = np.asarray(positions, np.float32) - self.center.astype(np.float32)
        found = away @ (self.axes * self.scale).astype(np.float32).T
        found[:, :2] += 0.5 * (size[1] - 1), 0.5 * (size[0] - 1)
        return found

    def first_pixel_position(self, size: tuple[int, int]) -> Array:
        """Return the position in the picture's plane that its first pixel shows, shape (3,), in units of length."""
        return self.translated(0.5 * (size[1] - 1), 0.5 * (size[0] - 1)).center


def _clamp_scale(scale: float) -> float:
    return min(max(scale, _MIN_SCALE), _MAX_SCALE)
