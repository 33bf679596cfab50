"""Label stack: the label masks of all pages as one TIFF, in which an object has the same label on every page."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import tifffile

from cpm_core.contours.rasterize import Labels, label_type, paint
from cpm_core.contours.result import Result
from cpm_core.formats.common.provenance import PROGRAM, entries_of, facts_of
from cpm_core.pages.page import StackResult

_LARGEST_IMAGEJ = 2**32 - 2**25
"""Size that a TIFF with the entries of ImageJ may have; a larger one needs addresses of 64 bits [bytes]."""


def write(found: StackResult, target: Path) -> None:
    """Write an uncompressed TIFF with one page for each page of the stack, painted one at a time.

    The labels are tracks; pages that were not used, and those without closed contours, are 0. It has the entries of
    ImageJ where that can read it, else plain ones. ValueError when there is nothing to paint.
    """
    results = dict(found.results)
    closed = [one.number for result in results.values() for one in result.contours if one.closed]
    if not closed:
        raise ValueError(
            f"No contour of {found.source} is closed, so a label stack would be empty: let it run on, or export to CSV."
        )
    first = next(iter(results.values()))
    kind = np.dtype(label_type(max(closed)))
    shape = tuple(int(side) for side in np.max([result.shape for result in results.values()], axis=0))
    size = found.count * int(np.prod(shape)) * kind.itemsize
    entries: dict[str, Any] = {"metadata": {"axes": f"{found.axis.upper()}YX"}}
    if kind == np.uint16 and size < _LARGEST_IMAGEJ:
        unit = {"µm": "um"}.get(first.unit or "pixel", first.unit or "pixel")
        info = "".join(f"{name}: {told}\n" for name, told in entries_of(facts_of(first)).items())
        entries = {"imagej": True, "metadata": {"axes": f"{found.axis.upper()}YX", "unit": unit, "Info": info}}
    if first.unit:
        entries["resolution"] = (1.0 / first.spacing[1], 1.0 / first.spacing[0])
    tifffile.imwrite(
        target,
        _painted(found.count, results, shape, kind),
        shape=(found.count, *shape),
        dtype=kind,
        bigtiff=size >= _LARGEST_IMAGEJ,
        photometric="minisblack",
        software=PROGRAM,
        **entries,
    )


def tracks_on(result: Result, shape: tuple[int, ...]) -> Labels:
    """Paint the insides of closed contours with their tracks."""
    painted = paint(result.contours, shape)
    numbers = [contour.number for contour in result.contours if contour.closed and not contour.hole]
    return np.array([0, *numbers])[painted]


def _painted(count: int, results: dict[int, Result], shape: tuple[int, ...], kind: np.dtype[Any]) -> Iterator[Labels]:
    nothing = np.zeros(shape, kind)
    for page in range(1, count + 1):
        yield tracks_on(results[page], shape).astype(kind) if page in results else nothing
