"""NumPy arrays: ``.npy`` files of gray levels or of colors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.formats.images.decoded import Decoded, UnreadableError, check_size, from_samples

READS = {".npy": "NumPy array"}


def reads(head: bytes, _path: Path) -> bool:
    """Whether the first bytes of a file are those of a NumPy array."""
    return head.startswith(b"\x93NUMPY")


def read(path: Path) -> Decoded:
    """Read an array (H, W), or (H, W, 3) and (H, W, 4) as red, green, blue and alpha.

    Raises
    ------
    UnreadableError
        When the array is neither, does not hold real numbers, or is too large.
    """
    stored: NDArray[Any] = np.load(path, mmap_mode="r", allow_pickle=False)
    if stored.dtype.kind not in "buif":
        raise UnreadableError(f"{path.name} holds values of type {stored.dtype}, but gray levels must be real numbers.")
    color = stored.ndim == 3 and stored.shape[2] in (3, 4)
    if stored.ndim != 2 and not color:
        raise UnreadableError(
            f"{path.name} holds an array of shape {stored.shape}, but an image is (rows, columns), "
            "with 3 or 4 channels at most: save one plane of it."
        )
    check_size(path.name, stored.shape[0], stored.shape[1])
    values = np.array(stored)
    if not color:
        return Decoded(values)
    return from_samples(values[..., :3], values[..., 3] if values.shape[2] == 4 else None)
