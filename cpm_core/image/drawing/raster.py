"""Small pictures as PNG, drawn by Pillow: what notebooks show of an image and of what was found in it."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Sequence
from typing import Protocol

import numpy as np
import PIL.Image
import PIL.ImageDraw
from numpy.typing import NDArray

from cpm_core.image.drawing.palette import BRIGHTEST, CLOSED, DARKEST, EXTREMES, HALO, OPEN, PARTICLE
from cpm_core.numerics.types import Array

SIDE = 384
"""Length of the longer side of a picture, about [px]."""

_FINE = 2
"""Pixels along a side that become one, so that lines are smooth."""

_LINE, _RIM, _DOT = 2.0, 4.0, 2.0
"""Width of a line and of its halo, and radius of a dot [px of the picture]."""

_GAP = 4
"""Space between the slices of a volume [px]."""

_EMPTY = 0.2
"""Gray of a picture without an image, from 0 to 1."""

Bytes = NDArray[np.uint8]


class Curve(Protocol):
    """A line to draw."""

    @property
    def path(self) -> Array:
        """Vertices, shape (K, 2), the first repeated at the end where the line is closed [px]."""

    @property
    def closed(self) -> bool:
        """Whether it is closed."""

    @property
    def color(self) -> str:
        """Its color, ``"#rrggbb"``; empty for the usual one."""


def color_of(curve: Curve) -> str:
    """The color in which a curve is drawn."""
    return curve.color or (CLOSED if curve.closed else OPEN)


def picture(
    values: Array | None,
    shape: tuple[int, ...],
    spacing: Sequence[float],
    curves: Sequence[Curve] = (),
    dots: Array | None = None,
    colors: Bytes | None = None,
) -> bytes:
    """A picture as PNG: an image of two axes or the middle slices of a volume, with curves and dots.

    Parameters
    ----------
    values : ndarray, shape (H, W) or (P, H, W), or None
        Gray levels; None for an empty ground.
    shape : tuple of int
        Shape of the image.
    spacing : sequence of float
        Size of a pixel along each axis: pixels that are not square are drawn as wide as they are.
    curves : sequence of Curve
        Lines in the plane.
    dots : ndarray, shape (N, 2) or (N, 3), optional
        Places [px]; in a volume those within half a voxel of a slice are drawn on it.
    colors : ndarray of uint8, shape (H, W, 3), optional
        Colors of the pixels in place of gray levels.
    """
    if len(shape) == 2:
        ground = _empty(shape) if values is None else colors if colors is not None else gray(values)
        return _png(_drawn(ground, spacing, SIDE, curves, dots))
    slices = []
    levels = None if values is None else gray(values)
    for axis in range(3):
        middle = shape[axis] // 2
        plane = tuple(side for at, side in enumerate(shape) if at != axis)
        ground = _empty(plane) if levels is None else np.take(levels, middle, axis)
        near = None if dots is None else np.delete(dots[np.abs(dots[:, axis] - middle) <= 0.5], axis, axis=1)
        slices.append(_drawn(ground, np.delete(np.asarray(spacing, dtype=float), axis), SIDE // 2, (), near))
    width = sum(part.width for part in slices) + _GAP * (len(slices) - 1)
    whole = PIL.Image.new("RGB", (width, max(part.height for part in slices)), HALO)
    left = 0
    for part in slices:
        whole.paste(part, (left, 0))
        left += part.width + _GAP
    return _png(whole)


def gray(values: Array) -> Bytes:
    """Gray levels as brightness from 0 to 255, their extremes such that lines can be seen on them."""
    low, high = np.percentile(values, EXTREMES)
    shares = (values - low) / max(high - low, 1e-300)
    level = 255.0 * (DARKEST + (BRIGHTEST - DARKEST) * np.clip(shares, 0.0, 1.0))
    return np.asarray(np.rint(level), dtype=np.uint8)


def in_html(png: bytes, line: str) -> str:
    """A picture with a line of text below it, as HTML."""
    data = base64.b64encode(png).decode("ascii")
    text = html.escape(line.strip("<>"))
    return f'<figure style="margin:0"><img alt="{text}" src="data:image/png;base64,{data}"><br>{text}</figure>'


def _empty(shape: tuple[int, ...]) -> Bytes:
    return np.full(shape, round(255 * _EMPTY), np.uint8)


def _drawn(
    ground: Bytes, spacing: Sequence[float] | Array, side: int, curves: Sequence[Curve], dots: Array | None
) -> PIL.Image.Image:
    """A plane with lines and dots, its longer side about `side` long."""
    rows, cols = ground.shape[:2]
    tall, wide = float(spacing[0]), float(spacing[1])
    zoom = _FINE * side / max(rows * tall, cols * wide)
    down, right = zoom * tall, zoom * wide
    size = (max(_FINE, round(cols * right)), max(_FINE, round(rows * down)))
    larger = PIL.Image.Resampling.NEAREST if min(down, right) >= 1.0 else PIL.Image.Resampling.BOX
    canvas = PIL.Image.fromarray(ground).convert("RGB").resize(size, larger)
    pen = PIL.ImageDraw.Draw(canvas)
    scale = np.array([right, down])
    lines = [(color_of(curve), ((curve.path[:, ::-1] + 0.5) * scale).ravel().tolist()) for curve in curves]
    for width, halo in ((_RIM, HALO), (_LINE, "")):
        for color, path in lines:
            pen.line(path, fill=halo or color, width=round(_FINE * width), joint="curve")
    if dots is not None and len(dots):
        for radius, color in ((_DOT + 0.75, HALO), (_DOT, PARTICLE)):
            for col, row in ((dots[:, ::-1] + 0.5) * scale).tolist():
                reach = _FINE * radius
                pen.ellipse((col - reach, row - reach, col + reach, row + reach), fill=color)
    return canvas.resize((max(1, size[0] // _FINE), max(1, size[1] // _FINE)), PIL.Image.Resampling.BOX)


def _png(picture: PIL.Image.Image) -> bytes:
    stream = io.BytesIO()
    picture.save(stream, format="PNG", optimize=True)
    return stream.getvalue()
