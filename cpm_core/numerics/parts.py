"""Connected parts of a mask."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.numerics.types import Index, Mask


@dataclass(frozen=True, eq=False)
class Parts:
    """The connected parts of a mask of three axes.

    Attributes
    ----------
    labels : ndarray of int32, shape (P, R, C)
        Number of the part of each voxel plus one; 0 where the mask is False.
    count : int
        Number of parts.
    """

    labels: NDArray[np.int32]
    count: int

    @property
    def sizes(self) -> Index:
        """Number of voxels of each part."""
        return np.bincount(self.labels.ravel(), minlength=self.count + 1)[1:]

    @property
    def at_border(self) -> Mask:
        """Which parts touch the border of the mask."""
        found = np.zeros(self.count + 1, np.bool_)
        for axis in range(3):
            found[np.moveaxis(self.labels, axis, 0)[[0, -1]]] = True
        return found[1:]

    def part_at(self, voxels: Index) -> Index:
        """Part that voxels, shape (N, 3), belong to; -1 where the mask is False."""
        return np.asarray(self.labels[tuple(voxels.T)].astype(np.int64) - 1)


def parts_of(mask: Mask, *, corners: bool) -> Parts:
    """Parts of a mask of three axes; with `corners` voxels have 26 neighbors, else 6."""
    structure = scipy.ndimage.generate_binary_structure(3, 3 if corners else 1)
    labels = np.empty(mask.shape, np.int32)
    return Parts(labels, int(scipy.ndimage.label(mask, structure, output=labels)))
