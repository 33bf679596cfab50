"""Stacks: contents of a file before any part is read, and the parts: a plane, a volume, pages."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, overload

import numpy as np

from cpm_core.formats.common.content import UnreadableError
from cpm_core.formats.images.decoded import MAXIMUM_PIXELS, DecodedImage, check_pixel_count
from cpm_core.formats.images.multiscale import MultiscaleImage
from cpm_core.formats.images.reading import Reading, select_index
from cpm_core.image.colors import Colors
from cpm_core.image.geometry import Convention, Geometry, Triple, geometry_from_affine
from cpm_core.image.image import MINIMUM_SIDE, Image
from cpm_core.numerics.memory import check_field_memory
from cpm_core.numerics.types import Array, Extent, Texts, record
from cpm_core.parameters.formatting import format_count, format_repr, format_size, quote_value

_GRAY_LEVEL_MEMORY = 16
"""Memory for a voxel besides its stored value while it is read: its gray level and a copy of it [bytes]."""

MAX_SILENT_SLANT = 0.5
"""Largest deviation of axes from right angles without a note [degrees]."""

ALL_COLORS = -1
"""Index that stands for red, green and blue together in place of one of the channels."""

VolumePosition = tuple[Triple, str | None, Geometry | None, Texts]
"""Voxel size, its unit and the position of the volume, if the file states them, and notes on them."""

ONLY_THESE_NOTE = "Only these were taken."
"""Note after the one on the longest even part of a file."""


@record
class Stack:
    """Contents of a file of one or several planes.

    Attributes
    ----------
    name : str
        The file.
    shape : tuple of int
        Number of planes, rows and columns.
    read_planes : callable
        Called with time, channel, first plane and the plane after the last, all from 0: reads gray levels of shape
        (planes, rows, columns), colors if there are any, and notes. With `has_colors` the channel may be `ALL_COLORS`.
    bytes_per_voxel : float
        Size of a voxel as it is stored [bytes].
    times, channels : int
        Number of each.
    spacing : tuple of float
        Size of a voxel along (plane, row, col), in `unit`.
    unit : str or None
        Unit of length; None when the file does not give it.
    geometry : Geometry or None
        Position of the volume in space.
    plane_geometries : tuple of Geometry
        Position of each plane, if it does not follow from `geometry`.
    volume_range : tuple of int or None
        Range of planes that make a volume, if the file lacks others.
    notes, volume_notes : tuple of str
        Notes on everything that is read, and on volumes only.
    plane_word : str
        Name of a plane: plane, page or frame.
    series : tuple of str
        Names of all series of the file, or arrays of the archive; empty if it has none.
    series_number : int
        Index of this one among them, from 0.
    has_plane_spacing : bool
        Whether the file states the distance of its planes, which are then those of a volume.
    hounsfield : bool or None
        Whether gray levels are Hounsfield units; None if the file does not state it.
    has_colors : bool
        Whether the first channels are red, green and blue, which are read together unless a channel is chosen.
    levels : MultiscaleImage or None
        All resolutions of an image that is read in parts; None for other images.
    interval : float or None
        Time between two points in time [s], if the file states it.
    channel_styles : tuple of (str, str)
        Name and color, as #rrggbb, of each channel, empty where the file does not state them; () if it states none.
    """

    name: str
    shape: tuple[int, int, int]
    read_planes: Callable[[int, int, int, int], DecodedImage]
    bytes_per_voxel: float = 8.0
    times: int = 1
    channels: int = 1
    spacing: tuple[float, float, float] = (1.0, 1.0, 1.0)
    unit: str | None = None
    geometry: Geometry | None = None
    plane_geometries: tuple[Geometry, ...] = ()
    volume_range: tuple[int, int] | None = None
    notes: Texts = ()
    volume_notes: Texts = ()
    plane_word: str = "plane"
    series: Texts = ()
    series_number: int = 0
    has_plane_spacing: bool = False
    hounsfield: bool | None = None
    has_colors: bool = False
    levels: MultiscaleImage | None = None
    interval: float | None = None
    channel_styles: tuple[tuple[str, str], ...] = ()

    @property
    def default_plane(self) -> int:
        """Index of the plane that is read by default: the middle one of a volume, whatever the kind of file."""
        return self.shape[0] // 2 if self.plane_word == "plane" or self.has_plane_spacing else 0


def read_plane(stack: Stack, reading: Reading) -> DecodedImage:
    """Read one plane of a stack; for frames, which are points in time, one of these.

    Raises
    ------
    UnreadableError
        When there is no such plane, or it is too large.
    """
    planes, rows, columns = stack.shape
    check_pixel_count(stack.name, rows, columns)
    notes = list(stack.notes)
    frames = planes == 1 and stack.times > 1 and reading.time is None
    count = stack.times if frames else planes
    page = select_index("page", reading.page, count, 0 if frames else stack.default_plane, stack.name)
    if count > 1 and reading.page is None:
        notes.append(
            f"It is a volume, of which {stack.plane_word} {page + 1} of {count} was taken."
            if stack.default_plane and not frames
            else f"Only the first of its {count} {stack.plane_word}s was taken."
        )
    time, plane = (page, 0) if frames else (_select_part(stack, "time", reading.time, stack.times, notes), page)
    channel = _select_part(stack, "channel", reading.channel, stack.channels, notes)
    found = _select_first_plane(stack.read_planes(time, channel, plane, plane + 1))
    place = stack.plane_geometries[plane] if stack.plane_geometries else None
    if place is None and stack.geometry is not None:
        place = replace(stack.geometry.starting_at((plane, 0, 0), stack.spacing), depth=stack.spacing[0])
    return _add_metadata(found, stack, place, notes)


def read_volume(stack: Stack, reading: Reading) -> DecodedImage:
    """Read all planes of a stack at one time and in one channel; frames become planes.

    Raises
    ------
    ValueError
        When they are too few for a volume, or do not fit into memory.
    """
    first, end = stack.volume_range or (0, stack.shape[0])
    frames = stack.shape[0] == 1 and stack.times > 1
    notes = [*stack.notes, *(() if frames else stack.volume_notes)]  # those are on planes, which frames are not
    count = stack.times if frames else end - first
    rows, columns = stack.shape[1:]
    if count < MINIMUM_SIDE and stack.volume_range is not None:
        raise UnreadableError(
            f"{stack.name}: {' '.join(stack.volume_notes)} A volume needs at least {MINIMUM_SIDE} planes: resample "
            "them evenly with the program that made them, or take one as an image."
        )
    if count == 1:
        raise UnreadableError(
            f"{stack.name} has the shape {(rows, columns)}, but a volume has three, (planes, rows, columns): use an "
            "image with --circle instead, or save one volume of it."
        )
    if stack.volume_range is not None:
        notes.append(ONLY_THESE_NOTE)
    check_memory((count, rows, columns), stack.bytes_per_voxel + _GRAY_LEVEL_MEMORY, stack.name)
    channel = _select_part(stack, "channel", reading.channel, stack.channels, notes)
    if frames:
        notes.append(f"Its {count} {stack.plane_word}s, which are points in time, were taken as planes.")
        found = stack_planes([_select_first_plane(stack.read_planes(time, channel, 0, 1)) for time in range(count)])
    else:
        found = stack.read_planes(_select_part(stack, "time", reading.time, stack.times, notes), channel, first, end)
    geometry = stack.geometry
    if geometry is not None and first:
        geometry = geometry.starting_at((first, 0, 0), stack.spacing)
    if geometry is not None and geometry.slant > MAX_SILENT_SLANT:
        notes.append(
            f"Its axes are {geometry.slant:.1f}° off right angles; lengths were taken as if they were at right angles."
        )
    return _add_metadata(found, stack, geometry, notes)


def _add_metadata(found: DecodedImage, stack: Stack, place: Geometry | None, notes: list[str]) -> DecodedImage:
    """Add what the file states to the pixels that were read; notes on planes are merged."""
    said, spacing = dict.fromkeys(found.notes), stack.spacing[-found.values.ndim :]
    return replace(
        found, spacing=spacing, unit=stack.unit, geometry=place, hounsfield=stack.hounsfield, notes=(*notes, *said)
    )


def stack_planes(planes: Sequence[DecodedImage]) -> DecodedImage:
    """Stack images of shape (1, H, W) or (H, W) as planes; gray ones among colored ones get gray colors.

    The window is that of the plane in the middle, as the first one of a patient may show nothing but air.
    """
    values = planes[0].values[np.newaxis] if len(planes) == 1 else np.stack([plane.values for plane in planes])
    notes = tuple(dict.fromkeys(note for plane in planes for note in plane.notes))
    white = next((plane.colors.white for plane in planes if plane.colors is not None), None)
    if white is None:
        return DecodedImage(values, notes=notes, window=planes[len(planes) // 2].window)
    colors = [
        np.repeat(np.clip(np.rint(255.0 / white * plane.values[..., None]), 0, 255).astype(np.uint8), 3, axis=-1)
        if plane.colors is None
        else plane.colors.samples
        for plane in planes
    ]
    samples = colors[0][np.newaxis] if len(colors) == 1 else np.stack(colors)
    return DecodedImage(values, notes=notes, colors=Colors(samples, white))


def _select_first_plane(found: DecodedImage) -> DecodedImage:
    """Select the first plane of a volume."""
    colors = found.colors and replace(found.colors, samples=found.colors.samples[0])
    return replace(found, values=found.values[0], colors=colors)


def stack_from_levels(levels: MultiscaleImage) -> Stack:
    """Return the stack of an image at several resolutions, at the finest level with a moderate number of pixels."""
    planes = levels.axis_length("z")
    fitting = (
        k for k in range(len(levels.arrays)) if math.prod(levels.axis_length(a, k) for a in "zyx") <= MAXIMUM_PIXELS
    )
    level = next(fitting, len(levels.arrays) - 1)
    shape = (levels.axis_length("z", level), levels.axis_length("y", level), levels.axis_length("x", level))

    def read_planes(time: int, channel: int, first: int, end: int) -> DecodedImage:
        found = levels.read_planes(level, time, channel, slice(first, end), (slice(None), slice(None)))
        same = planes == shape[0] and end == first + 1
        return replace(found, finer=levels.find_finer_planes(level, time, channel, first) if same else ())

    notes: Texts = ()
    if level:
        notes = (
            f"It has {format_size(levels.shape)}, of which level {level} was opened, {shape[1]} x {shape[2]} px; "
            "cpm run with --auto works on all of them.",
        )
    sides = (planes / shape[0], levels.shape[0] / shape[1], levels.shape[1] / shape[2])
    deep, row, col = (size * side for size, side in zip(levels.spacing, sides, strict=True))
    return Stack(
        levels.name,
        shape,
        read_planes,
        float(levels.arrays[level].dtype.itemsize * levels.axis_length("s")),
        levels.axis_length("t"),
        levels.axis_length("c"),
        (deep, row, col),
        levels.unit,
        notes=notes,
        series=levels.series,
        series_number=levels.series_number,
        levels=levels,
        channel_styles=levels.channel_styles,
    )


def position_from_affine(affine: Array, convention: Convention, sides: Sequence[float], unit: str) -> VolumePosition:
    """Return the position of a volume by the affine matrix of a file.

    Parameters
    ----------
    affine : ndarray, shape (4, 4)
        Maps (col, row, plane, 1) to (x, y, z, 1).
    convention : {"LPS", "RAS"}
        Orientation of x, y and z.
    sides : sequence of float
        Size of a voxel along (plane, row, col), used if the matrix is invalid.
    unit : str
        Unit of length.

    Returns
    -------
    VolumePosition
        Voxel size, unit, geometry, and notes.
    """
    try:
        geometry, spacing = geometry_from_affine(affine, convention)
    except ValueError:
        plane, row, col = sides if all(math.isfinite(side) and side > 0.0 for side in sides) else (1.0, 1.0, 1.0)
        return (plane, row, col), unit, None, ("Its matrix is not valid, so that it is not known where it lies.",)
    return spacing, unit, geometry, ()


def check_memory(shape: Extent, each: float, name: str) -> None:
    """Raise UnreadableError, naming a size that fits, if memory cannot hold `each` bytes per voxel."""
    try:
        check_field_memory(shape, each, name)
    except ValueError as error:
        raise UnreadableError(str(error)) from None


def decode_header_line(line: bytes) -> str:
    """Decode a line of a header: as UTF-8, or as Latin-1 where it is none."""
    try:
        return line.decode()
    except UnicodeDecodeError:
        return line.decode("latin-1")


def find_values_of_pair(header: Path) -> Path:
    """Find the values of a pair of NIfTI or Analyze, .img next to .hdr; UnreadableError if there are none."""
    return find_data_file(header, header.stem + (".IMG" if header.suffix.isupper() else ".img"))


def find_data_file(header: Path, named: str) -> Path:
    """Find the data file that a header names; UnreadableError unless it is a single file in the same folder."""
    place = Path(named)
    data = header.parent / place
    if "\0" in named or place.is_absolute() or ".." in place.parts or not data.is_file():
        raise UnreadableError(
            f"{header.name} keeps its values in {quote_value(place.name)}, which is not a single file next to it: "
            "put both in one folder, or save it as one file."
        )
    return data


def _select_part(stack: Stack, what: str, wanted: int | None, count: int, notes: list[str]) -> int:
    """Return the index of a channel or a point in time, by default the first, which is noted."""
    if wanted is None and what == "channel" and stack.has_colors:
        return ALL_COLORS
    if wanted is None and count > 1:
        words = "points in time" if what == "time" else "channels"
        notes.append(f"Only the first of its {count} {words} was taken.")
    return select_index(what, wanted, count, 0, stack.name)


PageAxis = Literal["z", "t", "c"]
"""Planes, points in time, channels."""


@dataclass(frozen=True, eq=False, repr=False)
class Pages(Sequence[Image]):
    """Pages of a file; none is kept in memory, so a long stack takes no more than one page.

    Attributes
    ----------
    name : str
        Name of the file.
    length : int
        Number of pages.
    read_page : callable
        Reads a page by its number from 1; ValueError when it cannot be used.
    page_word : str
        Name of a page: page or frame.
    axis : {"z", "t", "c"}
        Axis of the pages: planes, points in time, channels.
    has_single_axis : bool
        Whether the file has no further axis, along which one part is selected.
    sha256 : str
        Hash of the file.
    interval : float or None
        Time from page to page [s], if they are points in time and the file states it.
    """

    name: str
    length: int
    read_page: Callable[[int], Image]
    page_word: str = "page"
    axis: PageAxis = "z"
    has_single_axis: bool = True
    sha256: str = ""
    interval: float | None = None

    def __len__(self) -> int:
        return self.length

    @overload
    def __getitem__(self, index: int) -> Image: ...

    @overload
    def __getitem__(self, index: slice) -> Pages: ...

    def __getitem__(self, index: int | slice) -> Image | Pages:
        """Read a page by its index from 0; the pages of a slice are read on demand."""
        places = range(self.length)[index]
        if isinstance(places, range):
            return replace(self, length=len(places), read_page=lambda number: self.read_page(places[number - 1] + 1))
        return self.read_page(places + 1)

    def __repr__(self) -> str:
        return format_repr("Pages", self.name, format_count(len(self), self.page_word))
