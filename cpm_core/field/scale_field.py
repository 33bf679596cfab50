"""The field of one scale: edge map, image gradient and Lorentz force, ready for interpolation."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import field, replace
from functools import cache, cached_property, partial
from typing import Any

import numpy as np
import scipy
from numpy.typing import DTypeLike

from cpm_core.field.convolution import WindowedField, convolved_field, convolved_potential
from cpm_core.field.edge_map import background_strength, gradient_in_window, smoothed_gradient, vector_magnitudes
from cpm_core.field.interpolation import interpolate_field
from cpm_core.field.region_contrast import region_contrast
from cpm_core.image.border import dilate_by_distance, find_pixels_inside_border
from cpm_core.image.regions import NO_BARRIERS, BarrierMap, Regions, build_barrier_map
from cpm_core.numerics.grids import (
    Window,
    expand_window,
    relative_window,
    run_in_bands,
    split_into_tiles,
    whole_window,
    window_at,
    window_shape,
)
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Extent, Mask, Single, copy_with, record

ON_EDGE_FORCE = 0.93
"""Interpolated |F_l| under which a particle is on an edge: across an edge it falls linearly through zero."""

WEAKEST_EDGE = 0.08
"""Least strength of an edge on which particles are inserted, as a fraction of the largest edge strength."""

EDGE_END_FRACTION = 0.35
"""Fraction to which the strength of an edge may fall from one position on it to the next; below it the edge has
ended."""

MAX_BACKGROUND = 0.35
"""Largest background, as a fraction of the largest edge strength; an image or volume above it is full of edges."""

_ON_RIDGE_FRACTION = 0.6
"""Fraction of the strongest neighbor above which a pixel is on an edge."""

_OFF_RIDGE_FRACTION = 0.4
"""Fraction of the strongest neighbor below which a pixel is next to an edge."""

_KEPT_BEYOND_INTEREST = 4
"""Distance beyond the regions of interest up to which the edge map is kept, so that edges inside are complete [px]."""

_SUMMIT_REACH = np.int64(2)  # one function compiled for both; see `interpolation`
"""Distance in which the ridge of an edge is searched [px]."""

_FIELD_REACH = np.int64(1)
"""Distance in which the largest field next to a ridge is searched [px]."""

_FORCE_OVERLAP = int(_SUMMIT_REACH) + 1
"""Lines beyond a part of the image on which its forces depend: a central difference within reach of a ridge."""

_STRENGTH_ROWS = 128
"""Rows of a large image whose edge strength is computed together: smoothing reads some more."""

_FIELD_TILE_SIDE = 948
"""Side of the windows in which the field of a large image is computed [px]; with the pixels needed around them the
transforms are fast."""

FIELD_PRECISION: DTypeLike = np.float32
"""The transforms of the field are done in single precision: only its direction and its values near edges are used. The
force changes by about 1e-6, contours of shapes by less than a thousandth of a pixel."""

SPLINE_MARGIN = 3
"""Pixels by which spline coefficients continue beyond the border, so that none is missing near it."""

LARGE_IMAGE_PIXELS = 2**22
"""Pixels above which an image counts as large: its fields are kept in single precision and made only when a run needs
them."""


WindowGradient = Callable[[Window], Array]
"""Returns the gradient of an image in a window."""


_EVERYWHERE = np.zeros((0, 0), bool)
"""Area of a start that is everywhere."""


@record
class ScaleField:
    r"""Fields of one scale of an image.

    Attributes
    ----------
    force : callable
        Computes `packed`, on first use.
    slopes : callable
        Returns `smoothed_gradient` in a window of the image.
    edge_map : ndarray, shape (\*shape)
        Edge strength f [gray levels / px], kept to a little beyond the regions of interest.
    values : ndarray, shape (\*shape)
        The image.
    strongest : float
        Largest edge strength [gray levels / px].
    holding : float
        Least edge strength that holds particles.
    fixed_charges : ndarray, shape (\*shape)
        Size of the fixed charges that make the field: the edge map where it is not below the edge floor, inside the
        regions of interest and the image border.
    floor : float
        Least edge strength for edge contact.
    smoothing : float
        Sigma of the Gaussian [px].
    exponent : float or None
        Power of the distance with which the force of a fixed charge decays; None for the number of dimensions.
    barrier_map : BarrierMap
        Barriers, which particles do not cross.
    area : ndarray of bool, shape (\*shape)
        Area that a start lies in; empty where it is everywhere.
    cut : bool
        Whether the edge map has been cut: the force is that of the uncut one, the magnitude of the gradient.
    corner : tuple of int
        First pixel of the window of the image that the field covers.
    whole : ScaleField or None
        The field of the whole image, where this one is a part of it.
    """

    force: Callable[[], Single]
    slopes: WindowGradient
    edge_map: Array
    values: Array
    strongest: float
    holding: float
    fixed_charges: Array
    floor: float
    smoothing: float
    exponent: float | None = None
    barrier_map: BarrierMap = NO_BARRIERS
    area: Mask = field(default_factory=lambda: _EVERYWHERE)
    cut: bool = False
    corner: tuple[int, ...] = (0, 0)
    whole: ScaleField | None = None

    def crop(self, window: Window) -> ScaleField:
        """Crop the field to a window of the image; its force, computed for the window alone, is that of all charges."""
        made_of = self._windowed, self.slopes, self.edge_map, self.holding, self.cut
        corner = tuple(side.start for side in window)
        return replace(
            self,
            force=cache(partial(_pack_force_in_window, *made_of, window)),
            slopes=lambda part: self.slopes(
                tuple(slice(at + side.start, at + side.stop) for at, side in zip(corner, part, strict=True))
            ),
            edge_map=np.ascontiguousarray(self.edge_map[window]),
            values=self.values[window],
            fixed_charges=self.fixed_charges[window],
            barrier_map=self.barrier_map.crop_to_window(window),
            area=np.ascontiguousarray(self.area[window]) if self.area.size else self.area,
            corner=corner,
            whole=self,
        )

    @cached_property
    def gradient(self) -> Array:
        r"""Gradient of the smoothed image, shape (D, \*shape) [gray levels / px]; on an edge it is normal to it."""
        return np.ascontiguousarray(self.slopes(whole_window(self.shape)))

    @cached_property
    def _windowed(self) -> WindowedField:
        return WindowedField(self.fixed_charges, self.exponent)

    @property
    def packed(self) -> Single:
        r"""Packed force field, float32 of shape (\*shape, 2 D + 1).

        Normalized Lorentz force, `smoothed_gradient` and `edge_map` of each pixel side by side, so that a particle
        reads one place in memory; single precision is enough for the force.
        """
        return self.force()

    @property
    def lorentz(self) -> Single:
        r"""Normalized Lorentz force on the pixels, shape (D, \*shape)."""
        return np.moveaxis(self.packed, -1, 0)[: self.packed.ndim - 1]

    def strength_at(self, points: Array) -> Array:
        """Interpolate the edge strength at points, shape (N, D), as shape (N,)."""
        return interpolate_field(self.edge_map[None], points)[:, 0]

    def normals_at(self, points: Array) -> Array:
        """Interpolate the image gradient at points, shape (N, D); on an edge it is normal to it."""
        return interpolate_field(self.gradient, points)

    def contrast_at(self, points: Array) -> Array:
        """Return the contrast, shape (N,), of the regions on both sides of an edge, at points on it, shape (N, D)."""
        return region_contrast(self.values, points, self.normals_at(points), self.smoothing)

    @cached_property
    def spline(self) -> Array:
        """Cubic spline coefficients of the edge map, continued by `SPLINE_MARGIN` pixels beyond the border."""
        spline = np.empty([n + 2 * SPLINE_MARGIN for n in self.shape], self.edge_map.dtype)
        inner = (slice(SPLINE_MARGIN, -SPLINE_MARGIN),) * spline.ndim
        scipy.ndimage.spline_filter(self.edge_map, order=3, output=spline[inner], mode="nearest")
        for axis in range(spline.ndim):
            line = np.moveaxis(spline, axis, 0)
            line[:SPLINE_MARGIN], line[-SPLINE_MARGIN:] = line[SPLINE_MARGIN], line[-SPLINE_MARGIN - 1]
        return spline

    @cached_property
    def potential(self) -> Array:
        r"""Potential of all fixed charges of the image, shape (\*shape) [gray levels]."""
        if self.whole is not None:
            return self.whole.potential[self.window]
        return convolved_potential(self.fixed_charges, exponent=self.exponent)

    @cached_property
    def slope(self) -> float:
        """Mean slope of the potential [gray levels / px]; 1 where it is flat."""
        if self.whole is not None:
            return self.whole.slope
        slope = float(vector_magnitudes(smoothed_gradient(self.potential, 0.0)).mean())
        return slope if slope > 0.0 else 1.0

    @property
    def window(self) -> Window:
        """Window of the image that the field covers."""
        return window_at(self.corner, self.shape)

    @property
    def shape(self) -> Extent:
        """Shape of the image at this scale."""
        return self.edge_map.shape


def build_scale_field(
    values: Array,
    smoothing: float,
    edge_floor: float,
    regions: Regions | None = None,
    max_border: float = 0.0,
    exponent: float | None = None,
    slopes: WindowGradient | None = None,
    barrier_map: BarrierMap | None = None,
) -> ScaleField:
    r"""Build the fields of one scale.

    Parameters
    ----------
    values : ndarray, shape (\*shape)
        Image at its scale.
    smoothing : float
        Gaussian before the gradient [px].
    edge_floor : float
        Fraction of the largest edge strength below which no fixed charge is placed; 0 places all of them, and the
        background decides how weak an edge may be.
    regions : Regions, optional
        Regions of interest and barriers, in px of the scale. Outside the regions of interest there is no fixed charge,
        and only the inside decides on the largest edge strength and the background.
    max_border : float
        Width up to which an image border is searched, as a fraction of the shortest side; 0 for none.
    exponent : float, optional
        Power of the distance with which the force of a fixed charge decays; by default the number of dimensions.
    slopes, barrier_map : optional
        Gradient of the smoothed image in a window, and barriers, where they are known.
    """
    slopes = slopes or gradient_provider(values, smoothing)
    strength = _edge_strength(slopes, values.shape)
    if barrier_map is None:
        barrier_map = NO_BARRIERS if regions is None else build_barrier_map(regions, values.shape)
    inside = find_pixels_inside_border(slopes, strength, smoothing, max_border)
    if regions is not None and regions.interest:
        inside &= regions.pixel_mask(values.shape)
    strongest = float(strength.max(where=inside, initial=0.0))
    field = ScaleField(
        partial(pack_force, exponent, strength, slopes, strength, 0.0, False),
        slopes,
        strength,
        values,
        strongest,
        0.0,
        strength,
        weakest_edge(strength if inside.all() else strength[inside], strongest, edge_floor),
        smoothing,
        exponent,
        barrier_map,
    )
    return charge_edges(field, inside, edge_floor)


def charge_edges(field: ScaleField, inside: Mask, edge_floor: float) -> ScaleField:
    r"""Place the fixed charges of a field, by its largest edge strength, on edges `inside`, shape (\*shape).

    Edges farther outside are cut from the edge map. `edge_floor` is that of `build_scale_field`.
    """
    cut, strength, holding = not inside.all(), field.edge_map, WEAKEST_EDGE * field.strongest
    charged, nothing = strength, strength.dtype.type(0)
    if edge_floor > 0.0 or cut:
        charged = np.where(inside & (strength >= edge_floor * field.strongest), strength, nothing)
    if cut:
        strength = np.where(dilate_by_distance(inside, _KEPT_BEYOND_INTEREST), strength, nothing)
    force = cache(partial(pack_force, field.exponent, charged, field.slopes, strength, holding, cut))
    return replace(field, force=force, holding=holding, edge_map=strength, fixed_charges=charged, cut=cut)


def gradient_provider(values: Array, smoothing: float) -> WindowGradient:
    r"""Return a function that gives the gradient of a smoothed image, shape (\*shape), in a window.

    Of a large image the gradient is computed there when needed.
    """
    if values.size > LARGE_IMAGE_PIXELS:
        return partial(gradient_in_window, values, smoothing)
    known = smoothed_gradient(values, smoothing)
    return lambda window: known[(slice(None), *window)]


def _edge_strength(slopes: WindowGradient, shape: Extent) -> Array:
    """Return the edge strength of an image, shape (H, W): the size of its gradient."""
    if math.prod(shape) <= LARGE_IMAGE_PIXELS:
        return vector_magnitudes(slopes(whole_window(shape)))
    strength: Array = np.empty(shape, FIELD_PRECISION)

    def write_strength(first: int, end: int) -> None:
        strength[first:end] = vector_magnitudes(slopes((slice(first, end), slice(0, shape[1]))))

    run_in_bands(write_strength, shape[0], _STRENGTH_ROWS)
    return strength


def pack_force(
    exponent: float | None, charged: Array, slopes: WindowGradient, strength: Array, holding: float, cut: bool
) -> Single:
    """Compute `ScaleField.packed`, shape (H, W, 5), from fixed charges, image gradient and edge map, shape (H, W)."""
    known, packed = (slopes, strength, holding, cut), np.empty((*strength.shape, 5), np.float32)
    if strength.size <= LARGE_IMAGE_PIXELS:
        every = whole_window(strength.shape)
        _write_packed(convolved_field(charged, exponent, FIELD_PRECISION), *known, every, every, packed)
        return packed
    field = WindowedField(charged, exponent)
    for tile in split_into_tiles(strength.shape, _FIELD_TILE_SIDE):  # one after the other: each uses all cores
        packed[tile] = _pack_force_in_window(field, *known, tile)
    return packed


def _pack_force_in_window(
    field: WindowedField, slopes: WindowGradient, strength: Array, holding: float, cut: bool, window: Window
) -> Single:
    """Compute `pack_force` in a window of a large image."""
    packed = np.empty((*window_shape(window), 5), np.float32)
    outer = expand_window(window, _FORCE_OVERLAP, strength.shape)
    _write_packed(
        field.field_in_window(outer), slopes, strength, holding, cut, outer, relative_window(window, outer), packed
    )
    return packed


def _write_packed(
    field: Single,
    slopes: WindowGradient,
    strength: Array,
    holding: float,
    cut: bool,
    window: Window,
    inner: Window,
    packed: Single,
) -> None:
    """Write `pack_force` in the part `inner` of a window in which the field is known."""
    # kernels are compiled for one layout of all images and windows
    field, grad, length = map(np.ascontiguousarray, (field, slopes(window), strength[window]))
    write_lorentz_force(
        field, grad, vector_magnitudes(grad) if cut else length, holding, packed, (inner[0].start, inner[1].start)
    )
    if cut:
        packed[..., 4] = length[inner]


def weakest_edge(strength: Array, strongest: float, edge_floor: float) -> float:
    """Return the least edge strength for edge contact from strengths of any shape; see `build_scale_field`."""
    if strongest == 0.0:  # a coarse scale may have no pixel inside
        return np.inf
    if edge_floor > 0.0:
        return max(WEAKEST_EDGE, edge_floor) * strongest
    return max(WEAKEST_EDGE * strongest, min(background_strength(strength), MAX_BACKGROUND * strongest))


def write_lorentz_force(
    field: Single, grad: Array, strength: Array, holding: float, packed: Single, first: tuple[int, int] = (0, 0)
) -> None:
    r"""Write the normalized Lorentz force on the pixels, of at most unit size, the gradient and the edge strength.

    Away from edges the force is the unit vector of the field (section 3.3). On an edge there are three differences:

    - The field is divided by its largest size next to the edge and not by its own, so that the force falls linearly
      through zero where the field does. Unit vectors would round that position to the middle between two pixels.
    - The part along the edge is removed. On the ridge it is all that is left of the field. Scaled up, it would pull
      particles from weak to strong parts of the edge and keep them circling; motion along an edge is left to the
      Coulomb force.
    - Where the field points away from the ridge, as it does all across a weak edge next to a strong one, the slope of
      the edge map takes its place, so that every edge of at least `holding` keeps its particles.

    Parameters
    ----------
    field : ndarray, shape (2, H, W)
        Electric field.
    grad, strength : ndarray, shapes (2, H, W) and (H, W)
        Image gradient, and its size.
    holding : float
        Least edge strength that holds particles.
    packed : ndarray, shape (h, w, 5)
        Output, as `ScaleField.packed`.
    first : tuple of int
        The pixel that it begins with.
    """
    kind = grad.dtype.type
    least = float(np.finfo(kind).tiny)
    tiny = max(1e-12 * float(vector_magnitudes(field).max()), least)
    levels = (
        _OFF_RIDGE_FRACTION,
        _ON_RIDGE_FRACTION - _OFF_RIDGE_FRACTION,
        holding,
        least,
        max(1e-12 * holding / WEAKEST_EDGE, least),
        tiny,
    )
    limits = tuple(map(kind, levels))
    rows, cols = strength.shape

    def write_band(begin: int, end: int) -> None:
        low, high = max(first[0] + begin - _FORCE_OVERLAP, 0), min(first[0] + end + _FORCE_OVERLAP, rows)
        lines, largest = np.empty((7, high - low, cols), kind), np.empty((4, cols), kind)
        _write_force(field, grad, strength, limits, packed, first, low, lines, largest, begin, end)

    run_in_bands(write_band, len(packed))


@compiled
def _write_force(
    field: Single,
    grad: Array,
    strength: Array,
    limits: tuple[Any, ...],
    packed: Single,
    corner: tuple[int, int],
    low: int,
    lines: Array,
    largest: Array,
    first: int,
    end: int,
) -> None:
    """Write `write_lorentz_force` on some lines.

    `lines`, shape (7, N, W), has room for seven numbers of each pixel from line `low` on, `largest` for four more of a
    line.
    """
    slope_at, span, weakest, least, faintest, tiny = limits
    kind = strength.dtype.type
    one, zero, half = kind(1.0), kind(0.0), kind(0.5)
    rows, cols = strength.shape
    high = low + lines.shape[1]
    # one by one: Numba does not see that parts of an array that is unpacked are contiguous
    size, normal_y, normal_x, slope = lines[0], lines[1], lines[2], lines[3]
    summits, sizes, slopes = lines[4], lines[5], lines[6]
    steep, summit, beside, steepest = largest[0], largest[1], largest[2], largest[3]
    for r in range(high - low):
        for c in range(cols):
            f_y, f_x = kind(field[0, low + r, c]), kind(field[1, low + r, c])
            size[r, c] = np.sqrt(f_y * f_y + f_x * f_x)
            length = max(strength[low + r, c], faintest)
            normal_y[r, c], normal_x[r, c] = grad[0, low + r, c] / length, grad[1, low + r, c] / length
        _dilate_line(strength[low + r], _SUMMIT_REACH, summits[r])
        _dilate_line(size[r], _FIELD_REACH, sizes[r])
    for r in range(high - low):  # towards the ridge on the flank of the edge, of unit size where the flank is steepest
        i, above, below = low + r, max(low + r - 1, 0), min(low + r + 1, rows - 1)
        for c in range(cols):
            slope[r, c] = zero  # lines that nothing depends on
        if low <= above and below < high:
            for c in range(1, cols - 1):
                s_y, s_x = strength[below, c] - strength[above, c], strength[i, c + 1] - strength[i, c - 1]
                slope[r, c] = half * s_y * normal_y[r, c] + half * s_x * normal_x[r, c]
            for c in (0, cols - 1):
                s_x = strength[i, min(c + 1, cols - 1)] - strength[i, max(c - 1, 0)]
                s_y = strength[below, c] - strength[above, c]
                slope[r, c] = half * s_y * normal_y[r, c] + half * s_x * normal_x[r, c]
        for c in range(cols):
            steep[c] = abs(slope[r, c])
        _dilate_line(steep, _SUMMIT_REACH, slopes[r])
    for n in range(first, end):
        i, r = corner[0] + n, corner[0] + n - low
        _max_over_lines(summits, r, _SUMMIT_REACH, summit)
        _max_over_lines(sizes, r, _FIELD_REACH, beside)
        _max_over_lines(slopes, r, _SUMMIT_REACH, steepest)
        for m in range(packed.shape[1]):
            c = corner[1] + m
            near = min(max((strength[i, c] / max(summit[c], least) - slope_at) / span, zero), one)
            near = near if summit[c] >= weakest else zero
            scale = max(beside[c] * near, size[r, c], tiny)
            f_y, f_x = kind(field[0, i, c]) / scale, kind(field[1, i, c]) / scale
            across, up = f_y * normal_y[r, c] + f_x * normal_x[r, c], slope[r, c] / max(steepest[c], least)
            across = (up if across * up < zero else across) * near
            packed[n, m, 0] = f_y * (one - near) + normal_y[r, c] * across
            packed[n, m, 1] = f_x * (one - near) + normal_x[r, c] * across
            packed[n, m, 2], packed[n, m, 3], packed[n, m, 4] = grad[0, i, c], grad[1, i, c], strength[i, c]


@compiled
def _dilate_line(line: Array, reach: np.int64, out: Array) -> None:
    """Write the largest of the values up to a distance along a line."""
    for c in range(len(line)):
        out[c] = line[c]
    for k in range(1, reach + 1):
        for c in range(len(line) - k):
            out[c] = max(out[c], line[c + k])
        for c in range(len(line) - k):
            out[c + k] = max(out[c + k], line[c])


@compiled
def _max_over_lines(lines: Array, at: int, reach: np.int64, out: Array) -> None:
    """Write the largest of the values in lines up to a distance from one of them."""
    first = max(at - int(reach), 0)
    for c in range(len(out)):
        out[c] = lines[first, c]
    for k in range(first + 1, min(at + int(reach) + 1, len(lines))):
        for c in range(len(out)):
            out[c] = max(out[c], lines[k, c])


def unit_vectors(vectors: Array) -> Array:
    r"""Scale every vector of a field, shape (D, \*shape), to length one; vanishing vectors stay at zero."""
    length = vector_magnitudes(vectors)
    tiny = 1e-12 * float(length.max(initial=0.0))
    scale = np.where(length > tiny, 1.0 / np.maximum(length, max(tiny, 1e-300)), 0.0)
    return vectors * scale


def limit_field(scale_field: ScaleField, area: Mask, floor: float) -> ScaleField:
    """Return this field for a start in an area, shape (H, W), where weaker edges than a floor hold no particle."""
    if scale_field.values.size > LARGE_IMAGE_PIXELS:
        _ = scale_field._windowed  # made once for all starts
    holding = max(floor, scale_field.holding)
    made_of = scale_field.exponent, scale_field.fixed_charges, scale_field.slopes, scale_field.edge_map
    return copy_with(
        scale_field,
        force=cache(partial(pack_force, *made_of, holding, scale_field.cut)),
        holding=holding,
        floor=max(floor, scale_field.floor),
        area=area,
    )
