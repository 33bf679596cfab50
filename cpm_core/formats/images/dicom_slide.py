"""Whole slides in DICOM: tiles that make up an image, each level of resolution in a file, read by pydicom."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.formats.common.printable import make_printable
from cpm_core.formats.images import resolution
from cpm_core.formats.images.multiscale import MultiscaleImage
from cpm_core.formats.images.reading import Reading, select_series
from cpm_core.numerics.grids import relative_window, window_shape
from cpm_core.numerics.types import Extent, Index, Numbers, frozen

_SLIDE_TAGS = (
    *("SeriesInstanceUID", "SeriesDescription", "ImageType", "TotalPixelMatrixRows", "TotalPixelMatrixColumns"),
    *("TotalPixelMatrixFocalPlanes", "NumberOfOpticalPaths", "Rows", "Columns", "NumberOfFrames", "SamplesPerPixel"),
    *("BitsAllocated", "PixelRepresentation", "SharedFunctionalGroupsSequence", "PerFrameFunctionalGroupsSequence"),
)
"""Tags that are read from a header."""

_MICROMETERS_PER_MILLIMETER = 1000.0
"""DICOM states the size of a pixel in mm."""


@frozen
class _SlideLevel:
    """A level of a slide, or a picture of its label, parts of which are read tile by tile.

    Attributes
    ----------
    path : Path
        The file.
    series, title : str
        Identifier and name of its series.
    kind : str
        VOLUME for a level of the slide itself, else what it shows, such as LABEL.
    shape : tuple of int
        Optical paths, focal planes, rows and columns; of a color image 3 more.
    dtype : numpy.dtype
        Type of the samples.
    sides : tuple of float
        Size of a pixel along (plane, row, col) [µm]; 0 where it is unknown.
    tile : tuple of int
        Rows and columns of a tile.
    places : ndarray, shape (N, 4)
        Optical path, focal plane, first row and first column of each tile, from 0.
    """

    path: Path
    series: str
    title: str
    kind: str
    shape: Extent
    dtype: np.dtype[Any]
    sides: tuple[float, float, float]
    tile: tuple[int, int]
    places: Index

    def __getitem__(self, index: tuple[int | slice, ...]) -> Numbers:
        """Read a part of one optical path; what no tile covers is white, or without color black."""
        from pydicom.pixels.utils import iter_pixels

        wanted = tuple(
            slice(*side.indices(length)[:2])
            for side, length in zip(index[1:4], self.shape[1:4], strict=True)
            if isinstance(side, slice)
        )
        empty = np.iinfo(self.dtype).max if len(self.shape) > 4 else 0
        part = np.full((*window_shape(wanted), *self.shape[4:]), empty, self.dtype)
        begin, end = self.places[:, 1:], self.places[:, 1:] + (1, *self.tile)
        first, last = np.array([(side.start, side.stop) for side in wanted]).T
        near = (self.places[:, 0] == index[0]) & ((begin < last) & (end > first)).all(axis=1)
        frames = np.flatnonzero(near).tolist()
        for frame, pixels in zip(frames, iter_pixels(self.path, indices=frames) if frames else (), strict=True):
            tile = tuple(map(slice, begin[frame].tolist(), end[frame].tolist()))
            common = tuple(
                slice(max(one.start, other.start), min(one.stop, other.stop))
                for one, other in zip(tile, wanted, strict=True)
            )
            part[relative_window(common, wanted)] = pixels[None][relative_window(common, tile)]
        return part


def open_slide(name: str, chosen: Path, files: Iterable[Path], reading: Reading) -> MultiscaleImage | None:
    """Open the slide that files consist of, or the level `chosen` and the coarser ones; None where there is none."""
    levels = [level for level in map(_read_level, files) if level is not None]
    own = next((level for level in levels if level.path == chosen), None)
    if own is not None:
        levels = [one for one in levels if (one.series, one.kind) == (own.series, own.kind)]
        levels = [one for one in levels if one.shape[2] < own.shape[2] or one is own]
    levels = [one for one in levels if one.kind == "VOLUME"] or levels
    if not levels:
        return None
    levels.sort(key=lambda level: -level.shape[2])
    titles = {level.series: make_printable(level.title) for level in levels}
    number = select_series(reading, tuple(titles.values()), name)
    arrays = [level for level in levels if level.series == list(titles)[number]]
    spacing, unit = resolution.spacing_from_sizes(arrays[0].sides[1:], 2 * [resolution.MICROMETER])
    deep = arrays[0].sides[0] if unit else 0.0
    return MultiscaleImage(
        name,
        tuple(level for level in arrays if len(level.shape) == len(arrays[0].shape)),
        "czyxs"[: len(arrays[0].shape)],
        (deep or spacing[0], spacing[0], spacing[1]),
        unit,
        tuple(titles.values()) if len(titles) > 1 else (),
        number,
    )


def _read_level(path: Path) -> _SlideLevel | None:
    """Read the header of a level; None for other files, and damaged ones."""
    import pydicom  # only here, because it takes long to import

    try:
        header = pydicom.dcmread(path, stop_before_pixels=True, force=True, specific_tags=list(_SLIDE_TAGS))
        if "TotalPixelMatrixRows" not in header:
            return None
        tile = int(header.Rows), int(header.Columns)
        whole = int(header.TotalPixelMatrixRows), int(header.TotalPixelMatrixColumns)
        paths = int(header.get("NumberOfOpticalPaths") or 1)
        planes = int(header.get("TotalPixelMatrixFocalPlanes") or 1)
        own = header.get("PerFrameFunctionalGroupsSequence")
        if own and "PlanePositionSlideSequence" in own[0]:
            places = _list_places(own)
        else:  # all tiles, one row of them after the other
            grid = paths, planes, *(-(-side // length) for side, length in zip(whole, tile, strict=True))
            places = np.indices(grid).reshape(4, -1).T[: int(header.get("NumberOfFrames") or 1)] * (1, 1, *tile)
        shared = ((header.get("SharedFunctionalGroupsSequence") or [{}])[0].get("PixelMeasuresSequence") or [{}])[0]
        row, col = shared.get("PixelSpacing") or (0.0, 0.0)
        deep = shared.get("SpacingBetweenSlices") or 0.0
        kinds = [str(kind) for kind in header.get("ImageType") or ()]
        bits, sign = int(header.BitsAllocated), "i" if header.get("PixelRepresentation") else "u"
        return _SlideLevel(
            path,
            str(header.get("SeriesInstanceUID", "")),
            str(header.get("SeriesDescription", "")),
            kinds[2] if len(kinds) > 2 else "VOLUME",
            (
                *(places[:, :2].max(axis=0) + 1).tolist(),
                *whole,
                *([3] if int(header.get("SamplesPerPixel") or 1) == 3 else []),
            ),
            np.dtype(f"{sign}{max(bits // 8, 1)}"),
            tuple(_MICROMETERS_PER_MILLIMETER * float(side) for side in (deep, row, col)),  # type: ignore[arg-type]
            tile,
            places,
        )
    except Exception:  # of any kind in a damaged file
        return None


def _list_places(frames: Any) -> Index:
    """List the place of each tile: optical path, focal plane, first row and first column."""
    found = []
    for frame in frames:
        entry = frame.PlanePositionSlideSequence[0]
        path = (frame.get("OpticalPathIdentificationSequence") or [{}])[0].get("OpticalPathIdentifier", "")
        height = float(entry.get("ZOffsetInSlideCoordinateSystem") or 0.0)
        row, col = int(entry.RowPositionInTotalImagePixelMatrix), int(entry.ColumnPositionInTotalImagePixelMatrix)
        found.append((path, height, row - 1, col - 1))
    ranks = [np.unique([one[axis] for one in found], return_inverse=True)[1] for axis in (0, 1)]
    return np.column_stack([*ranks, np.array([one[2:] for one in found])])
