"""Reach of a start: the edges of an image reached on free flight, beyond a weak edge, over a junction, or not at all.

- On flight it reaches the edges that bound the object that it lies in or has been drawn around (`bounding`), and all
  those around the region that holds most of it, where they are unambiguous (`unambiguous`).
- Beyond a weak edge a particle coasts as far as friction lets it: ``w2 / beta^2``, the distance in which the speed
  ``w2 / beta`` of free flight is lost.
- Over junctions a front creeps along every edge that is connected to one already reached. Repulsion drives it against
  the hold of the edges, ``w1 / (w2 - w1)``, for as many steps as annealing leaves, ``1 / (1 - a)``: the parameter
  `reach` is the distance at the weights and the annealing of the paper.
"""

from __future__ import annotations

import numpy as np
import scipy
import skimage
from numpy.typing import NDArray

from cpm_core.contours.contour import ReachedBy
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics.grids import true_bounds
from cpm_core.numerics.types import Array, Extent, Mask, record
from cpm_core.parameters import UNLIMITED_REACH, Parameters
from cpm_core.segmentation.reach.bounding import MIN_DAMPING, Bounds, find_bounds
from cpm_core.segmentation.reach.unambiguous import unambiguous_edges

REACH_WAYS: tuple[ReachedBy, ...] = ("", "flight", "weak", "junction", "launched")
"""Ways by their numbers in a `ReachMap`."""

_WAY_FLIGHT = 1
"""Number of the way by free flight."""

_WAY_WEAK = 2
"""Number of the way beyond a weak edge."""

_WAY_JUNCTION = 3
"""Number of the way over junctions."""

_WAY_LAUNCHED = 4
"""Number of an edge that only reseeded particles reach."""

_MIN_SENSE_COSINE = 0.5
"""Cosine of the angle up to which an edge along the boundary may be turned against it."""

_BOUNDARY_EDGE_DISTANCE = 1.0
"""Distance of an edge from the boundary that it makes, beyond the smoothing of the latter [px]."""


_WINDOW_FRAME_WIDTH = 4.0
"""Distance from the end of a window, and twice the smoothing, in which edges mean nothing [px]."""

_USUAL_PUSH = 1.6 / (1.75 - 1.6)
"""Ratio of push to hold, ``w1 / (w2 - w1)``, at the weights of the paper."""

_USUAL_ANNEALING = 0.99
"""Annealing of the paper."""


@record
class ReachMap:
    """Reach of a start: the way by which it reaches each edge of an image.

    Attributes
    ----------
    way : ndarray of uint8, shape (H, W)
        Index in `REACH_WAYS` of each pixel of an edge, 0 off edges.
    ridge : ndarray of bool, shape (H, W)
        Pixels on the ridge of an edge.
    crept : ndarray of float32, shape (H, W)
        Distance along edges from those reached on flight or beyond a weak edge [px]; infinite where there is no way.
    corner : tuple of int
        First pixel of the window of the image that the map covers.
    shape : tuple of int
        Shape of the image.
    leaves : bool
        Whether the area that the start lies in reaches the end of the window.
    """

    way: NDArray[np.uint8]
    ridge: Mask
    crept: NDArray[np.float32]
    corner: tuple[int, ...]
    shape: Extent
    leaves: bool

    def ridge_within(self, budget: float) -> Mask:
        """Return the pixels, shape (H, W), on the ridges of edges reached by creeping up to a distance [px]."""
        return self.ridge & np.isfinite(self.crept) & (self.crept <= budget)

    def way_of(self, points: Array) -> ReachedBy:
        """Return how most of a contour with vertices of shape (K, 2) [px] is reached; empty where it is on no edge."""
        place = np.clip(np.rint(points).astype(int), 0, np.array(self.shape) - 1) - self.corner
        place = place[((place >= 0) & (place < self.way.shape)).all(axis=1)]
        votes = np.bincount(self.way[tuple(place.T)], minlength=len(REACH_WAYS))
        return REACH_WAYS[int(votes[1:].argmax()) + 1] if votes[1:].any() else ""


def creeping_distance(parameters: Parameters) -> float:
    """Return the distance that fronts creep over junctions [px]."""
    if parameters.reach >= UNLIMITED_REACH:
        return float("inf")
    push = parameters.w1 / (parameters.w2 - parameters.w1) / _USUAL_PUSH
    steps = (1.0 - _USUAL_ANNEALING) / (1.0 - parameters.annealing) if parameters.annealing < 1.0 else float("inf")
    return parameters.reach * push * steps if parameters.reach > 0.0 and push > 0.0 else 0.0


def is_limited(parameters: Parameters) -> bool:
    """Return whether it depends on the start which edges are reached."""
    return parameters.reach < UNLIMITED_REACH or parameters.weakest_edge > 0.0


