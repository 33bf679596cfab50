"""Structures that have a skeleton: the edges that count, the polarity, and the largest width.

Where the outlines in an image are closed, regions are distinguished by gray level, and any width counts. Elsewhere, as
in an angiogram, only strips of one polarity can be distinguished from the background: objects and background are
connected through the gaps, and only the two edges on its sides identify a strip. In a dark object the image gets
lighter outward across each of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.field.edge_map import background_strength
from cpm_core.field.scale_field import ScaleField
from cpm_core.medial_axis.boundary import Boundary, find_boundary
from cpm_core.medial_axis.medial_axis import MedialAxis, compute_medial_axis, label_axis_parts, prune_axis, trim_tips
from cpm_core.numerics.types import Array, Extent, Mask, record
from cpm_core.parameters import Parameters

_PIXEL_VARIANCE = 1.0 / 3.0 + 1.0 / 12.0
"""Variance that central differences, and the area of the pixels, add to that of the Gaussian [px²]."""

_MIN_HALF_WIDTH = 0.05
"""Least half width of lines that are corrected, in widths of the smoothed step."""

_LARGEST_HALF_WIDTH = 6.0
"""Largest half width of lines that are corrected, in widths of the smoothed step: wider ones need no correction."""


def smoothed_step_width(smoothing: float) -> float:
    """Return the width of a smoothed step: the standard deviation of its slope, with pixels and differences [px]."""
    return float(np.sqrt(smoothing**2 + _PIXEL_VARIANCE))


def correct_half_width(distance: Array, smoothing: float) -> Array:
    """Correct the distance of ridges from the center line, shape (N,), to the half width of the line, shape (N,) [px].

    The smoothing pushes the two edges of a thin line apart. With s the width of the smoothed step, the ridge of an edge
    at h from the center line lies at d where ``(d - h) / (d + h) = exp(-2 d h / s²)``: for a line of 3 px and the usual
    smoothing of 1 px that is 0.12 px too far out; from 5 px on the difference is negligible. The result is at most d.
    """
    half = np.geomspace(_MIN_HALF_WIDTH, _LARGEST_HALF_WIDTH, 400)
    low, high = half.copy(), half + 1.5
    for _ in range(40):  # the ridge lies above the root of an increasing function
        middle = 0.5 * (low + high)
        beyond = (middle - half) > (middle + half) * np.exp(-2.0 * middle * half)
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    scale = smoothed_step_width(smoothing)
    corrected = scale * np.interp(distance / scale, high, half)
    return np.where(distance < scale * high[-1], np.minimum(corrected, distance), distance)


DARK_POLARITY = -1
"""Polarity of regions darker than their surroundings; 0 stands for neither."""

LIGHT_POLARITY = 1
"""Polarity of regions lighter than their surroundings."""

_MIN_GRADIENT_COSINE = 0.3
"""Least cosine of the angle between the image gradient at an edge and the direction from the axis to it."""

_COMMON_POLARITY_SHARE = 0.8
"""Share of the objects' length that must have the same polarity for an image to have one."""

_MAX_MIXED_SHARE = 0.05
"""Largest share of all lengths that may lie between a darker and a lighter side, or in a region of the other polarity,
for an image to have one."""


def edge_polarities(axis: MedialAxis, boundary: Boundary) -> NDArray[np.int8]:
    """Compute the polarity of every edge of an axis, shape (M,): `DARK_POLARITY`, `LIGHT_POLARITY` or 0."""
    outward = boundary.points[axis.sides] - axis.middles[:, None]
    gradient = boundary.normals[axis.sides]
    size = np.linalg.norm(outward, axis=2) * np.linalg.norm(gradient, axis=2)
    rise = np.einsum("msk,msk->ms", outward, gradient) / np.maximum(size, 1e-300)
    dark, light = (rise > _MIN_GRADIENT_COSINE).all(axis=1), (rise < -_MIN_GRADIENT_COSINE).all(axis=1)
    return np.where(dark, DARK_POLARITY, np.where(light, LIGHT_POLARITY, 0)).astype(np.int8)


def select_polarity(axis: MedialAxis, polarity: NDArray[np.int8], sign: int) -> MedialAxis:
    """Select the parts of an axis whose edges have a polarity, given for all, shape (M,).

    A connected part is selected as a whole if nearly all of it has that polarity: at the sharp corners of a region,
    which smoothing rounds, the gradient does not point away from the axis.
    """
    length = axis.lengths
    count, part = label_axis_parts(axis)
    of_part = part[axis.edges[:, 0]]
    same = polarity == sign
    whole = np.bincount(of_part, length * same, count) >= (1.0 - _MAX_MIXED_SHARE) * np.bincount(of_part, length, count)
    return axis.select_edges(same | whole[of_part])


