"""Orientation: turns a picture upright by the tag that cameras and scanners write (EXIF and TIFF tag 274)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cpm_core.formats.images.decoded import Decoded

TAG = 274
"""Number of the orientation tag."""

# For each value of the tag: swap rows and columns first, then flip rows, then flip columns.
_TURNS = {
    2: (False, False, True),
    3: (False, True, True),
    4: (False, True, False),
    5: (True, False, False),
    6: (True, False, True),
    7: (True, True, True),
    8: (True, True, False),
}


def upright(decoded: Decoded, orientation: int) -> Decoded:
    """Turn and mirror `decoded` as its orientation tag (1 to 8) asks; unknown values leave it as it is."""
    if orientation not in _TURNS:
        return decoded
    swap, flip_rows, flip_columns = _TURNS[orientation]
    values, spacing = decoded.values, decoded.spacing
    if swap:
        values, spacing = values.T, (spacing[1], spacing[0])
    if flip_rows:
        values = values[::-1]
    if flip_columns:
        values = values[:, ::-1]
    note = "It was turned upright as its orientation tag asks."
    return replace(decoded, values=np.ascontiguousarray(values), spacing=spacing, notes=(*decoded.notes, note))
