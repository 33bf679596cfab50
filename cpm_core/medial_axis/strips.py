"""Strips: parts of a medial axis between two opposite edges that are not farther apart than a width.

Thin structures in an uneven image, such as arteries, have broken outlines, and their edges are fainter than others that
delimit nothing thin. So faint edges count as well, and what tells a strip from chance is that it runs between two edges
of the same polarity over a length of several widths.
"""

from __future__ import annotations

import numpy as np

from cpm_core.medial_axis.boundary import Boundary
from cpm_core.medial_axis.medial_axis import Axis
from cpm_core.medial_axis.polarity import lengths
from cpm_core.medial_axis.pruning import parts
from cpm_core.numerics.types import Array

_OPPOSITE = 0.5
"""Greatest change of the radius along the axis, per length, between edges that count as opposite: the cosine of the
angle between the axis and the directions to the two sides."""

_LONG, _MOSTLY = 3.0, 0.3
"""Least length between opposite sure edges, in mean widths of a part of the axis, and its least share of the part."""

_WIDEST, _ROOM = 0.95, 1.5
"""Fraction of the strips, by length and strength, that the image's own width exceeds, and by what factor: forks are
wider than their arms."""


def strips(axis: Axis, boundary: Boundary, width: float, sure: float) -> Axis:
    """The parts of a pruned axis that lie in strips.

    Parameters
    ----------
    axis : Axis
        Medial axis of regions of one polarity.
    boundary : Boundary
        Edges, faint ones included.
    width : float
        Largest width of a strip [px].
    sure : float
        Least strength of edges that make a strip certain [gray levels / px].
    """
    cut = _without_mouths(axis.narrower(width))
    if not len(cut.edges):
        return cut
    count, part = parts(cut)
    of_part, length = part[cut.edges[:, 0]], lengths(cut)
    opposite = _slope(cut) <= _OPPOSITE
    strong = boundary.strength[cut.nearest[cut.edges]].mean(axis=1) >= sure
    total, between, certain, area = (
        np.bincount(of_part, weights, count)
        for weights in (
            length,
            length * opposite,
            length * (opposite & strong),
            length * 2.0 * cut.radius[cut.edges].mean(axis=1),
        )
    )
    kept = (certain * total >= _LONG * area) & (between >= _MOSTLY * total)
    return cut.only(cut.edges[kept[of_part]])


def evidence(found: Axis, boundary: Boundary) -> float:
    """How much speaks for strips: their length, in widths, times the strength of their edges [gray levels / px]."""
    across = 2.0 * found.radius[found.edges].mean(axis=1)
    return float((_weights(found, boundary) / np.maximum(across, 1e-300)).sum())


def own_width(found: Axis, boundary: Boundary) -> float:
    """Width that nearly all of some strips stay well below [px]; 0 without any."""
    if not len(found.edges):
        return 0.0
    across, weights = 2.0 * found.radius[found.edges].mean(axis=1), _weights(found, boundary)
    order = np.argsort(across)
    reached = np.cumsum(weights[order])
    return _ROOM * float(across[order][np.searchsorted(reached, _WIDEST * reached[-1])])


def _weights(found: Axis, boundary: Boundary) -> Array:
    """Length of each edge of an axis times the strength of the boundary beside it, shape (M,)."""
    return np.asarray(lengths(found) * boundary.strength[found.nearest[found.edges]].mean(axis=1))


def _slope(axis: Axis) -> Array:
    """Change of the radius along each edge, per length, shape (M,)."""
    change = np.abs(np.diff(axis.radius[axis.edges], axis=1)[:, 0])
    return np.asarray(change / np.maximum(lengths(axis), 1e-300))


def _without_mouths(axis: Axis) -> Axis:
    """Axis without its ends that widen into an open region."""
    links: list[set[int]] = [set() for _ in axis.points]
    for a, b in axis.edges.tolist():
        links[a].add(b)
        links[b].add(a)
    tips = [v for v, near in enumerate(links) if len(near) == 1]
    while tips:
        tip = tips.pop()
        if not links[tip]:
            continue
        (following,) = links[tip]
        away = float(np.linalg.norm(axis.points[tip] - axis.points[following]))
        if axis.radius[tip] - axis.radius[following] <= _OPPOSITE * away:
            continue
        links[tip].clear()
        links[following].discard(tip)
        if len(links[following]) == 1:
            tips.append(following)
    rest = [(v, w) for v, near in enumerate(links) for w in near if v < w]
    return axis.only(np.array(rest, np.int64).reshape(-1, 2))