def find_common_polarity(
    axis: MedialAxis,
    boundary: Boundary,
    polarity: NDArray[np.int8],
    objects: Mask,
    shape: Extent,
) -> int:
    """Find the polarity that the objects of an image share; 0 if they share none.

    Parameters
    ----------
    axis, boundary
        Medial axis of all regions, and the edges between them.
    polarity : ndarray of int8, shape (M,)
        `edge_polarities` of its edges.
    objects : ndarray of bool, shape (M,)
        Which edges lie in objects.
    shape : tuple of int
        Shape of the image; parts outside have no effect.
    """
    inside = axis.is_in_rectangle(-0.5, np.array(shape) - 0.5)[axis.edges].all(axis=1)
    outward = boundary.points[axis.sides] - axis.middles[:, None]
    across = np.linalg.norm(outward[:, 1] - outward[:, 0], axis=1)
    # how far apart the sides of each edge are, 1 for opposite ones; small at irregularities
    breadth = (across / np.maximum(np.linalg.norm(outward, axis=2).sum(axis=1), 1e-300)) ** 2
    length = np.where(inside, axis.lengths * breadth, 0.0)
    count, part = label_axis_parts(axis)
    of_part = part[axis.edges[:, 0]]
    dark, light, mixed = (
        np.bincount(of_part, length * (polarity == sign), count) for sign in (DARK_POLARITY, LIGHT_POLARITY, 0)
    )
    whole = length.sum()
    if mixed.sum() > _MAX_MIXED_SHARE * whole or np.minimum(dark, light).sum() > _MAX_MIXED_SHARE * whole:
        return 0
    shares = [length[objects & (polarity == sign)].sum() for sign in (DARK_POLARITY, LIGHT_POLARITY)]
    if max(shares) <= _COMMON_POLARITY_SHARE * sum(shares):
        return 0
    return DARK_POLARITY if shares[0] > shares[1] else LIGHT_POLARITY


_COMPARISON_DISTANCE = 2.5
"""Distance from an edge at which gray levels are compared, in widths of its smoothed step."""

_COMPARISON_RADIUS_SHARE = 0.5
"""In narrower parts, the fraction of the largest radius at which gray levels are compared."""

_MIN_DIFFERENCE = 0.25
"""Fraction of an edge's contrast by which an object must differ from the background."""

_MIN_GRAY_SMOOTHING = 1.0
"""Least smoothing of the compared gray levels [px]."""


def find_edges_in_objects(axis: MedialAxis, boundary: Boundary, values: Array, smoothing: float) -> Mask:
    """Find the edges of an axis that lie in objects.

    The gray level of the background is the median at the image border. A connected part of the axis lies in an object
    if its gray level, near the surrounding edges as well as away from them, differs from the background by more than a
    quarter of the contrast of these edges, brighter or darker; so the hole of a ring is background.

    Parameters
    ----------
    axis, boundary
        Medial axis of all regions, and the edges between them.
    values : ndarray, shape (H, W)
        Gray values of the image.
    smoothing : float
        Sigma of the edge map [px].

    Returns
    -------
    ndarray of bool, shape (M,)
        For every edge of the axis.
    """
    if not len(axis.edges):
        return np.zeros(0, bool)
    clear = _COMPARISON_DISTANCE * smoothed_step_width(smoothing)
    # two positions are compared: the vertex itself and one just next to the edge, since beyond a sharp tip the object
    # is still visible for some distance, and far away there may be something else without edges
    share = np.minimum(clear / np.maximum(axis.radius, clear), 1.0)
    edge = boundary.points[axis.nearest]
    places = edge + share[:, None] * (axis.points - edge)
    border = np.concatenate([values[0], values[-1], values[:, 0], values[:, -1]])
    smooth = scipy.ndimage.gaussian_filter(values, max(smoothing, _MIN_GRAY_SMOOTHING), mode="nearest")
    gray = [scipy.ndimage.map_coordinates(smooth, where.T, order=1, mode="nearest") for where in (places, axis.points)]
    away = np.min(np.abs(np.array(gray) - np.median(border)), axis=0)
    contrast = (
        boundary.strength[axis.nearest] * np.sqrt(2.0 * np.pi) * smoothed_step_width(smoothing)
    )  # height of the steps
    inside = axis.is_in_rectangle(-0.5, np.array(values.shape) - 0.5)
    count, part = label_axis_parts(axis)
    every = np.arange(count)
    largest = scipy.ndimage.maximum(np.where(inside, axis.radius, 0.0), part, every)
    reliable = inside & (axis.radius >= np.minimum(clear, _COMPARISON_RADIUS_SHARE * largest[part]))
    seen = np.isin(every, part[reliable])
    difference, height = np.zeros(count), np.ones(count)
    difference[seen] = scipy.ndimage.median(away[reliable], part[reliable], every[seen])
    height[seen] = scipy.ndimage.median(contrast[reliable], part[reliable], every[seen])
    return (difference > _MIN_DIFFERENCE * height)[part[axis.edges[:, 0]]]


