"""Packed NIfTI: the same, compressed."""

from __future__ import annotations

import gzip

from cpm_core.contours.result import Result
from cpm_core.formats.masks import nifti
from cpm_core.medial_axis.skeleton import Skeleton

WRITES = {".nii.gz": "the same, compressed"}


def encode(result: Result | Skeleton) -> bytes:
    """Compress what `nifti` makes; the same result makes the same bytes."""
    return gzip.compress(nifti.encode(result), mtime=0)
