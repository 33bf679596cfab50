"""Which files are opened as volumes, and which stacks of pages can be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import tifffile

from cpm_core.formats.images.volume import READS

VOLUMES = (".npz", ".nii", ".nii.gz")
"""Suffixes of files that hold nothing but volumes."""

READABLE_VOLUMES: frozenset[str] = frozenset(READS)
"""Suffixes of all files that may hold a volume."""

_LEAST = 8
"""Pages from which a stack can be a volume."""


def holds_only_volume(path: Path) -> bool:
    """Whether a file is a volume and nothing else, so that no page of it can be opened as an image."""
    name = path.name.lower()
    if name.endswith(VOLUMES):
        return True
    if not name.endswith(".npy"):
        return False
    try:
        shape = np.load(path, mmap_mode="r", allow_pickle=False).shape
    except (OSError, ValueError, EOFError):  # the reader of images tells what is wrong with it
        return False
    return len(shape) == 3 and (shape[2] not in (3, 4))


def pages_of(path: Path) -> int:
    """Pages of a stack that can be opened as one volume; 0 for any other file."""
    if not path.name.lower().endswith((".tif", ".tiff")):
        return 0
    try:
        with tifffile.TiffFile(path) as file:
            shape = file.series[0].shape if len(file.series) == 1 else ()
            colored = file.pages.first.samplesperpixel > 1
    except Exception:  # decoders raise exceptions of any kind, and the reader of images has told what is wrong
        return 0
    return int(shape[0]) if len(shape) == 3 and not colored and min(shape) >= _LEAST else 0
