"""Label TIFF: the label mask for ImageJ and other programs that measure, with the size of a pixel."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import tifffile

from cpm_core.contours.result import Result
from cpm_core.formats.common.provenance import PROGRAM, entries_of, facts_of, text_of
from cpm_core.formats.masks.labels import labels_of
from cpm_core.medial_axis.skeleton import Skeleton

_PER_CENTIMETER = {"nm": 1e7, "µm": 1e4, "mm": 10.0, "cm": 1.0, "m": 0.01}


def encode(result: Result | Skeleton, *, outlines: bool = False) -> bytes:
    """Make an uncompressed gray TIFF of 16 bits with the entries of ImageJ, which then shows lengths in the unit.

    It has 32 bits where there are more than 65535 labels; ImageJ would interpret them as real numbers, so its entries
    are left out. How the labels were found is the info of ImageJ (Image > Show Info), or of 32 bits the description.
    ValueError when there is nothing to paint.
    """
    facts = facts_of(result)
    mask = labels_of(result, outlines=outlines)
    entries: dict[str, Any] = {}
    height, width = result.spacing[-2:]
    if result.unit:
        entries["resolution"] = (1.0 / width, 1.0 / height)
    if mask.dtype == np.uint16:
        unit = {"µm": "um"}.get(result.unit or "pixel", result.unit or "pixel")
        info = "".join(f"{name}: {told}\n" for name, told in entries_of(facts).items())
        entries |= {"imagej": True, "metadata": {"axes": "ZYX"[-mask.ndim :], "unit": unit, "Info": info}}
        if mask.ndim == 3:
            entries["metadata"]["spacing"] = result.spacing[0]
    else:
        entries |= {"metadata": None, "description": text_of(facts)}
        if result.unit in _PER_CENTIMETER:
            factor = _PER_CENTIMETER[result.unit]
            entries["resolution"] = (factor / width, factor / height)
            entries["resolutionunit"] = "CENTIMETER"
    stream = io.BytesIO()
    tifffile.imwrite(stream, mask, photometric="minisblack", software=PROGRAM, **entries)
    return stream.getvalue()
