"""TIFF stacks: pages of TIFF files by their axes, hyperstacks of ImageJ and OME with channels and times among them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tifffile
from numpy.typing import NDArray

from cpm_core.formats.common.printable import printable
from cpm_core.formats.images import tiff
from cpm_core.formats.images.choice import FIRST, Choice, series_of
from cpm_core.formats.images.decoded import Decoded, UnreadableError
from cpm_core.formats.images.stacks.stack import Stack, as_planes, check_content, joined, plane_of

FORMAT = "TIFF"
READS = {".tif": "TIFF image or stack", ".tiff": "TIFF image or stack"}

_PIXEL_AXES = "YXS"


def reads(head: bytes, _path: Path) -> bool:
    """Whether the first bytes of a file are those of a TIFF."""
    return tiff.is_tiff(head)


def read(path: Path, choice: Choice = FIRST) -> Decoded:
    """Read one page: the first one, or that which is chosen."""
    return tiff.first_page(path) if choice == FIRST else plane_of(stack(path, choice), choice)


def stack(path: Path, choice: Choice = FIRST) -> Stack:
    """Open a stack: a series of pages of one size.

    Raises
    ------
    UnreadableError
        When it has more axes than times, channels, planes, rows and columns, or parts of it are in other files that
        are missing.
    """
    name = printable(path.name)
    with tifffile.TiffFile(path) as file:
        all_series = _series(file)
        names = tuple(str(one.name) for one in all_series)
        number = series_of(choice.series, names, 0, name)
        series = all_series[number]
        if series.dtype is None or min(series.shape) < 1:
            raise ValueError("it has no pixels")
        check_content(path, math.prod(series.shape) * series.dtype.itemsize)
        pages = _pages_of(series, name)
        keyframe = series.keyframe
        assert isinstance(keyframe, tifffile.TiffPage)
        (row, col), unit = tiff.spacing_of(file, keyframe, number)
        depth = tiff.depth_of(file, unit, number)
        size = dict(zip(series.axes, series.shape, strict=True))
        sides = (int(size["Y"]), int(size["X"]))
        if tiff.lies_across(keyframe):
            sides, (row, col) = sides[::-1], (col, row)
    notes = () if choice.series or len(names) == 1 else (f"Only the first of its {len(names)} series was taken.",)
    untold = () if depth or unit is None else ("The distance of its planes is not told; that of its rows was taken.",)

    def take(time: int, channel: int, first: int, end: int) -> Decoded:
        with tifffile.TiffFile(path) as file:
            return _taken(file, _series(file)[number], pages.numbers[time, channel, first:end], path)

    return Stack(
        name,
        (pages.numbers.shape[2], *sides),
        take,
        series.dtype.itemsize * float(size.get("S", 1)),
        pages.numbers.shape[0],
        pages.numbers.shape[1],
        (depth or row, row, col),
        unit,
        notes=notes,
        of_volume=untold,
        word="page",
        series=names,
        number=number,
        deep=depth is not None,
    )


def _series(file: tifffile.TiffFile) -> list[tifffile.TiffPageSeries]:
    """The series of a file, whose pages are counted first: of a damaged one they may follow each other in a circle."""
    if not len(file.pages):
        raise ValueError("it has no pages")
    return list(file.series)


@dataclass(frozen=True, eq=False)
class _Pages:
    """Index of each page by (time, channel, plane), in the order of the file."""

    numbers: NDArray[np.int64]


def _pages_of(series: tifffile.TiffPageSeries, name: str) -> _Pages:
    """Order of the pages of a series, whose axes of other meanings count as planes, or as times beside planes."""
    if not {"Y", "X"} <= set(series.axes):
        raise UnreadableError(f"{name} has the axes {series.axes}: save one volume or plane of it.")
    outer = [(axis, size) for axis, size in zip(series.axes, series.shape, strict=True) if axis not in _PIXEL_AXES]
    numbers = np.arange(math.prod(size for _, size in outer)).reshape([size for _, size in outer])
    role = {axis: axis for axis, _ in outer if axis in "TCZ"}
    for axis, size in outer:
        if axis in role or size == 1:
            continue
        free = next((other for other in "ZT" if other not in role.values()), None)
        if free is None:
            raise UnreadableError(f"{name} has the axes {series.axes} {series.shape}: save one volume or plane of it.")
        role[axis] = free
    places = [place for other in "TCZ" for place, (axis, _) in enumerate(outer) if role.get(axis) == other]
    ordered = numbers.transpose([*places, *(place for place in range(len(outer)) if place not in places)])
    sizes = [next((size for axis, size in outer if role.get(axis) == other), 1) for other in "TCZ"]
    return _Pages(ordered.reshape(sizes).astype(np.int64))


def _taken(file: tifffile.TiffFile, series: tifffile.TiffPageSeries, numbers: NDArray[np.int64], path: Path) -> Decoded:
    """Pages of a series: one by one, or by their place where one directory stands for all."""
    pages = series.pages
    whole = [pages[int(number)] for number in numbers] if len(pages) > int(numbers.max()) else []
    if any(page is None for page in whole):
        raise UnreadableError(f"{path.name} keeps pages in other files that are missing: put them beside it.")
    if whole and series.keyframe.imagedepth == 1 and all(isinstance(page, tifffile.TiffPage) for page in whole):
        found = []
        for page in whole:
            assert isinstance(page, tifffile.TiffPage)
            one = tiff.page_of(file, page, path)
            found.append(as_planes(one, (1, *one.values.shape)))
        return joined(found)
    axes = "".join(axis for axis in series.axes if axis in _PIXEL_AXES)
    every = series.asarray(maxworkers=1).reshape(-1, *(series.shape[series.axes.index(axis)] for axis in axes))
    page = series.keyframe
    assert isinstance(page, tifffile.TiffPage)
    read = (tiff.turned(page, tiff.pixels(page, plane, page.bitspersample, path.name)) for plane in every[numbers])
    return joined([as_planes(one, (1, *one.values.shape)) for one in read])
