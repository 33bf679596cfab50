"""Image: the gray levels that a run works on, and their origin."""

from __future__ import annotations

import hashlib
import math
import os
from dataclasses import InitVar
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from cpm_core.image import drawing
from cpm_core.image.colors import (
    LUMINANCE_CHOICE,
    Colors,
    ReducedSamples,
    check_color_choice,
    extract_channel,
    gray_from_color,
    reduce_to_gray,
)
from cpm_core.image.geometry import Geometry
from cpm_core.image.gray_levels import NO_DATA_VALUE, find_shown_range, make_usable
from cpm_core.numerics.memory import check_field_memory
from cpm_core.numerics.real_numbers import as_real_array, check_voxel_sides
from cpm_core.numerics.types import Array, Extent, Mask, Numbers, Sides, Texts, copy_with, record
from cpm_core.parameters.formatting import format_count, format_repr, format_size, quote_value

MINIMUM_SIDE = 8
"""Least number of pixels along each axis [px]: in smaller images the edges cannot be separated from the border."""

_BYTES_PER_VOXEL = 40
"""Memory that a run on a volume takes for each voxel [bytes]."""

_MAX_STORED_BYTES = 2
"""Bytes of an integer up to which an image stores gray levels in the type in which they are given."""

_AXIS_COUNTS = {2: "two", 3: "three"}
"""Number of axes -> word for it."""


_CT_AIR = -1000.0
"""Gray level of air [Hounsfield units]."""

_CT_AIR_RANGE = (-3072.0, -900.0)
"""Range of the least gray level of a CT image whose file does not name one."""


