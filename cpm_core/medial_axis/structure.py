"""What a skeleton is of: the edges that count, the polarity, and the widest part.

Where the outlines in an image are closed, regions are told apart by gray level, and any width counts. Elsewhere, as in
an angiogram, only strips of one polarity can be told from the background.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cpm_core.field.edge_map import background_strength
from cpm_core.field.scale_field import ScaleField
from cpm_core.medial_axis.boundary import Boundary, find_boundary
from cpm_core.medial_axis.foreground import within_objects
from cpm_core.medial_axis.medial_axis import Axis, medial_axis
from cpm_core.medial_axis.polarity import DARK, LIGHT, common_polarity, of_polarity, polarities
from cpm_core.medial_axis.pruning import prune
from cpm_core.medial_axis.strips import evidence, own_width, strips
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters

_MOSTLY_LOOSE = 0.5
"""Share of loose contours above which the outlines of an image do not count as closed."""

_WIDEST, _USUAL = 0.125, 0.5
"""Largest width considered for strips when none is given, as a fraction of the shorter side of the image, and what
fraction of it is usual."""

_WIDTH_PER_SIGMA, _FINEST = 15.0, 1.0
"""Width of strips per sigma of the smoothing that keeps their two edges apart, and least such sigma [px]."""

_FAINT, _LEAST = 0.5, 0.04
"""Floor for the edges of strips as a fraction of the background, and least background as one of the strongest edge."""


@dataclass(frozen=True, eq=False)
class Structure:
    """What a skeleton is of.

    Attributes
    ----------
    boundary : Boundary
        The edges that count.
    smoothing : float
        Sigma of their edge map [px].
    polarity : int
        `DARK` or `LIGHT`; 0 for both.
    width : float
        Largest width [px]; 0 for any.
    sure : float or None
        Least strength of the edges of strips [gray levels / px]; None where whole regions count.
    axis : Axis or None
        The medial axis of the parts of this polarity, once it has been found.
    """

    boundary: Boundary
    smoothing: float
    polarity: int
    width: float
    sure: float | None = None
    axis: Axis | None = None

    def pruned(self, axis: Axis, pruning: float, shape: tuple[int, ...]) -> Axis:
        """The part of an axis that remains after pruning in an image of this shape, no wider than allowed."""
        rest = prune(axis, pruning).within(np.full(2, -0.5), np.array(shape) - 0.5)
        if self.sure is not None:
            return strips(rest, self.boundary, self.width, self.sure)
        return rest.narrower(self.width) if self.width else rest


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
        if boundary.loose <= _MOSTLY_LOOSE:
            return Structure(boundary, usual.smoothing, polarity, 0.0)
        width = _WIDEST * min(usual.shape)
    finest = max(_FINEST, (1.0 if parameters.max_width else _USUAL) * width / _WIDTH_PER_SIGMA)
    if parameters.smoothing == "auto" and usual.smoothing > finest:
        usual = field_of(replace(parameters, smoothing=finest))
    faint, sure = _floors(usual, parameters)
    boundary = find_boundary(replace(usual, floor=faint), replace(parameters, sure_edge=0.0))
    return Structure(boundary, usual.smoothing, polarity, width, sure)


def with_axis(found: Structure, values: Array, parameters: Parameters) -> Structure:
    """The structure with its medial axis, its polarity and the width of its strips, in an image, shape (H, W)."""
    axis = medial_axis(found.boundary, values.shape)
    sign = polarities(axis, found.boundary)
    if found.sure is None:
        polarity = found.polarity
        objects = within_objects(axis, found.boundary, values, found.smoothing)
        if not polarity:
            polarity = common_polarity(axis, found.boundary, sign, objects, values.shape)
        chosen = of_polarity(axis, sign, polarity) if polarity else axis.chosen(objects)
        return replace(found, polarity=polarity, axis=chosen)
    options = [replace(found, polarity=p, axis=of_polarity(axis, sign, p)) for p in (DARK, LIGHT)]
    if found.polarity:
        options = [option for option in options if option.polarity == found.polarity]
    tried = [option.pruned(option.axis or axis, parameters.pruning, values.shape) for option in options]
    best = int(np.argmax([evidence(one, found.boundary) for one in tried]))
    width = parameters.max_width or own_width(tried[best], found.boundary) or found.width
    return replace(options[best], width=width)


def _floors(scale_field: ScaleField, parameters: Parameters) -> tuple[float, float]:
    """Least strength of the edges of strips, and of the sure ones among them [gray levels / px]."""
    strongest, strength = scale_field.strongest, scale_field.edge_map
    if parameters.edge_floor:
        return parameters.edge_floor * strongest, max(parameters.edge_floor, parameters.sure_edge) * strongest
    background = max(background_strength(strength[strength > 0.0]), _LEAST * strongest)
    return _FAINT * background, parameters.sure_edge * strongest or background
