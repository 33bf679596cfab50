"""What the particles feel at one scale: edge map, image gradient and Lorentz force, ready for interpolation."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.contrast import region_contrast
from cpm_core.edge_map import background_strength, gradient, magnitude
from cpm_core.field.electric import electric_field
from cpm_core.field.interpolation import interpolate
from cpm_core.frame import inside_frame
from cpm_core.regions import Regions
from cpm_core.walls import NO_WALLS, Walls, build_walls

Array = NDArray[np.float64]

GATE = 0.93
"""Interpolated |F_l| under which a particle sits on an edge: across an edge it falls linearly through zero."""

WEAKEST_EDGE = 0.08
"""Fraction of the largest edge strength that an edge must have for particles to breed on it."""

FAINTEST = 0.35
"""Fraction to which the strength of an edge may fall from one place on it to the next; below it the edge has ended."""

_MOST_BACKGROUND = 0.35
"""Fraction of the largest edge strength beyond which an image that is full of edges is not taken for background."""

_RIDGE, _SLOPE = 0.6, 0.4
"""Fractions of the strongest neighbour: at the first a pixel is on an edge, under the second it is beside one."""

_MARGIN = 4.0
"""Distance beyond the regions of interest to which the edge map is kept, so that an edge inside is seen whole [px]."""

_SUMMIT_REACH, _FIELD_REACH = 5, 3
"""Pixels across the neighbourhoods in which the crest of an edge, and the largest field beside it, are looked for."""


@dataclass(frozen=True, eq=False)
class Level:
    r"""One scale of an image as the particles feel it.

    Attributes
    ----------
    felt : ndarray, shape (2 D + 1, \*shape)
        `lorentz`, `gradient` and `edge_map` in one, so that one interpolation gets a particle all of it.
    values : ndarray, shape (\*shape)
        The image.
    strongest : float
        Largest edge strength [grey levels / px].
    least_charge : float
        Edge strength under which a pixel carries no fixed charge.
    floor : float
        Edge strength under which there is no edge for a particle to sit on.
    smoothing : float
        The sigma that was used [px].
    walls : Walls
        What particles do not cross.
    """

    felt: Array
    values: Array
    strongest: float
    least_charge: float
    floor: float
    smoothing: float
    walls: Walls = NO_WALLS

    @property
    def lorentz(self) -> Array:
        r"""Normalised Lorentz force on the pixels, shape (D, \*shape)."""
        return self.felt[: self.felt.ndim - 1]

    @property
    def charges(self) -> Array:
        r"""Size of the fixed charges, shape (\*shape): the edge map where it is not under `least_charge`."""
        return np.where(self.edge_map >= self.least_charge, self.edge_map, 0.0)

    @property
    def gradient(self) -> Array:
        r"""Gradient of the smoothed image, shape (D, \*shape); on an edge it is normal to it."""
        return self.felt[self.felt.ndim - 1 : -1]

    @property
    def edge_map(self) -> Array:
        r"""Edge strength f [grey levels / px], shape (\*shape); minus it is the fixed charge in regions of interest."""
        strength: Array = self.felt[-1]
        return strength

    def strength(self, points: Array) -> Array:
        """Edge strength at points, shape (N, D), between the pixels."""
        return interpolate(self.edge_map[None], points)[:, 0]

    def contrast(self, points: Array) -> Array:
        """Contrast of the regions on both sides of an edge, at points on it, shape (N, D)."""
        normal = interpolate(self.gradient, points)
        return region_contrast(self.values, points, normal, self.smoothing)

    @cached_property
    def spline(self) -> Array:
        """Cubic spline coefficients of the edge map, for sub-pixel refinement."""
        coefficients: Array = scipy.ndimage.spline_filter(self.edge_map, order=3, mode="nearest")
        return coefficients

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the image at this scale."""
        return self.edge_map.shape


