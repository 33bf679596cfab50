"""Choice: the object that clicks mean, one click after the other, each time the best of all candidates.

The first click, or all of those that come at once, choose an object. A further click inside only adds to it, and one
outside only takes away: what was right stays. Of several new clicks the one that contradicts most comes first.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.objects.candidates.appearance import Appearance, log_ratio
from cpm_core.objects.candidates.features import OBJECT, change_features, object_features
from cpm_core.objects.candidates.grids import Box, Grid, grid_over, linked, union, without_holes
from cpm_core.objects.candidates.proposals import Kind, Proposal, Scene, proposals
from cpm_core.objects.candidates.ranking import CHANGES, FIRST, START, Ranking
from cpm_core.objects.clicks import Clicked

_MOST = 0.97
"""Share of the image above which a region is no object."""

_HOLES = 0.3, 30.0
"""Holes up to this share of what is added, and so many pixels more, are added as well."""

_FIRST = [OBJECT.index(name) for name in ("edge", "weak", "depth", "border", "step")]
_NOW = [OBJECT.index(name) for name in ("edge", "weak", "contrast", "texture", "border")]
_MORE = [OBJECT.index(name) for name in ("edge", "weak", "contrast", "border", "roundness", "depth")]
"""Features of an object that count for a first click; for a change; and those of which the difference counts then."""


_SEVERAL = 3
"""So many first places tell a size: that of the circle with their mean distance from their middle."""

_KINDS = Kind.CUT, Kind.DISK, Kind.MARGIN, Kind.LOCAL_CUT, Kind.LOCAL_LEVEL


class Candidate(NamedTuple):
    """A proposal with its features, shape (K,)."""

    proposal: Proposal
    features: Array


def candidates(scene: Scene) -> list[Candidate]:
    """All proposals that change something, with their features."""
    before = ratio = None
    if scene.chosen is not None:
        ratio = log_ratio(scene.look.resolutions[0].bin, scene.chosen)
        grid = grid_over(scene.box, scene.chosen.shape)
        before = object_features(scene.look, grid, grid.of(scene.chosen), scene.inside[0])
    found = []
    for proposal in proposals(scene):
        features = _first(scene, proposal) if before is None or ratio is None else _next(scene, proposal, before, ratio)
        if features is not None:
            found.append(Candidate(proposal, features))
    return found


def chosen(look: Appearance, clicks: Clicked, strong: float, before: Mask | None) -> Mask:
    """The object that clicks mean.

    Parameters
    ----------
    look : Appearance
        The image.
    clicks : Clicked
        The pixels that were clicked, at least one inside, and the faces that they have chosen.
    strong : float
        Edge strength that counts as strong.
    before : ndarray of bool, shape (H, W), or None
        The object that some of these clicks have chosen, if that is known.

    Returns
    -------
    ndarray of bool, shape (H, W)
        The object: it holds all pixels inside, and none outside.
    """
    mask, inside, outside = before, clicks.within, clicks.beyond
    if mask is None or not mask.any():
        mask = _best(Scene(look, clicks, strong, inside, outside, inside[0], True, None))
    every = np.concatenate([inside, outside])
    meant = np.arange(len(every)) < len(inside)
    while True:
        wrong = mask[every[:, 0], every[:, 1]] != meant
        if not wrong.any():
            return mask
        numbers = np.flatnonzero(wrong)
        worst = int(numbers[np.argmax(_depths(mask, every[numbers]))]) if len(numbers) > 1 else int(numbers[0])
        mask = _best(Scene(look, clicks, strong, inside, outside, every[worst], bool(meant[worst]), mask))


def _depths(mask: Mask, pixels: Index) -> Array:
    """Distance of pixels to the boundary of a mask, shape (N,)."""
    within, beyond = (scipy.ndimage.distance_transform_edt(part) for part in (mask, ~mask))
    return np.asarray((within + beyond)[pixels[:, 0], pixels[:, 1]])


def _best(scene: Scene) -> Mask:
    """The object after the last click, shape (H, W)."""
    found = candidates(scene)
    shape = scene.look.level.shape
    if not found:
        before = np.zeros(shape, np.bool_) if scene.chosen is None else scene.chosen
        return _tied(scene, before.copy())
    scores = _ranking(scene).scores(np.array([each.features for each in found]))
    return mask_of(scene, found[int(np.argmax(scores))].proposal)


def _ranking(scene: Scene) -> Ranking:
    if scene.chosen is not None:
        return CHANGES
    return START if len(scene.inside) >= _SEVERAL else FIRST


def mask_of(scene: Scene, proposal: Proposal) -> Mask:
    """The object that a proposal makes, shape (H, W)."""
    rows, cols = scene.look.level.shape
    top, bottom, left, right = _whole_box(scene, proposal)
    top, bottom, left, right = max(top - 1, 0), min(bottom + 1, rows), max(left - 1, 0), min(right + 1, cols)
    everything = Grid(0, top, left, np.arange(top, bottom), np.arange(left, right), (False,) * 4)
    mask = np.zeros((rows, cols), np.bool_)
    mask[top:bottom, left:right] = _object_on(scene, proposal, everything)
    return mask


def _first(scene: Scene, proposal: Proposal) -> Array | None:
    grid = grid_over(proposal.box, scene.look.level.shape)
    mask = _object_on(scene, proposal, grid)
    pixels = np.count_nonzero(mask) << (2 * grid.scale)
    size = scene.look.level.size
    if not 0 < pixels <= _MOST * size:
        return None
    middle = np.rint(scene.inside.mean(axis=0)).astype(np.int64)
    features = object_features(scene.look, grid, mask, middle)
    known = [float(proposal.kind == Kind.CUT)]
    if len(scene.inside) >= _SEVERAL:
        radius = float(np.linalg.norm(scene.inside - middle, axis=1).mean())
        known += [proposal.instability, np.log(pixels / max(np.pi * radius**2, 1.0))]
    return np.append(features[_FIRST], known)


def _next(scene: Scene, proposal: Proposal, before: Array, ratio: Array) -> Array | None:
    assert scene.chosen is not None
    shape = scene.look.level.shape
    grid = grid_over(_whole_box(scene, proposal), shape)
    mask, former = _object_on(scene, proposal, grid), grid.of(scene.chosen)
    changed_points = np.count_nonzero(mask ^ former)
    pixels = changed_points << (2 * grid.scale)
    if not changed_points or np.count_nonzero(mask) << (2 * grid.scale) > _MOST * scene.look.level.size:
        return None
    features = object_features(scene.look, grid, mask, scene.inside[0])
    near = grid_over(proposal.box, shape)
    was = near.of(scene.chosen)
    now = proposal.within(near.rows, near.cols)
    change = ((now != was) & (was != scene.adding)) if proposal.whole else now
    if not change.any():
        return None
    changed = change_features(scene.look, near, change, was, ratio, scene.pixel, scene.adding)
    area = max(scene.area, 1)
    sizes = [np.log(pixels / area), np.log(pixels), float(scene.adding), proposal.instability]
    kinds = [
        float(proposal.kind == kind) for kind in (Kind.CUT, Kind.DISK, Kind.MARGIN, Kind.LOCAL_CUT, Kind.LOCAL_LEVEL)
    ]
    differences = features[_MORE] - before[_MORE]
    return np.concatenate([features[_NOW], differences, changed, sizes, kinds])


def _whole_box(scene: Scene, proposal: Proposal) -> Box:
    """Box that holds the object before and after."""
    return proposal.box if scene.chosen is None else union(scene.box, proposal.box)


def _object_on(scene: Scene, proposal: Proposal, grid: Grid) -> Mask:
    """The object that a proposal makes, on a grid: linked with the clicks, without small holes."""
    inside, outside = _points(grid, scene.inside), _points(grid, scene.outside)
    region = proposal.within(grid.rows, grid.cols)
    if scene.chosen is None:
        region[outside[:, 0], outside[:, 1]] = False
        region = without_holes(np.ascontiguousarray(region), outside)
    else:
        region = _changed(scene, proposal, grid, region, outside)
    region[outside[:, 0], outside[:, 1]] = False
    region[inside[:, 0], inside[:, 1]] = True
    return linked(np.ascontiguousarray(region), inside)


def _changed(scene: Scene, proposal: Proposal, grid: Grid, region: Mask, outside: Index) -> Mask:
    """The object after a change; only what is linked with the click changes."""
    assert scene.chosen is not None
    before = grid.of(scene.chosen)
    change = (region != before) if proposal.whole else region
    change = linked(np.ascontiguousarray(change & (before != scene.adding)), _points(grid, scene.pixel[None]))
    if not scene.adding:
        return before & ~change
    after = before | change
    filled = without_holes(after, outside)
    limit = _HOLES[0] * np.count_nonzero(change) + _HOLES[1] / (1 << (2 * grid.scale))
    return filled if np.count_nonzero(filled ^ after) < limit else after


def _points(grid: Grid, pixels: Index) -> Index:
    """Points of the grid nearest to those pixels that lie on it."""
    places = (pixels >> grid.scale) - (grid.top, grid.left)
    there = ((places >= 0) & (places < (len(grid.rows), len(grid.cols)))).all(axis=1)
    return np.asarray(places[there])


def _tied(scene: Scene, mask: Mask) -> Mask:
    mask[scene.outside[:, 0], scene.outside[:, 1]] = False
    mask[scene.inside[:, 0], scene.inside[:, 1]] = True
    return linked(mask, scene.inside)
