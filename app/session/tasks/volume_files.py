"""What a file holds, and which part of it is opened when nobody has chosen."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from app.model.volume.parts import Parts
from cpm_core.formats import open_stack
from cpm_core.formats.images import raster
from cpm_core.formats.images.choice import UnchosenError
from cpm_core.formats.images.medical.dicom.reader import dicom_files_beside
from cpm_core.formats.images.reading import Reading
from cpm_core.image.image import MINIMUM_SIDE

PAGED = frozenset({".tif", ".tiff", *raster.READS})
"""Suffixes of files whose pages are most often images of their own."""


def parts_of(path: Path, reading: Reading) -> tuple[Parts | None, Reading]:
    """What a file holds, None where it cannot be read, and how it is read: of several images the first one.

    What is wrong with a file is told when it is read.
    """
    paged = path.suffix.lower() in PAGED
    try:
        try:
            return Parts.of(open_stack(path, reading.series), paged, _series_around(path)), reading
        except UnchosenError as error:
            if not error.images:
                raise
            first = replace(reading, series=error.images[0] + 1)
            return Parts.of(open_stack(path, first.series), paged), first
    except ValueError:
        return None, reading


def _series_around(path: Path) -> Path | None:
    """The folder of a file, where both it and enough files beside it are DICOM."""
    around = dicom_files_beside(path, MINIMUM_SIDE)
    return path.parent if len(around) >= MINIMUM_SIDE else None


def opens_as_volume(parts: Parts | None) -> bool:
    """Whether a file is opened as a volume unless a page of it is asked for; if that fails, the sentence says why."""
    return parts is not None and parts.pages >= MINIMUM_SIDE and parts.deep
