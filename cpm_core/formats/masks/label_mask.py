"""Label mask: a PNG of the image's very size, in which each closed contour fills its inside with its own label."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np
import PIL.Image
from numpy.typing import NDArray
from skimage.draw import polygon

from cpm_core.contours.contour import Contour
from cpm_core.contours.result import Result

MOST_LABELS = 65535


def numbers(contours: Sequence[Contour]) -> tuple[int, ...]:
    """Label of each contour: 1, 2, ... over the closed ones in their order, 0 for open ones."""
    count = 0
    labels: list[int] = []
    for contour in contours:
        count += contour.closed
        labels.append(count if contour.closed else 0)
    return tuple(labels)


def paint(contours: Sequence[Contour], shape: tuple[int, ...]) -> NDArray[np.unsignedinteger]:
    """Fill the inside of each closed contour with its label.

    A pixel is inside when its centre is. Contours are painted from the largest to the smallest, so one that lies inside
    another shows on top with its own label: an object in an object, and likewise a hole, which a measurement can then
    leave out or subtract. Open contours enclose nothing and leave no trace.

    Parameters
    ----------
    contours : sequence of Contour
        Contours in px of the image.
    shape : tuple of int
        Shape of the image, (rows, columns).

    Returns
    -------
    ndarray of uint16 or uint32, shape `shape`
        Labels, 0 outside every contour; 32 bits where there are more than 65535.
    """
    mask = np.zeros(shape, dtype=label_type(len(contours)))
    closed = [(contour, label) for contour, label in zip(contours, numbers(contours), strict=True) if contour.closed]
    for contour, label in sorted(closed, key=lambda pair: -pair[0].area):
        inside = polygon(contour.points[:, 0], contour.points[:, 1], shape)  # type: ignore[no-untyped-call]
        mask[inside] = label
    return mask


def label_type(count: int) -> type[np.unsignedinteger]:
    """Type that holds so many labels."""
    return np.uint16 if count <= MOST_LABELS else np.uint32


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
