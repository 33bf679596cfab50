"""TIFF: images and stacks of any depth, hyperstacks of ImageJ and OME with channels and times as pages."""

from __future__ import annotations

import logging
import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import replace
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cpm_core.formats.common.content import UnreadableError
from cpm_core.formats.common.printable import make_printable
from cpm_core.formats.images import resolution
from cpm_core.formats.images.decoded import (
    MAXIMUM_PIXELS,
    DecodedImage,
    check_pixel_count,
    decode_samples,
    rotate_upright,
)
from cpm_core.formats.images.multiscale import MultiscaleImage
from cpm_core.formats.images.reading import Reading, select_series
from cpm_core.formats.images.stack import ALL_COLORS, Stack, stack_from_levels, stack_planes
from cpm_core.image.colors import full_scale
from cpm_core.image.gray_levels import NO_DATA_VALUE
from cpm_core.numerics.packages import require_package
from cpm_core.numerics.types import Extent, Index, Numbers, Texts, frozen

if TYPE_CHECKING:
    import tifffile

# tifffile logs a warning for everything unusual in a file; the user gets one sentence on what matters instead.
logging.getLogger("tifffile").addHandler(logging.NullHandler())

FILE_KINDS = {
    ".tif": "TIFF image or stack",
    ".tiff": "TIFF image or stack",
    **dict.fromkeys((".svs", ".ndpi", ".scn"), "whole slide"),
}

