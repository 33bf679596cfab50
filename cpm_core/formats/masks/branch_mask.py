"""Branch mask: a PNG of the image's very size, in which each branch of a skeleton is a line of its own label."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from skimage.draw import line

from cpm_core.contours.rasterize import MOST_LABELS, label_type
from cpm_core.formats.masks.label_mask import as_png
from cpm_core.medial_axis.skeleton import Skeleton

WRITES = {".png": "branches of a skeleton as labelled lines"}


def paint(skeleton: Skeleton) -> NDArray[np.unsignedinteger]:
    """Draw each branch as a line of pixels, one pixel wide, that touch at sides or corners.

    The longest branch has label 1, the next 2, and so on; where branches meet, the longer one shows.

    Parameters
    ----------
    skeleton : Skeleton
        Skeleton.

    Returns
    -------
    ndarray of uint16 or uint32, shape `skeleton.shape`
        Labels, 0 off the skeleton; 32 bits where there are more than 65535.
    """
    mask = np.zeros(skeleton.shape, dtype=label_type(len(skeleton.contours)))
    last = np.array(skeleton.shape) - 1
    for label in range(len(skeleton.contours), 0, -1):
        pixels = np.clip(np.floor(skeleton.contours[label - 1].path + 0.5).astype(int), 0, last)
        changes = np.r_[True, (np.diff(pixels, axis=0) != 0).any(axis=1)]
        pixels = pixels[changes]
        mask[pixels[0, 0], pixels[0, 1]] = label
        for a, b in zip(pixels[:-1].tolist(), pixels[1:].tolist(), strict=True):
            mask[line(*a, *b)] = label  # type: ignore[no-untyped-call]
    return mask


def check(skeleton: Skeleton) -> int:
    """Count the branches of a skeleton; ValueError when there are none."""
    if not skeleton.contours:
        raise ValueError(
            f"{skeleton.source} has no skeleton, so its picture would be empty: "
            "take less smoothing, or export to SVG or CSV."
        )
    return len(skeleton.contours)


def encode(skeleton: Skeleton) -> bytes:
    """Make the branch mask of a skeleton.

    Returns
    -------
    bytes
        A grey PNG file of 8 bits up to 255 branches, of 16 bits above.

    Raises
    ------
    ValueError
        When there is no branch, or more than 65535.
    """
    count = check(skeleton)
    if count > MOST_LABELS:
        raise ValueError(
            f"The skeleton of {skeleton.source} has {count} branches, "
            f"but a PNG mask can tell {MOST_LABELS} apart at most: raise pruning, or export to TIFF."
        )
    return as_png(paint(skeleton), count)
