"""Masks: outlines of their objects, such that painting them gives the same mask again."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import skimage
from numpy.typing import NDArray
from PIL import Image

from cpm_core.numerics.grids import find_label_boxes
from cpm_core.numerics.types import Array, Mask


def find_outlines(mask: NDArray[np.generic], row: int = 0, col: int = 0) -> list[tuple[Array, bool]]:
    """Find the closed curves around the pixels of a mask.

    Parameters
    ----------
    mask : ndarray, shape (H, W)
        Nonzero inside.
    row, col : int
        Position of the first pixel of the mask in the image.

    Returns
    -------
    list of (ndarray of float64, shape (K, 2), bool)
        Curves (row, col) halfway between the centers of pixels inside and outside [px], and whether each bounds a hole.
    """
    padded = np.pad(np.asarray(mask) != 0, 1).astype(float)
    found = []
    for curve in skimage.measure.find_contours(padded, 0.5, fully_connected="low"):  # type: ignore[no-untyped-call]
        (rows, cols), (below, right) = curve[:-1].T, curve[1:].T
        hole = bool(rows @ right - below @ cols > 0.0)  # these run the other way around
        found.append((curve[:-1] + np.array([row - 1.0, col - 1.0]), hole))
    return found


def read_color_indices(file: Path) -> NDArray[np.integer] | None:
    """Read the color indices of a PNG with a color table, int32 of shape (H, W); None for other files."""
    try:
        # only this warning, as those of other threads are caught as well
        with (
            warnings.catch_warnings(action="error", category=Image.DecompressionBombWarning),
            Image.open(file, formats=("PNG",)) as picture,
        ):
            if picture.mode == "P":
                return np.array(picture, np.int32)
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError, Image.DecompressionBombWarning):
        return None  # not a PNG, or a damaged or too large one, which the image reader reports
    return None


def find_label_outlines(labels: NDArray[np.integer]) -> Iterator[tuple[int, list[tuple[Array, bool]]]]:
    """Yield each label of a mask of shape (H, W) with its `find_outlines`; 0 is the background."""
    for number, (rows, cols) in find_label_boxes(labels):
        yield number, find_outlines(labels[rows, cols] == number, rows.start, cols.start)


def decode_runs(plain: Any) -> Mask:
    """Decode a run-length mask of COCO with ``size`` and ``counts``, a list or text, to bool of shape (H, W)."""
    height, width = (int(side) for side in plain["size"])
    counts = plain["counts"]
    lengths = _unpack_run_lengths(counts) if isinstance(counts, str) else np.array(counts, np.int64).reshape(-1)
    values = np.arange(len(lengths)) % 2 == 1
    return np.repeat(values, lengths).reshape(width, height).T


def _unpack_run_lengths(text: str) -> np.ndarray[Any, np.dtype[np.int64]]:
    """Decode the lengths of runs from compressed text.

    A character holds five bits, the lowest first, and a flag for whether another follows; from the fourth length on,
    each is stored as its difference from the length before the previous one.
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