_SECONDS = {"ns": 1e-9, "µs": 1e-6, "ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
"""Seconds in a unit of time."""

_TIFF_MAGIC = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
"""First bytes of TIFF and BigTIFF of either byte order."""

_JPEG_COMPRESSION = 7
"""Tag for compression by JPEG."""

_PREMULTIPLIED_ALPHA = 1
"""Tag for colors that are multiplied by their opacity."""

_PER_METER_UNIT = 1
"""Code of tifffile for a resolution in pixels per meter."""

_UNPACKED_BY_PYTHON = (1, 8, 32773, 32946)
"""Codes of compressions that need no other package: none, Deflate twice, PackBits."""

_NO_UNIT = 1
"""Tag for a resolution without a unit."""

_POLYNOMIALS = {0: 1, 1: 2, 2: 3, 3: 4}
"""Code of a calibration of ImageJ that is a polynomial -> its degree."""

_SLIDE_COLORS = ("MINISBLACK", "RGB", "YCBCR")
"""Tags for gray levels and colors of images that are read in parts."""

_PIXEL_AXES = "YXS"
"""Axes within a page: rows, columns, samples."""


def can_read(head: bytes, _path: Path) -> bool:
    """Return whether a file begins like a TIFF."""
    return head.startswith(_TIFF_MAGIC)


def open_image_file(path: Path, reading: Reading) -> Stack:
    """Open a stack: a series of pages of the same size.

    Raises
    ------
    UnreadableError
        When it has axes besides times, channels, planes, rows and columns, or parts of it are in other files, which are
        missing.
    """
    import tifffile  # only here, because it takes long to import

    name = make_printable(path.name)
    with tifffile.TiffFile(path) as file:
        all_series = _list_series(file)
        names = tuple(str(one.name) for one in all_series)
        number = select_series(reading, names, name)
        series = all_series[number]
        if series.dtype is None or min(series.shape) < 1:
            raise ValueError("it has no pixels")
        keyframe = series.keyframe
        if keyframe.compression not in _UNPACKED_BY_PYTHON:
            require_package("imagecodecs", name)
        depth, (row, col), unit = _read_voxel_size(file, keyframe, number)
        interval, styles = _read_interval(file, number), _read_channel_styles(file, number)
        if keyframe.imagelength * keyframe.imagewidth > MAXIMUM_PIXELS and _color_kind(keyframe) in _SLIDE_COLORS:
            place = (depth or row, row, col), unit, names, number, styles
            return stack_from_levels(_open_levels(path, name, series, place))
        check_pixel_count(name, int(keyframe.imagelength), int(keyframe.imagewidth))
        pages = _index_pages(series, name)
        hyperstack = file.imagej_metadata or {}
        if len(all_series) == 1 and pages.size < int(hyperstack.get("images", 1)):
            raise ValueError("it has fewer images than its description says")
        curve, calibrated = _parse_calibration(hyperstack, keyframe)
        ends = hyperstack.get("Ranges", ())
        ranges = dict(enumerate(zip(ends[::2], ends[1::2], strict=False)))
        bands = _count_bands(keyframe)
        size = dict(zip(series.axes, series.shape, strict=True))
        sides = (int(size["Y"]), int(size["X"]))
        if _page_orientation(keyframe) in range(5, 9):  # rows become columns
            sides, (row, col) = sides[::-1], (col, row)
    notes = () if reading.series or len(names) == 1 else (f"Only the first of its {len(names)} series was taken.",)
    has_colors = bands > 1 and _color_kind(keyframe) == "RGB"
    untold = ("The distance of its planes is not given; that of its rows was taken.",)

    def read_planes(time: int, channel: int, first: int, end: int) -> DecodedImage:
        if bands == 1:
            band = None
        elif channel == ALL_COLORS:
            channel, band = 0, None
        else:
            channel, band = divmod(channel, bands)
        with tifffile.TiffFile(path) as file:
            found = _decode_pages(_list_series(file)[number], pages[time, channel, first:end], band, name)
        if curve:
            return replace(found, values=np.polynomial.Polynomial(curve)(found.values))
        low, high = ranges.get(channel, (0.0, 0.0))
        return replace(found, window=(low, high)) if low < high and found.colors is None else found

    return Stack(
        name,
        (pages.shape[2], *sides),
        read_planes,
        series.dtype.itemsize * float(size.get("S", 1)),
        pages.shape[0],
        bands * pages.shape[1],
        (depth or row, row, col),
        unit,
        notes=(*notes, *calibrated),
        volume_notes=() if depth or unit is None or pages.shape[2] == 1 else untold,
        plane_word="page",
        series=names,
        series_number=number,
        has_plane_spacing=depth is not None,
        has_colors=has_colors,
        interval=interval,
        channel_styles=styles,
    )


@frozen
class _TiffLevel:
    """A level of resolution in a TIFF, parts of which are read by tifffile and zarr."""

    path: Path
    series: int
    level: int
    shape: Extent
    dtype: np.dtype[Any]

    def __getitem__(self, index: tuple[int | slice, ...]) -> Numbers:
        """Read a part."""
        import tifffile
        import zarr

        with tifffile.imread(self.path, series=self.series, level=self.level, aszarr=True) as store:
            return np.asarray(zarr.open(store, mode="r")[index])


def _open_levels(path: Path, name: str, series: tifffile.TiffPageSeries, place: tuple[Any, ...]) -> MultiscaleImage:
    """Open all levels of a series that is too large to be read as a whole, such as a slide; `place` has the rest."""
    require_package("zarr", name)
    axes = series.axes.lower().replace("i", "z").replace("q", "z")
    if not set("yx") <= set(axes) <= set("tczyxs") or len(set(axes)) < len(axes):
        raise UnreadableError(f"{name} has the axes {series.axes}: save one volume or plane of it.")
    arrays = tuple(
        _TiffLevel(path, place[3], number, tuple(level.shape), level.dtype)
        for number, level in enumerate(series.levels)
    )
    return MultiscaleImage(name, arrays, axes, *place)


def _list_series(file: tifffile.TiffFile) -> list[tifffile.TiffPageSeries]:
    """List the series of a file; its pages are counted first, since those of a damaged file may form a loop."""
    if not len(file.pages):
        raise ValueError("it has no pages")
    return list(file.series)


def _index_pages(series: tifffile.TiffPageSeries, name: str) -> Index:
    """Return the page index by (time, channel, plane), shape (T, C, P); other axes count as planes, or as times."""
    if not {"Y", "X"} <= set(series.axes):
        raise UnreadableError(f"{name} has the axes {series.axes}: save one volume or plane of it.")
    axes = [axis for axis in series.axes if axis not in _PIXEL_AXES]
    sizes = [size for axis, size in zip(series.axes, series.shape, strict=True) if axis not in _PIXEL_AXES]
    for place, axis in enumerate(axes):
        if axis not in "TCZ" and sizes[place] > 1:
            free = next((other for other in "ZT" if other not in axes), None)
            if free is None:
                raise UnreadableError(
                    f"{name} has the axes {series.axes} {series.shape}: save one volume or plane of it."
                )
            axes[place] = free
    order = sorted(range(len(axes)), key=lambda place: "TCZ".find(axes[place]))
    size = dict(zip(axes, sizes, strict=True))
    numbers = np.arange(math.prod(sizes)).reshape(sizes).transpose(order)
    return numbers.reshape([size.get(axis, 1) for axis in "TCZ"])


def _decode_pages(series: tifffile.TiffPageSeries, numbers: Index, band: int | None, name: str) -> DecodedImage:
    """Decode pages of a series, or a band of each: one by one, or by their offset if one directory stands for all."""
    import tifffile

    pages, keyframe = series.pages, series.keyframe
    whole = [pages[int(number)] for number in numbers] if len(pages) > int(numbers.max()) else []
    if any(page is None for page in whole):
        raise UnreadableError(f"{name} keeps pages in other files that are missing: put them next to it.")
    complete = [page for page in whole if isinstance(page, tifffile.TiffPage)]
    if whole and keyframe.imagedepth == 1 and len(complete) == len(whole):
        return stack_planes([_decode_page(page, _read_stored_pixels(page, name), band, name) for page in complete])
    axes = "".join(axis for axis in series.axes if axis in _PIXEL_AXES)
    every = series.asarray(maxworkers=1).reshape(-1, *(series.shape[series.axes.index(axis)] for axis in axes))
    return stack_planes([_decode_page(keyframe, plane, band, name) for plane in every[numbers]])


def _read_stored_pixels(page: tifffile.TiffPage, name: str) -> Numbers:
    """Read pixels as stored, shape (H, W) or (H, W, C), checking their number before memory is allocated."""
    check_pixel_count(name, int(page.imagelength), int(page.imagewidth))
    if page.bitspersample == 24:  # tifffile gets their order wrong
        raise _uncommon_kind_error(page, name)
    return np.asarray(page.asarray(maxworkers=1))


def _decode_page(page: tifffile.TiffPage, raw: Numbers, band: int | None, name: str) -> DecodedImage:
    """Decode the samples of a page, or those of one band, to upright gray levels."""
    if page.axes == "SYX":
        raw = np.moveaxis(raw, 0, -1)
    stored = samples = raw if raw.ndim == 3 else raw[..., np.newaxis]
    notes: list[str] = []
    colors, bits = _color_kind(page), page.bitspersample
    if band is not None:
        stored = samples = samples[..., band : band + 1]
        colors = "MINISBLACK" if colors == "RGB" else colors
    if samples.dtype == np.bool_:
        samples, bits = samples.astype(np.uint8) * np.uint8(255), 8
        notes.append("Black and white were read as 0 and 255.")
    if colors == "PALETTE":
        table = np.asarray(page.colormap, float)
        table = table if table.max() < 256.0 else table / 257.0  # old programs write eight bits in sixteen
        samples, bits = np.rint(table).astype(np.uint8).T[samples[..., 0]], 8
    elif colors == "SEPARATED":
        if page.tags.valueof("InkSet", default=1) != 1 or samples.shape[-1] < 4:
            raise _uncommon_kind_error(page, name)
        white = _white_level(bits, samples)
        light = (white - samples[..., :3]) * (1.0 - samples[..., 3:4] / white)
        samples = np.concatenate([light.astype(samples.dtype), samples[..., 4:]], axis=-1)
    elif colors not in ("MINISWHITE", "MINISBLACK", "RGB") and not (
        colors == "YCBCR" and page.compression == _JPEG_COMPRESSION  # unpacked to red, green and blue
    ):
        raise _uncommon_kind_error(page, name)
    white = _white_level(bits, samples)
    count = 1 if colors in ("MINISWHITE", "MINISBLACK") else 3
    extra = samples[..., count:]
    has_alpha = extra.shape[-1] > 0 and _has_alpha(page)
    if extra.shape[-1] > has_alpha:
        notes.append(f"Only the first {count + has_alpha} of its {samples.shape[-1]} channels were taken.")
    shown, opacity = samples[..., :count], extra[..., 0] / _white_level(bits, extra[..., 0]) if has_alpha else None
    if colors == "MINISWHITE":
        shown = white - shown
        notes.append("It counts from white to black and was inverted.")
    if opacity is not None and int(page.extrasamples[0]) == _PREMULTIPLIED_ALPHA:
        share = opacity[..., np.newaxis]
        shown = np.divide(shown, share, out=np.zeros(shown.shape), where=share > 0.0)
    found = decode_samples(shown, opacity, tuple(notes), white)
    given = stored[..., : 1 if colors == "PALETTE" else count]
    return rotate_upright(replace(found, values=_mask_no_data(page, found.values, given)), _page_orientation(page))


def _color_kind(page: tifffile.TiffPage) -> str:
    """Return the name of the way in which a page stores gray levels or colors, or its number if that is unknown."""
    import tifffile

    known = {one.value: one.name for one in tifffile.PHOTOMETRIC}
    return known.get(int(page.photometric), str(page.photometric))


def _count_bands(page: tifffile.TiffPage) -> int:
    """Count the samples of a pixel that are channels of their own; 1 if together they are a gray level or a color."""
    color = {"MINISWHITE": 1, "MINISBLACK": 1, "RGB": 3}.get(_color_kind(page))
    count = int(page.samplesperpixel)
    return 1 if color is None or count <= color + _has_alpha(page) else count


def _has_alpha(page: tifffile.TiffPage) -> bool:
    """Return whether the sample after gray level or color is the opacity."""
    return bool(page.extrasamples) and int(page.extrasamples[0]) in (1, 2)


def _uncommon_kind_error(page: tifffile.TiffPage, name: str) -> UnreadableError:
    """Return the error for a page with an unsupported type of numbers or colors."""
    return UnreadableError(
        f"{name} is a TIFF of an uncommon kind ({page.bitspersample} bits, {_color_kind(page)}): save it again in "
        "gray, or in red, green and blue."
    )


def _mask_no_data(page: tifffile.TiffPage, gray: Numbers, stored: Numbers) -> Numbers:
    """Set pixels whose samples all equal the no-data value of geographic programs to `NO_DATA_VALUE`."""
    try:
        absent_value = float(page.tags.valueof("GDAL_NODATA"))
    except (TypeError, ValueError):
        return gray
    absent = (np.isnan(stored) if math.isnan(absent_value) else stored == absent_value).all(axis=-1)
    return np.where(absent, np.float64(NO_DATA_VALUE), gray) if absent.any() else gray


def _white_level(bits: object, samples: Numbers) -> float:
    """Return the level of white, also for pixels with fewer bits than their type."""
    return 2.0**bits - 1.0 if isinstance(bits, int) and samples.dtype.kind == "u" else full_scale(samples)


def _page_orientation(page: tifffile.TiffPage) -> int:
    """Return the orientation tag of a page."""
    found = page.tags.valueof("Orientation", default=1)
    return found if isinstance(found, int) else 1


def _read_voxel_size(
    file: tifffile.TiffFile, page: tifffile.TiffPage, series: int
) -> tuple[float | None, tuple[float, float], str | None]:
    """Read the distance of planes, if stated, the pixel size on the specimen, and the unit of both.

    They come from OME or ImageJ, else from the resolution tag if it is plausible.
    """
    hyperstack = file.imagej_metadata or {}
    if file.ome_metadata:
        entries = _find_ome_pixels(file.ome_metadata, series)
        sizes = [_parse_size(entries.get(f"PhysicalSize{axis}")) for axis in "ZYX"]
        units = [entries.get(f"PhysicalSize{axis}Unit", resolution.MICROMETER) for axis in "ZYX"]
    else:
        if file.is_svs:
            import tifffile

            side = _parse_size(tifffile.tifffile.svs_description_metadata(page.description).get("MPP"))
            return None, (side or 1.0, side or 1.0), resolution.MICROMETER if side else None
        per_meter = page.get_resolution(_PER_METER_UNIT)
        plain, unit = resolution.spacing_from_density(*per_meter[::-1])
        relative = unit is None and page.tags.valueof("ResolutionUnit", default=_NO_UNIT) == _NO_UNIT
        if "unit" not in hyperstack and not relative:
            return None, plain, unit
        columns, rows = page.get_resolution()
        sizes = [_parse_size(hyperstack.get("spacing")), *(1.0 / count if count else 0.0 for count in (rows, columns))]
        own = str(hyperstack.get("unit", ""))
        units = [str(hyperstack.get("zunit", own)), str(hyperstack.get("yunit", own)), own]
    (row, col), unit = resolution.spacing_from_sizes(sizes[1:], units[1:])
    (depth, *sides), named = resolution.spacing_from_sizes(sizes, units)
    stated = sizes[0] > 0.0 and (named, *sides) == (unit, row, col)
    return depth if stated else None, (row, col), unit


def _read_interval(file: tifffile.TiffFile, series: int) -> float | None:
    """Read the time between two points in time [s], from OME or ImageJ; None where it is not given."""
    given, unit = (file.imagej_metadata or {}).get("finterval"), "s"
    if file.ome_metadata:
        entries = _find_ome_pixels(file.ome_metadata, series)
        given, unit = entries.get("TimeIncrement"), entries.get("TimeIncrementUnit", "s")
    return _parse_size(given) * _SECONDS.get(unit, 0.0) or None


def _read_channel_styles(file: tifffile.TiffFile, series: int) -> tuple[tuple[str, str], ...]:
    """Read name and color of each channel, as in `Stack`, from OME or ImageJ, whose tables may run down to black.

    ImageJ labels planes, channel by channel: a label that all planes of a channel have is its name. What OME states of
    the contrast, unless it is fluorescence, becomes a part of the name.
    """
    if file.ome_metadata:
        channels = _find_ome_pixels(file.ome_metadata, series).findall("{*}Channel")
        stated = [" ".join(dict.fromkeys(map(one.get, ("Name", "ContrastMethod"), ("", "")))) for one in channels]
        named = (make_printable(name.removesuffix(" Fluorescence").strip()) for name in stated)
        return tuple(zip(named, (_parse_ome_color(one.get("Color")) for one in channels), strict=True))
    hyperstack = file.imagej_metadata or {}
    tables, labels, count = hyperstack.get("LUTs", ()), hyperstack.get("Labels", ()), hyperstack.get("channels", 1)
    own = [set(labels[index::count]) for index in range(count)] if isinstance(labels, list) else []
    names = [make_printable(*label) if len(label) == 1 else "" for label in own]
    colors = [f"#{bytes(np.asarray(table, np.uint8).max(axis=1)).hex()}" for table in tables]
    return tuple(zip_longest(names, colors, fillvalue="")) if any(names) or colors else ()


def _parse_ome_color(given: str | None) -> str:
    """Parse a color of OME: red, green, blue and opacity as a signed number of 32 bits; empty for anything else."""
    try:
        return f"#{int(given or '') >> 8 & 0xFFFFFF:06x}"
    except ValueError:
        return ""


def _find_ome_pixels(description: str, number: int) -> ET.Element:
    """Find the pixels of an image in the metadata of OME, by its number; without attributes if there are none."""
    none = ET.Element("Pixels")
    if "<!DOCTYPE" in description:  # OME has none; entities of its own could grow without limit
        return none
    try:
        found = ET.fromstring(description).findall(".//{*}Pixels")
    except ET.ParseError:
        return none
    return found[number] if number < len(found) else none


def _parse_size(given: object) -> float:
    """Parse a size, without its sign; 0 for anything else."""
    try:
        size = abs(float(given))  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return 0.0
    return size if math.isfinite(size) else 0.0


def _parse_calibration(hyperstack: Mapping[str, object], page: tifffile.TiffPage) -> tuple[tuple[float, ...], Texts]:
    """Parse the polynomial by which ImageJ calibrates gray levels, lowest power first, none if there is none; a note.

    Signed gray levels of 16 bits are stored in this way.
    """
    code = hyperstack.get("cf")
    if code is None or _color_kind(page) not in ("MINISWHITE", "MINISBLACK"):
        return (), ()
    if code not in _POLYNOMIALS or _color_kind(page) == "MINISWHITE":
        return (), ("Its description calibrates gray levels by a curve, which was not applied.",)
    try:
        curve = tuple(float(hyperstack[f"c{power}"]) for power in range(_POLYNOMIALS[code] + 1))  # type: ignore[arg-type]
    except (KeyError, TypeError, ValueError):
        return (), ()
    return (curve, ("Gray levels were calibrated as its description says.",)) if curve != (0.0, 1.0) else ((), ())
