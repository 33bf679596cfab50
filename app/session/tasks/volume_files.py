"""Which files are opened as volumes, and which hold a volume of which a page is opened."""

from __future__ import annotations

from pathlib import Path

from cpm_core.formats import holds_volume
from cpm_core.formats.images import raster

PAGED = frozenset({".tif", ".tiff", *raster.READS})
"""Suffixes of files whose pages are most often images of their own."""


def is_stacked(path: Path) -> bool:
    """Whether a file holds enough planes for a volume; what is wrong with a file is told when it is read."""
    try:
        return holds_volume(path)
    except ValueError:
        return False


def opens_as_volume(path: Path) -> bool:
    """Whether a file is opened as a volume unless a page of it is asked for."""
    return path.suffix.lower() not in PAGED and is_stacked(path)