_MAX_RADIUS_CHANGE = 0.5
"""Greatest change of the radius along the axis, per length, between edges that count as opposite: the cosine of the
angle between the axis and the directions to the two sides."""

_MIN_STRIP_LENGTH = 3.0
"""Least length between opposite sure edges, in mean widths of a part of the axis."""

_MIN_OPPOSITE_SHARE = 0.3
"""Least share of a part of the axis that lies between opposite edges."""

_STRIP_WIDTH_QUANTILE = 0.95
"""Fraction of the strips, by length and strength, that the image's own width exceeds."""

_STRIP_WIDTH_FACTOR = 1.5
"""Factor by which the image's own width exceeds them: forks are wider than their arms."""


def select_strips(axis: MedialAxis, boundary: Boundary, width: float, sure: float) -> MedialAxis:
    """Select the parts of a pruned axis that lie in strips.

    Parameters
    ----------
    axis : MedialAxis
        Medial axis of regions of one polarity.
    boundary : Boundary
        Edges, faint ones included.
    width : float
        Largest width of a strip [px].
    sure : float
        Least strength of edges that make a strip unambiguous [gray levels / px].
    """
    thin = axis.part_narrower_than(width)

    def is_mouth(tip: int, following: int) -> bool:
        """Return whether a tip widens into an open region."""
        away = np.linalg.norm(thin.points[tip] - thin.points[following])
        return bool(thin.radius[tip] - thin.radius[following] > _MAX_RADIUS_CHANGE * away)

    cut = thin.keep_edges(trim_tips(thin, is_mouth))
    if not len(cut.edges):
        return cut
    count, part = label_axis_parts(cut)
    of_part, length = part[cut.edges[:, 0]], cut.lengths
    change = np.abs(np.diff(cut.radius[cut.edges], axis=1)[:, 0])
    opposite = change / np.maximum(length, 1e-300) <= _MAX_RADIUS_CHANGE
    strong = boundary.strength[cut.nearest[cut.edges]].mean(axis=1) >= sure
    total, between, certain, area = (
        np.bincount(of_part, weights, count)
        for weights in (
            length,
            length * opposite,
            length * (opposite & strong),
            length * cut.widths,
        )
    )
    kept = (certain * total >= _MIN_STRIP_LENGTH * area) & (between >= _MIN_OPPOSITE_SHARE * total)
    return cut.keep_edges(cut.edges[kept[of_part]])


def strip_evidence(found: MedialAxis, boundary: Boundary) -> float:
    """Sum the length of strips, in widths, times the strength of their edges [gray levels / px]."""
    return float((_edge_weights(found, boundary) / np.maximum(found.widths, 1e-300)).sum())


def typical_strip_width(found: MedialAxis, boundary: Boundary) -> float:
    """Estimate the width that nearly all of some strips stay well below [px]; 0 without any."""
    if not len(found.edges):
        return 0.0
    weights = _edge_weights(found, boundary)
    return _STRIP_WIDTH_FACTOR * float(
        np.quantile(found.widths, _STRIP_WIDTH_QUANTILE, weights=weights, method="inverted_cdf")
    )


def _edge_weights(found: MedialAxis, boundary: Boundary) -> Array:
    """Compute the length of each edge of an axis times the strength of the boundary next to it, shape (M,)."""
    return found.lengths * boundary.strength[found.nearest[found.edges]].mean(axis=1)


_MAX_LOOSE_SHARE = 0.5
"""Share of loose contours above which the outlines of an image do not count as closed."""

_MAX_STRIP_WIDTH = 0.125
"""Largest width considered for strips when none is given, as a fraction of the shorter side of the image."""

