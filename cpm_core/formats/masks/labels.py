"""Labels: closed contours as filled regions, or branches of a skeleton as lines, each with its own number; as PNG."""

from __future__ import annotations

import io

import numpy as np
import PIL.Image
from numpy.typing import NDArray
from skimage.draw import line

from cpm_core.contours.measurements import numbers
from cpm_core.contours.rasterize import MOST_LABELS, label_type, paint
from cpm_core.contours.result import Result
from cpm_core.medial_axis.skeleton import Skeleton


def labels_of(result: Result | Skeleton) -> NDArray[np.unsignedinteger]:
    """Paint the closed contours of a result, or the branches of a skeleton.

    Returns
    -------
    ndarray of uint16 or uint32, shape `result.shape`
        Labels, 0 outside; 32 bits where there are more than 65535.

    Raises
    ------
    ValueError
        When there is nothing to paint.
    """
    _count(result)
    return paint_branches(result) if isinstance(result, Skeleton) else paint(result.contours, result.shape)


def paint_branches(skeleton: Skeleton) -> NDArray[np.unsignedinteger]:
    """Draw each branch of a skeleton as a line one pixel wide, connected along sides or corners of pixels.

    The longest branch has label 1, the next 2, and so on; where branches meet, the longer one is on top.

    Returns
    -------
    ndarray of uint16 or uint32, shape `skeleton.shape`
        Labels, 0 off the skeleton; 32 bits where there are more than 65535.
    """
    mask = np.zeros(skeleton.shape, dtype=label_type(len(skeleton.contours)))
    last = np.array(skeleton.shape) - 1
    for label in range(len(skeleton.contours), 0, -1):
        pixels = np.clip(np.floor(skeleton.contours[label - 1].path + 0.5).astype(int), 0, last)
        pixels = pixels[np.r_[True, (np.diff(pixels, axis=0) != 0).any(axis=1)]]
        mask[pixels[0, 0], pixels[0, 1]] = label
        for a, b in zip(pixels[:-1].tolist(), pixels[1:].tolist(), strict=True):
            mask[line(*a, *b)] = label  # type: ignore[no-untyped-call]
    return mask


def encode_png(result: Result | Skeleton) -> bytes:
    """Make a gray PNG file of the labels, of 8 bits up to 255 labels and of 16 bits above.

    ValueError when there is nothing to paint, or more than 65535 labels.
    """
    count = _count(result)
    if count > MOST_LABELS:
        what, cure = (
            (f"The skeleton of {result.source} has {count} branches, but a PNG mask", "raise pruning")
            if isinstance(result, Skeleton)
            else (
                f"{result.source} has {count} closed contours, but a PNG label mask",
                "raise min_length or min_strength",
            )
        )
        raise ValueError(f"{what} can hold at most {MOST_LABELS}: {cure}, or export to TIFF.")
    stream = io.BytesIO()
    pixels = labels_of(result).astype(np.uint8 if count <= 255 else np.uint16)
    PIL.Image.fromarray(pixels).save(stream, format="PNG")
    return stream.getvalue()


def _count(result: Result | Skeleton) -> int:
    """Number of labels; ValueError when there are none."""
    if isinstance(result, Skeleton):
        count = len(result.contours)
        nothing = f"{result.source} has no skeleton, so its picture would be empty: take less smoothing"
    else:
        count = max(numbers(result.contours), default=0)
        nothing = f"No contour of {result.source} is closed, so a label mask would be empty: let it run on"
    if count == 0:
        raise ValueError(f"{nothing}, or export to SVG or CSV.")
    return count
