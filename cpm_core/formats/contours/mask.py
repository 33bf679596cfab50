"""Masks: the outlines of their objects, so that painting them gives the same mask again."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import scipy
import skimage
from numpy.typing import NDArray
from PIL import Image

from cpm_core.numerics.types import Array, Mask


def outlines(mask: NDArray[np.generic], row: int = 0, col: int = 0) -> list[tuple[Array, bool]]:
    """Closed curves around the pixels of a mask, and whether each is the boundary of a hole.

    `row` and `col` are the place of the first pixel. Curves run between the centers of pixels inside and outside.
    """
    padded = np.pad(np.asarray(mask) != 0, 1).astype(float)
    found = []
    for curve in skimage.measure.find_contours(padded, 0.5, fully_connected="low"):  # type: ignore[no-untyped-call]
        (rows, cols), (below, right) = curve[:-1].T, curve[1:].T
        hole = bool(rows @ right - below @ cols > 0.0)  # which run the other way around
        found.append((curve[:-1] + np.array([row - 1.0, col - 1.0]), hole))
    return found


def numbered_colors(file: Path) -> NDArray[np.integer] | None:
    """The numbers of the colors of a PNG that has a table of them; None for other files."""
    try:
        with Image.open(file, formats=("PNG",)) as picture:
            if picture.mode == "P":
                return np.array(picture, np.int32)
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError):
        return None  # no PNG, or a damaged or large one, of which the reader of images reports
    return None


def objects(labels: NDArray[np.integer]) -> Iterator[tuple[int, list[tuple[Array, bool]]]]:
    """Each label of a mask with its `outlines`; 0 is the background."""
    for number, window in enumerate(scipy.ndimage.find_objects(labels), start=1):
        if window is not None:
            rows, cols = window
            yield number, outlines(labels[window] == number, rows.start, cols.start)


def mask_of_runs(plain: Any) -> Mask:
    """The mask of run lengths of COCO with ``size`` and ``counts``, plain or as text; ValueError when it is none."""
    height, width = (int(side) for side in plain["size"])
    counts = plain["counts"]
    lengths = _unpacked(counts) if isinstance(counts, str) else np.array(counts, np.int64).reshape(-1)
    values = np.arange(len(lengths)) % 2 == 1
    return np.repeat(values, lengths).reshape(width, height).T


def _unpacked(text: str) -> np.ndarray[Any, np.dtype[np.int64]]:
    """Lengths of the runs of compressed text.

    A letter holds five bits, the lowest first, and whether another follows; from the fourth length on, each is given
    by how much it differs from the one before the last.
    """
    lengths: list[int] = []
    value = shift = 0
    for letter in text:
        bits = ord(letter) - ord("0")
        value |= (bits & 31) << shift
        shift += 5
        if not bits & 32:
            if bits & 16:
                value -= 1 << shift
            lengths.append(value + (lengths[-2] if len(lengths) > 2 else 0))
            value = shift = 0
    return np.array(lengths, np.int64)