def build_level(
    values: Array, smoothing: float, edge_floor: float, regions: Regions | None = None, max_frame: float = 0.0
) -> Level:
    r"""Compute what particles feel in an image.

    Parameters
    ----------
    values : ndarray, shape (\*shape)
        Image at its scale.
    smoothing : float
        Gaussian before the gradient [px].
    edge_floor : float
        Fraction of the largest edge strength under which no fixed charge is placed; 0 places all of them and leaves it
        to the background to tell how weak an edge may be.
    regions : Regions, optional
        Regions of interest and barriers, in px of the scale. Outside the regions of interest there is no fixed charge,
        and what is the largest edge strength and what is background is told by the inside.

    Returns
    -------
    Level
        Fields of the scale.
    """
    grad = gradient(values, smoothing)
    strength = magnitude(grad)
    walls = NO_WALLS if regions is None else build_walls(regions, values.shape)
    inside = inside_frame(grad, smoothing, max_frame)
    if regions is not None and regions.interest:
        inside &= regions.pixels(values.shape)
    strongest = float(strength.max(where=inside, initial=0.0))
    least = edge_floor * strongest
    charged = np.where(inside & (strength >= least), strength, 0.0)
    lorentz = lorentz_force(electric_field(charged), grad, strength, strongest)
    if not inside.all():
        strength[scipy.ndimage.distance_transform_edt(~inside) > _MARGIN] = 0.0
    felt = np.concatenate([lorentz, grad, strength[None]])
    if strongest == 0.0:  # a coarse scale may have no pixel inside: nowhere is an edge to sit on
        floor = np.inf
    elif edge_floor > 0.0:
        floor = max(WEAKEST_EDGE * strongest, least)
    else:
        background = min(background_strength(strength[inside]), _MOST_BACKGROUND * strongest)
        floor = max(WEAKEST_EDGE * strongest, background)
    return Level(felt, values, strongest, least, floor, smoothing, walls)


def lorentz_force(field: Array, grad: Array, strength: Array, strongest: float) -> Array:
    r"""Normalised Lorentz force on the pixels.

    Away from edges it is the unit vector of the field (section 3.3). On an edge three things are done otherwise:

    - The field is divided by its largest size beside the edge and not by its own, so that the force falls linearly
      through zero where the field does. Unit vectors would round that place to the middle between two pixels.
    - The part along the edge is taken out. On the crest it is all that is left of the field, and scaled up it would
      drain particles from weak stretches towards strong ones and keep them circling; motion along an edge is the
      Coulomb force's.
    - Where the field leads off the crest, as it does all across a weak edge beside a strong one, the slope of the edge
      map takes its place, so that every edge holds what sits on it.

    Parameters
    ----------
    field : ndarray, shape (D, \*shape)
        Electric field.
    grad : ndarray, shape (D, \*shape)
        Image gradient.
    strength : ndarray, shape (\*shape)
        Its magnitude.
    strongest : float
        The largest edge strength that counts.

    Returns
    -------
    ndarray, shape (D, \*shape)
        The force, of at most unit size.
    """
    summit = scipy.ndimage.maximum_filter(strength, size=_SUMMIT_REACH, mode="nearest")
    near = np.clip((strength / np.maximum(summit, 1e-300) - _SLOPE) / (_RIDGE - _SLOPE), 0.0, 1.0)
    near[summit < WEAKEST_EDGE * strongest] = 0.0
    size = magnitude(field)
    beside = scipy.ndimage.maximum_filter(size, size=_FIELD_REACH, mode="nearest")
    force = field / np.maximum(np.maximum(size, near * beside), max(1e-12 * float(size.max()), 1e-300))
    normal = unit_vectors(grad)
    across = np.einsum("i...,i...->...", force, normal)
    # uphill on the edge's own flank, of unit size where that is steepest
    slope = np.einsum("i...,i...->...", gradient(strength, 0.0), normal)
    steepest = scipy.ndimage.maximum_filter(np.abs(slope), size=_SUMMIT_REACH, mode="nearest")
    uphill = slope / np.maximum(steepest, 1e-300)
    across = np.where(across * uphill < 0.0, uphill, across)
    return np.asarray((1.0 - near) * force + near * across * normal)


def unit_vectors(vectors: Array) -> Array:
    r"""Direction of a field: every vector scaled to length one, vanishing vectors left at zero.

    Parameters
    ----------
    vectors : ndarray, shape (D, \*shape)
        Field.

    Returns
    -------
    ndarray, shape (D, \*shape)
        Unit vectors.
    """
    length = magnitude(vectors)
    tiny = 1e-12 * float(length.max(initial=0.0))
    scale = np.where(length > tiny, 1.0 / np.maximum(length, max(tiny, 1e-300)), 0.0)
    return np.asarray(vectors * scale)
