"""Outline: the closed boundary of a set of pixels, and the parts of it that follow no contour."""

from __future__ import annotations

import numpy as np
import skimage

from cpm_core.contours.contour import Contour
from cpm_core.field.interpolation import interpolate
from cpm_core.numerics import polyline
from cpm_core.numerics.segments import SegmentTree
from cpm_core.numerics.types import Array, Mask

NEAR = 1.5
"""Distance from a contour up to which a boundary follows it [px]."""


def outlines(mask: Mask, strength: Array) -> tuple[Contour, ...]:
    """Closed boundaries of the true pixels of a mask, longest first; `strength` is the edge map."""
    found = []
    for line in skimage.measure.find_contours(np.pad(mask, 1).astype(float), 0.5):  # type: ignore[no-untyped-call]
        points = line[:-1] - 1.0
        mean = float(interpolate(strength[None], polyline.sampled(line - 1.0, 1.0)).mean())
        found.append(Contour(points, True, mean))
    return tuple(sorted(found, key=lambda contour: -contour.length))


def gaps_of(outline: Contour, contours: SegmentTree, shape: tuple[int, ...]) -> tuple[Array, ...]:
    """Stretches of a closed outline that follow neither a contour nor the border of the image."""
    path = outline.path
    border = ((path < NEAR) | (path > np.array(shape) - 1.0 - NEAR)).any(axis=1)
    off = (contours.distances(path) > NEAR) & ~border
    if off.all():
        return (path,)
    start = int(np.argmin(off[:-1]))
    turned, off = np.roll(path[:-1], -start, axis=0), np.roll(off[:-1], -start)
    steps = np.flatnonzero(np.diff(np.r_[off, False].astype(int)))
    pairs = zip(steps[::2].tolist(), steps[1::2].tolist(), strict=False)
    closed = np.concatenate([turned, turned[:1]])
    return tuple(closed[begin : end + 2] for begin, end in pairs)