@record
class Image(drawing.Pictured):
    """Gray levels on a regular grid, pixel centers at integers: an image (row, col) or a volume (plane, row, col).

    Parameters
    ----------
    stored : array_like of real numbers, shape (H, W), (P, H, W), (H, W, 3) or (H, W, 4)
        Gray levels. They are copied, unless they are in an array that owns its memory and is read-only, and are then
        read-only. Pixels without data, masked ones and NaN, are filled, and extreme gray levels divided by a power of
        ten (`gray_levels.make_usable`). Three or four values a pixel are red, green, blue and opacity, from which
        `color` makes gray levels. Images of integers of one or two bytes keep their type, all others hold float64;
        `values` is float64 always.
    spacing : tuple of float, optional
        Size of a pixel along each axis, in `unit`; 1 px each where it is not known.
    unit : str, optional
        Unit of length of `spacing`, such as ``"µm"``; None when the size of a pixel is not known.
    source : str, optional
        Name of the image, for display.
    notes : tuple of str, optional
        Changes between the file and `values`, one sentence each.
    colors : Colors, optional
        Colors of the pixels, for display; None for a gray image.
    file_sha256 : str, optional
        Hash of its file, as `compute_fingerprint` makes it; empty for an image that is not from a file.
    geometry : Geometry, optional
        Position in space; None where it is not known. Written files keep it.
    hounsfield : bool, optional
        Whether gray levels are Hounsfield units; None where the file does not say, see `is_ct`.
    finer : tuple, optional
        The same image with two, four and more times the rows and columns, the finest first, for display: objects with
        a `shape`, of which a window is read by index. Contours are found in `values`.
    window : tuple of float, optional
        Gray levels that the file asks to show as black and as white, as DICOM does; None where it does not.
    color : {"luminance", "red", "green", "blue", "contrast"}, optional
        How gray levels are made of color, as in `load_image`: brightness to the eye, one of its channels, or
        the channel whose gray levels vary the most. With the luminance the image keeps its colors, so that
        `Parameters.channel` can choose another one for a run.

    Raises
    ------
    ValueError
        When `stored` is not a grid of two or three axes of real numbers, at least `MINIMUM_SIDE` pixels along each,
        when it holds infinite ones or no data at all, when `spacing` is not one positive number for each axis, or when
        `colors` has another shape.

    Examples
    --------
    >>> image = cpm.Image(np.hypot(*np.indices((40, 60))), spacing=(0.5, 0.5), unit="µm", source="drawn")
    >>> image
    <Image drawn, 40 x 60 px, 0.5 µm a pixel>
    >>> image.shape, image.ndim, [round(level, 1) for level in image.gray_range], image.sha256[:8]
    ((40, 60), 2, [0.0, 70.7], '2cd5ef8e')
    >>> small = cpm.Image(np.eye(8, dtype=np.uint8))
    >>> small.gray_levels_in((slice(0, 2), slice(0, 3))).tolist()
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    >>> small.stored.dtype.name, small.values.dtype.name
    ('uint8', 'float64')
    >>> image.is_ct, cpm.Image(np.eye(8), hounsfield=True).is_ct
    (False, True)
    >>> hot = np.where(np.indices((40, 60)).sum(axis=0) == 0, 4095.0, np.asarray(image))
    >>> [round(level, 1) for level in cpm.Image(hot).shown_range]  # without the hot pixel
    [1.0, 70.7]
    >>> image.with_spacing((2.0, 2.0), "mm")
    <Image drawn, 40 x 60 px, 2 mm a pixel>
    >>> cpm.example("ball").slice_across(axis=0, index=15)
    <Image ball, 31 x 31 px, 1 mm a pixel>
    >>> colored = cpm.example("colors")
    >>> colored.resolve_channel("red"), colored.gray_levels("red").max().item(), colored.gray_at((32, 32), "green")
    ('red', 220.0, 50.0)
    >>> cpm.Image(colored.colors.samples, color="contrast").notes
    ('The channel red of its colors was taken, which varies the most.',)
    >>> np.asarray(image).shape, image.dtype.name, round(float(np.mean(image)), 1)
    ((40, 60), 'float64', 38.1)
    >>> axes = image.plot()
    """

    stored: Numbers
    spacing: Sides = ()
    unit: str | None = None
    source: str = "image"
    notes: tuple[str, ...] = ()
    colors: Colors | None = None
    file_sha256: str = ""
    geometry: Geometry | None = None
    color: InitVar[str] = LUMINANCE_CHOICE
    hounsfield: bool | None = None
    finer: tuple[Any, ...] = ()
    window: tuple[float, float] | None = None

    def __post_init__(self, color: str) -> None:
        check_color_choice(color)
        given, mask = np.asarray(self.stored), np.ma.getmask(self.stored)
        colors, notes = self.colors, self.notes
        if given.dtype.kind not in "buif":
            raise ValueError(f"{self.source} holds values of type {given.dtype}, but gray levels must be real numbers.")
        if given.ndim == 3 and given.shape[-1] in (3, 4) and min(given.shape[:2]) >= MINIMUM_SIDE:
            given, found, said = _reduce_colors(given, color)
            colors, notes = found or colors, (*notes, *said)
        _check_shape(self.source, given.shape)
        stored, changes = _check_gray_levels(self.source, given, mask if isinstance(mask, np.ndarray) else None)
        spacing = _check_spacing(self.source, self.spacing, stored.ndim)
        if colors is not None and colors.samples.shape != (*stored.shape, 3):
            raise ValueError(
                f"The colors of {self.source} have the shape {colors.samples.shape}, "
                f"but must have {(*stored.shape, 3)}."
            )
        object.__setattr__(self, "stored", stored)
        object.__setattr__(self, "spacing", spacing)
        object.__setattr__(self, "notes", (*notes, *changes))
        object.__setattr__(self, "colors", colors)

    @cached_property
    def values(self) -> Array:
        """Gray levels in double precision, in the shape of the image; read-only.

        Integers are converted when they are first asked for, so that the image can be shown before.
        """
        values = self.stored.astype(np.float64, copy=False)
        values.flags.writeable = False
        return values

    def __repr__(self) -> str:
        known = self.unit is not None or len(set(self.spacing)) > 1
        sides = self.spacing[:1] if len(set(self.spacing)) == 1 else self.spacing
        size = f"{' x '.join(f'{side:.4g}' for side in sides)} {self.unit or ''}".strip()
        word = ("voxels", "voxel") if self.ndim == 3 else ("px", "pixel")
        return format_repr(
            "Image", self.source, format_size(self.shape, word[0]), f"{size} a {word[1]}" if known else "",
            "in color" if self.colors is not None else "",
        )  # fmt: skip

    def plot(self, ax: drawing.Axes | None = None, *, scale_bar: bool = True) -> drawing.Axes:
        """Draw the image by matplotlib; of a volume its middle plane.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where; by default in a new figure.
        scale_bar : bool
            Whether there is a scale bar, in px where the size of a pixel is not known.

        Returns
        -------
        matplotlib.axes.Axes
            The axes, in px of the image: row 0 is on top.

        Raises
        ------
        ValueError
            When `ax` are no axes of matplotlib.
        """
        ax = drawing.axes_for(ax)
        plane = self.values if self.ndim == 2 else self.values[self.shape[0] // 2]
        spacing = self.spacing[-2:]
        drawing.show_image(ax, plane, spacing, None if self.colors is None else self.colors.samples)
        if scale_bar:
            drawing.show_scale_bar(ax, plane.shape, spacing, self.unit)
        return ax

    @cached_property
    def sha256(self) -> str:
        """Hash of its file, or of `values` as float64, little-endian and row by row, where there is no file."""
        if self.file_sha256:
            return self.file_sha256
        found = hashlib.sha256()
        for line in self.stored:  # without copying the whole array
            found.update(np.ascontiguousarray(line, "<f8").data)
        return found.hexdigest()

    @cached_property
    def gray_range(self) -> tuple[float, float]:
        """Least and largest gray level."""
        return float(self.stored.min()), float(self.stored.max())

    @cached_property
    def shown_range(self) -> tuple[float, float]:
        """Gray levels that are shown as black and as white: all but hot pixels and padding far from all others."""
        return self.gray_range if self.colors is not None else find_shown_range(self.stored)

    @cached_property
    def is_ct(self) -> bool:
        """Whether gray levels are Hounsfield units: by the file, or by a place in space and the gray level of air.

        Air has -1000 units. Outside of the scanner's circle the least level is at most as low as 12 bits of them. One
        below that of air which no other below 0 follows is padding.
        """
        if self.hounsfield is not None or self.geometry is None or self.colors is not None:
            return bool(self.hounsfield)
        (lowest, highest), darkest = _CT_AIR_RANGE, self.shown_range[0]
        if not lowest <= darkest <= highest:
            return False
        return darkest >= _CT_AIR or bool(self.stored.min(where=self.stored > darkest, initial=0) < 0)

    def with_spacing(self, spacing: Sides, unit: str | None, factor: float = 1.0) -> Image:
        """Return the image with another size of a pixel and shared gray levels; ValueError as for an image.

        `factor` of the new unit make one of the present unit: the place in space is converted.
        """
        sizes = _check_spacing(self.source, spacing, self.ndim)
        geometry = None if self.geometry is None else self.geometry.scaled(factor)
        # integers are converted once for both images
        return copy_with(self, values=self.values, spacing=sizes, unit=unit, geometry=geometry)

    def slice_across(self, axis: int, index: int) -> Image:
        """Return a slice of a volume across an axis, as an image that shares the gray levels without another check."""
        sides = tuple(side for other, side in enumerate(self.spacing) if other != axis)
        plane = self.values[(slice(None),) * axis + (index,)]
        return copy_with(object.__new__(Image), stored=plane, spacing=sides, unit=self.unit, source=self.source)

    @property
    def shape(self) -> Extent:
        """Number of pixels along each axis, (rows, columns) or (planes, rows, columns)."""
        return self.stored.shape

    def gray_levels(self, channel: str = "luminance") -> Array:
        """Return the gray levels of a channel of `Parameters.channel`, in the shape of the image."""
        return extract_channel(self.values, self.colors, channel)

    def gray_at(self, pixel: tuple[int, ...], channel: str = "luminance") -> float:
        """Return the gray level of a pixel (row, col), or of a voxel (plane, row, col), in a channel."""
        return float(self.gray_levels_in(tuple(slice(at, at + 1) for at in pixel), channel).item())

    def gray_levels_in(self, window: tuple[slice, ...], channel: str = "luminance") -> Array:
        """Return the gray levels of a channel in a window, without converting the rest of the image."""
        colors = self.colors and Colors(self.colors.samples[window], self.colors.white)
        return extract_channel(self.stored[window], colors, channel).astype(np.float64, copy=False)

    def resolve_channel(self, wanted: str) -> str:
        """Return the name of the channel that is used when one is wanted: a gray image has its luminance alone."""
        return wanted if self.colors is not None else "luminance"

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return self.stored.ndim

    @property
    def dtype(self) -> np.dtype[np.float64]:
        """Type of `values`, which the image is for NumPy."""
        return np.dtype(np.float64)

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> Numbers:
        return np.array(self.values, dtype, copy=copy)


def _reduce_colors(samples: Numbers, color: str) -> ReducedSamples:
    """Reduce colors, shape (H, W, 3) or (H, W, 4), to gray levels; the colors are returned with luminance alone."""
    alpha = samples[..., 3] if samples.shape[-1] == 4 else None
    gray, colors, notes = reduce_to_gray(np.array(samples[..., :3]), alpha)
    if colors is None or color == LUMINANCE_CHOICE:
        return gray, colors, notes
    gray, note = gray_from_color(gray, colors, color)
    return gray, None, (note, *notes[1:])


def _check_shape(source: str, shape: Extent) -> None:
    """Raise a `ValueError` unless an image or a volume has this shape and a run on the volume fits into memory."""
    if len(shape) not in (2, 3) or (len(shape) == 3 and shape[-1] < MINIMUM_SIDE):
        raise _not_a_plane_error(source, shape)
    if len(shape) == 3 and min(shape) < MINIMUM_SIDE:
        raise ValueError(
            f"{source} has {format_size(shape, 'voxels')}, but a volume needs at least {MINIMUM_SIDE} "
            "planes, rows and columns."
        )
    if min(shape) < MINIMUM_SIDE:
        raise ValueError(
            f"{source} is {format_size(shape)}, but an image needs at least {MINIMUM_SIDE} px along each side."
        )
    if len(shape) == 3:
        check_field_memory(shape, _BYTES_PER_VOXEL, source)


def _check_gray_levels(source: str, given: Numbers, masked: Mask | None) -> tuple[Numbers, Texts]:
    r"""Return gray levels as an image stores them, shape (\*shape), and what was changed; ValueError if not finite.

    `masked`, shape (\*shape) or (\*shape, 3 or 4), marks pixels without data.
    """
    with np.errstate(invalid="ignore"):  # of NaN of the signaling kind
        masked = _find_absent(given, masked)
    small = given.ndim == 2 and given.dtype.kind in "ui" and given.itemsize <= _MAX_STORED_BYTES and masked is None
    dtype = given.dtype if small else np.dtype(np.float64)
    stays = given.flags.owndata and given.flags.c_contiguous and not given.flags.writeable  # nobody writes to it
    if masked is None and stays and given.dtype == dtype:
        stored = given
    else:
        with np.errstate(invalid="ignore"):
            stored = np.array(given, dtype, order="C")
    if masked is not None:
        if masked.all():
            raise ValueError(f"{source} holds no data: all its values are NaN or masked.")
        stored[masked] = NO_DATA_VALUE
        given = stored
    ends = float(given.min()), float(given.max())  # faster on few bytes per pixel than on eight
    if not all(map(math.isfinite, ends)):
        unusable = stored.size - int(np.isfinite(stored).sum())
        raise ValueError(
            f"{source} holds {format_count(unusable, 'infinite value')}: replace by NaN what has no data, the rest by "
            "numbers."
        )
    stored, changes = make_usable(stored, ends)
    stored.flags.writeable = False
    return stored, changes


def _find_absent(given: Numbers, masked: Mask | None) -> Mask | None:
    r"""Find the pixels without data, shape (\*shape): those that are masked, and NaN; None without any mask or NaN."""
    if masked is not None and masked.ndim > given.ndim:
        masked = np.asarray(masked.any(axis=-1))
    if given.dtype.kind != "f" or not math.isnan(float(given.min())):  # which is NaN if one is
        return masked
    return np.isnan(given) if masked is None else np.isnan(given) | masked


def _check_spacing(source: str, spacing: Sides, ndim: int) -> tuple[float, ...]:
    """Check the size of a pixel along each axis, 1 where none is given; ValueError when it is not valid."""
    sizes = tuple(np.ravel(as_real_array(spacing)).tolist()) or (1.0,) * ndim
    if len(sizes) != ndim or not all(math.isfinite(size) and size > 0 for size in sizes):
        raise ValueError(
            f"The spacing of {source} is {quote_value(spacing)}, but must be {_AXIS_COUNTS[ndim]} positive numbers."
        )
    if ndim == 3:
        check_voxel_sides(f"The spacing of {source}", sizes)
    return sizes


def as_plane(values: ArrayLike | Image) -> Image:
    """Convert values, shape (H, W), to an image of two axes; ValueError for any other shape."""
    image = as_image(values)
    if image.ndim != 2:
        raise _not_a_plane_error(image.source, image.shape)
    return image


def as_image(values: ArrayLike | Image) -> Image:
    """Convert values, shape (H, W) or (P, H, W), to an image or a volume."""
    if isinstance(values, str | os.PathLike):
        raise ValueError(f"{quote_value(os.fspath(values))} is a path, and no image: open it by load_image first.")
    return values if isinstance(values, Image) else Image(values)  # type: ignore[arg-type]


def _not_a_plane_error(source: str, shape: Extent) -> ValueError:
    return ValueError(
        f"{source} has {len(shape)} dimension{'' if len(shape) == 1 else 's'} {shape}, "
        "but an image has two, (rows, columns): choose one plane of it."
    )
