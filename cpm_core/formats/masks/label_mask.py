"""Label mask: a PNG of the image's very size, in which each closed contour fills its inside with its own label."""

from __future__ import annotations

import io

import numpy as np
import PIL.Image
from numpy.typing import NDArray

from cpm_core.contours.rasterize import MOST_LABELS, numbers, paint
from cpm_core.contours.result import Result

WRITES = {".png": "insides of closed contours as a label mask"}


def check(result: Result) -> int:
    """Count the closed contours of a result; ValueError when there are none."""
    count = max(numbers(result.contours), default=0)
    if count == 0:
        raise ValueError(
            f"No contour of {result.source} is closed, so a label mask would be empty: "
            "let it run on, or export to SVG or CSV."
        )
    return count


def encode(result: Result) -> bytes:
    """Make the label mask of a result.

    Returns
    -------
    bytes
        A grey PNG file of 8 bits up to 255 labels, of 16 bits above.

    Raises
    ------
    ValueError
        When no contour is closed, or more than 65535 are.
    """
    count = check(result)
    if count > MOST_LABELS:
        raise ValueError(
            f"{result.source} has {count} closed contours, but a PNG label mask can tell {MOST_LABELS} apart at most: "
            "raise min_length or min_strength, or export to TIFF."
        )
    return as_png(paint(result.contours, result.shape), count)


def as_png(mask: NDArray[np.unsignedinteger], count: int) -> bytes:
    """Make a grey PNG file of labels from 1 to `count`, of 8 bits up to 255 of them and of 16 bits above."""
    stream = io.BytesIO()
    PIL.Image.fromarray(mask.astype(np.uint8 if count <= 255 else np.uint16)).save(stream, format="PNG")
    return stream.getvalue()