_USUAL_WIDTH_SHARE = 0.5
"""Usual width of strips, as a fraction of the largest."""

_STRIP_WIDTH_PER_SIGMA = 15.0
"""Width of strips per sigma of the smoothing that keeps their two edges apart."""

_MIN_STRIP_SIGMA = 1.0
"""Least sigma of the smoothing for strips [px]."""

_STRIP_EDGE_FLOOR = 0.5
"""Floor for the edges of strips, as a fraction of the background."""

_MIN_BACKGROUND = 0.04
"""Least background, as a fraction of the strongest edge."""


@record
class Structure:
    """Edges that have a skeleton, with their polarity and width.

    Attributes
    ----------
    boundary : Boundary
        The edges that count.
    smoothing : float
        Sigma of their edge map [px].
    polarity : int
        `DARK_POLARITY` or `LIGHT_POLARITY`; 0 for both.
    width : float
        Largest width [px]; 0 for any.
    sure : float or None
        Least strength of the edges of strips [gray levels / px]; None where whole regions count.
    """

    boundary: Boundary
    smoothing: float
    polarity: int
    width: float
    sure: float | None = None

    def prune_and_clip(self, axis: MedialAxis, pruning: float, shape: Extent) -> MedialAxis:
        """Prune an axis in an image of this shape, clip it, and leave out what is wider than allowed."""
        rest = prune_axis(axis, pruning).clip_to_rectangle(np.full(2, -0.5), np.array(shape) - 0.5)
        if self.sure is not None:
            return select_strips(rest, self.boundary, self.width, self.sure)
        return rest.part_narrower_than(self.width) if self.width else rest


def find_structure(field_of: Callable[[Parameters], ScaleField], parameters: Parameters) -> Structure:
    """Find the edges that count; `field_of` gives the fields of the image for any parameters.

    These are the usual ones where outlines are closed and no width is given. For strips there is less smoothing, as
    long as it is automatic, and edges may be half as strong as the background at its strongest; each strip then needs
    others above it.
    """
    usual = field_of(parameters)
    width, polarity = parameters.max_width, int(np.sign(parameters.polarity))
    if not width:
        boundary = find_boundary(usual, parameters)
        if boundary.loose <= _MAX_LOOSE_SHARE:
            return Structure(boundary, usual.smoothing, polarity, 0.0)
        width = _MAX_STRIP_WIDTH * min(usual.shape)
    finest = max(
        _MIN_STRIP_SIGMA, (1.0 if parameters.max_width else _USUAL_WIDTH_SHARE) * width / _STRIP_WIDTH_PER_SIGMA
    )
    if parameters.smoothing == "auto" and usual.smoothing > finest:
        usual = field_of(replace(parameters, smoothing=finest))
    strongest, strength = usual.strongest, usual.edge_map
    if parameters.edge_floor:
        faint = parameters.edge_floor * strongest
        sure = max(parameters.edge_floor, parameters.sure_edge) * strongest
    else:
        background = max(background_strength(strength[strength > 0.0]), _MIN_BACKGROUND * strongest)
        faint, sure = _STRIP_EDGE_FLOOR * background, parameters.sure_edge * strongest or background
    boundary = find_boundary(replace(usual, floor=faint), replace(parameters, sure_edge=0.0))
    return Structure(boundary, usual.smoothing, polarity, width, sure)


def find_axis(found: Structure, values: Array, parameters: Parameters) -> tuple[Structure, MedialAxis]:
    """Find the polarity and the width of strips in an image, shape (H, W), and its medial axis."""
    axis = compute_medial_axis(found.boundary, values.shape)
    sign = edge_polarities(axis, found.boundary)
    if found.sure is None:
        polarity = found.polarity
        objects = find_edges_in_objects(axis, found.boundary, values, found.smoothing)
        if not polarity:
            polarity = find_common_polarity(axis, found.boundary, sign, objects, values.shape)
        chosen = select_polarity(axis, sign, polarity) if polarity else axis.select_edges(objects)
        return replace(found, polarity=polarity), chosen
    options = [(p, select_polarity(axis, sign, p)) for p in (DARK_POLARITY, LIGHT_POLARITY) if found.polarity in (0, p)]
    tried = [found.prune_and_clip(option, parameters.pruning, values.shape) for _, option in options]
    best = np.argmax([strip_evidence(one, found.boundary) for one in tried])
    width = parameters.max_width or typical_strip_width(tried[best], found.boundary) or found.width
    polarity, axis = options[best]
    return replace(found, polarity=polarity, width=width), axis
