"""ImageJ ROI set: contours as the archive of selections that the ROI manager of ImageJ and Fiji opens."""

from __future__ import annotations

import io
import re
import zipfile

from cpm_core.contours.result import Result
from cpm_core.formats.contours.appearance import title
from cpm_core.formats.contours.imagej import selection
from cpm_core.medial_axis.skeleton import Skeleton

WRITES = {".zip": "contours as a set of selections of ImageJ and Fiji"}

_LONGEST = 60
"""Letters of a name that go into the name of a file in the archive."""


def encode(result: Result | Skeleton) -> bytes:
    """Write each contour as a selection into one archive.

    The ROI manager calls a selection what its file in the archive is called: the name of the contour, with a number
    behind it where several have the same.

    Returns
    -------
    bytes
        A ZIP file of ROI files in their order; the same result makes the same bytes.

    Raises
    ------
    ValueError
        When there is no contour, for which ImageJ takes an archive for damaged.
    """
    if not result.contours:
        raise ValueError(f"{result.source} has no contours, and ImageJ opens no empty set: let it run on.")
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for number, (contour, name) in enumerate(zip(result.contours, _names(result), strict=True), start=1):
            entry = zipfile.ZipInfo(f"{name}.roi")  # of no date, as the result has none
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, selection(contour, number))
    return stream.getvalue()


def _names(result: Result | Skeleton) -> list[str]:
    """Name of each contour in letters that file names may have, none twice."""
    found: dict[str, str] = {}  # in small letters, for some file systems do not tell them apart
    for number, contour in enumerate(result.contours, start=1):
        plain = re.sub(r"[^\w .()+-]", "_", title(contour, number))[:_LONGEST]
        name = plain if plain.lower() not in found else f"{plain}-{number}"
        while name.lower() in found:
            name += "-"
        found[name.lower()] = name
    return list(found.values())