def build_reach_map(scale_field: ScaleField, start: Array, closed: Mask, parameters: Parameters) -> ReachMap | None:
    """Find how a start reaches the edges of an image; None for one from everywhere or bounded by no edge.

    Parameters
    ----------
    scale_field : ScaleField
        Fields of the image itself.
    start : ndarray, shape (N, 2)
        Seeds [px].
    closed : ndarray of bool, shape (H, W)
        Where no particle goes.
    parameters : Parameters
        For `beta`, `w2` and `weakest_edge`.
    """
    bounds = find_bounds(scale_field.values.astype(np.float64, copy=False), start, closed, parameters.beta)
    if bounds is None:
        return None
    ridge = _find_ridge(scale_field)
    if not bounds.boundary.any():
        return None
    certain = unambiguous_edges(scale_field.edge_map, ridge, bounds.area)
    away = scipy.ndimage.distance_transform_edt(~bounds.boundary)
    beside = away <= _BOUNDARY_EDGE_DISTANCE + bounds.sigma
    if bounds.whole and parameters.weakest_edge > 0.0:
        along = ridge & beside
        ridge[along] = _has_sense(scale_field, bounds, along)
    flight = ridge & beside
    ridge[ridge] = scale_field.edge_map[ridge] >= parameters.weakest_edge * _first_met_strength(
        scale_field.edge_map, bounds, flight, ridge
    )
    ridge |= certain
    flight = (flight & ridge) | certain
    coasted = ridge & (away <= parameters.w2 / max(parameters.beta, MIN_DAMPING) ** 2) & ~flight
    if not (flight | coasted).any():
        return None
    edges = scipy.ndimage.binary_dilation(ridge, np.ones((3, 3), bool))
    along, _ = skimage.graph.MCP_Geometric(np.where(edges, 1.0, np.inf)).find_costs(np.argwhere(flight | coasted))
    crept = along.astype(np.float32)
    way = np.where(np.isfinite(crept), _WAY_JUNCTION, np.where(edges, _WAY_LAUNCHED, 0)).astype(np.uint8)
    way[coasted], way[flight] = _WAY_WEAK, _WAY_FLIGHT
    shape = (scale_field.whole or scale_field).shape
    return ReachMap(way, ridge, crept, scale_field.corner, shape, _leaves_window(bounds, scale_field.corner, shape))


def _leaves_window(bounds: Bounds, corner: tuple[int, ...], shape: Extent) -> bool:
    """Return whether the area inside a boundary reaches an end of its window that is no border of the image."""
    if not bounds.inside.any():
        return False
    first, last = true_bounds(bounds.inside)
    end, near = np.array(bounds.inside.shape) - 1, _WINDOW_FRAME_WIDTH + 2.0 * bounds.sigma
    beyond = (first < near) & (np.array(corner) > 0), (last > end - near) & (end + corner + 1 < shape)
    return bool(np.any(beyond))


def _find_ridge(scale_field: ScaleField) -> Mask:
    """Return the pixels on the ridge of an edge: neither of the two neighbors across it is stronger."""
    strength = scale_field.edge_map
    ridge = np.zeros(strength.shape, bool)
    place = np.argwhere(strength >= scale_field.floor)
    if not len(place):
        return ridge
    here = strength[tuple(place.T)]
    normal = scale_field.gradient[(slice(None), *place.T)].T / np.maximum(here, 1e-300)[:, None]
    both = [scale_field.strength_at(place + sign * normal) for sign in (-1.0, 1.0)]
    top = (here >= both[0]) & (here >= both[1])
    ridge[tuple(place[top].T)] = True
    return ridge


def _first_met_strength(strength: Array, bounds: Bounds, flight: Mask, ridge: Mask) -> Array:
    """Return the median strength of the edges around the part of the enclosed area nearest to each pixel of a ridge."""
    parts, count = scipy.ndimage.label(bounds.inside)
    medians = np.zeros(count + 1)
    if not count or not flight.any():
        return medians[np.zeros(np.count_nonzero(ridge), int)]
    nearest = scipy.ndimage.distance_transform_edt(parts == 0, return_distances=False, return_indices=True)
    around = parts[tuple(axis[flight] for axis in nearest)]
    found = np.unique(around)
    medians[found] = scipy.ndimage.median(strength[flight], around, found)
    return medians[parts[tuple(axis[ridge] for axis in nearest)]]


def _has_sense(scale_field: ScaleField, bounds: Bounds, along: Mask) -> Mask:
    """Return a mask, shape (K,), of the selected pixels where the image rises across the boundary as along most of it.

    Fields of the whole image are made one at a time: at 6000 x 6000 pixels each takes 288 MB.
    """
    soft = scipy.ndimage.gaussian_filter(bounds.inside.astype(float), 1.0 + bounds.sigma, mode="nearest")
    down, right = np.gradient(soft, axis=0)[along], np.gradient(soft, axis=1)[along]
    del soft
    across = down * scale_field.gradient[0][along] + right * scale_field.gradient[1][along]
    curve, count = scipy.ndimage.label(bounds.boundary, np.ones((3, 3), bool))
    nearest = scipy.ndimage.distance_transform_edt(~bounds.boundary, return_distances=False, return_indices=True)
    curve = curve[tuple(axis[along] for axis in nearest)]
    sign = np.where(np.bincount(curve, across, minlength=count + 1) < 0.0, -1.0, 1.0)
    return sign[curve] * across >= _MIN_SENSE_COSINE * np.hypot(down, right) * scale_field.edge_map[along]
