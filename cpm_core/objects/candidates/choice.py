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
from cpm_core.objects.candidates.clicks import Clicked
from cpm_core.objects.candidates.description import DESCRIPTION, description
from cpm_core.objects.candidates.features import OBJECT, change_features, object_features
from cpm_core.objects.candidates.grids import Box, Grid, grid_over, linked, union, without_holes
from cpm_core.objects.candidates.kinds import SEVERAL, Candidate, Kind, candidates
from cpm_core.objects.candidates.ranking import CHANGES, FIRST
from cpm_core.objects.candidates.situation import Situation
from cpm_core.objects.candidates.trees import trees
from cpm_core.objects.faces.closed_regions import ClosedRegions

_MOST = 0.97
"""Share of the image above which a region is no object."""

_HOLES = 0.3, 30.0
"""Holes up to this share of what is added, and so many pixels more, are added as well."""

_FIRST = [OBJECT.index(name) for name in ("edge", "weak", "depth", "border", "step")]
_NOW = [OBJECT.index(name) for name in ("edge", "weak", "contrast", "texture", "border")]
_MORE = [OBJECT.index(name) for name in ("edge", "weak", "contrast", "border", "roundness", "depth")]
"""Features of an object that count for a first click; for a change; and those of which the difference counts."""

START = (
    *OBJECT, *DESCRIPTION, "by cut", "by dark", "by bright", "by star", "instability", "support", "share", "size",
    "fullness",
)  # fmt: skip
"""Features of an object after a drawn start; `fullness` is the logarithm of its size over that of the
drawn circle."""

_FULL, _BEYOND = 4.0, 3.0
"""Fullness above which an object is far larger than what was drawn, and what each unit beyond costs."""
_START_KINDS = Kind.CUT, Kind.DARK, Kind.BRIGHT, Kind.STAR

_KINDS = Kind.CUT, Kind.DISK, Kind.MARGIN, Kind.LOCAL_CUT, Kind.LOCAL_LEVEL


class Described(NamedTuple):
    """A candidate with its features, shape (K,)."""

    candidate: Candidate
    features: Array


def described(situation: Situation) -> list[Described]:
    """All candidates that change something, with their features."""
    before = ratio = None
    if situation.chosen is not None:
        ratio = log_ratio(situation.look.resolutions[0].bin, situation.chosen)
        grid = grid_over(situation.box, situation.chosen.shape)
        before = object_features(situation.look, grid, grid.of(situation.chosen), situation.inside[0])
    found = []
    for candidate in candidates(situation):
        features = (
            _first(situation, candidate)
            if before is None or ratio is None
            else _next(situation, candidate, before, ratio)
        )
        if features is not None:
            found.append(Described(candidate, features))
    return found


def chosen(look: Appearance, clicks: Clicked, strong: float, before: Mask | None, closed: ClosedRegions) -> Mask:
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
    closed : ClosedRegions
        Regions that are certain: where they say what a click means, no candidate does.

    Returns
    -------
    ndarray of bool, shape (H, W)
        The object: it holds all pixels inside, and none outside.
    """
    mask, inside, outside = before, clicks.within, clicks.beyond
    if mask is None or not mask.any():
        mask = _best(Situation(look, clicks, strong, inside[0], True, None))
    every = np.concatenate([inside, outside])
    meant = np.arange(len(every)) < len(inside)
    while True:
        wrong = mask[every[:, 0], every[:, 1]] != meant
        if not wrong.any():
            return mask
        numbers = np.flatnonzero(wrong)
        worst = int(numbers[np.argmax(_depths(mask, every[numbers]))]) if len(numbers) > 1 else int(numbers[0])
        adds = bool(meant[worst])
        certain = closed.changed(mask, every[worst], adds, outside if adds else inside)
        mask = certain if certain is not None else _best(Situation(look, clicks, strong, every[worst], adds, mask))


def _depths(mask: Mask, pixels: Index) -> Array:
    """Distance of pixels to the boundary of a mask, shape (N,)."""
    within, beyond = (scipy.ndimage.distance_transform_edt(part) for part in (mask, ~mask))
    return np.asarray((within + beyond)[pixels[:, 0], pixels[:, 1]])


def _best(situation: Situation) -> Mask:
    """The object after the last click, shape (H, W)."""
    found = described(situation)
    shape = situation.look.level.shape
    if not found:
        before = np.zeros(shape, np.bool_) if situation.chosen is None else situation.chosen
        return _tied(situation, before.copy())
    scores = scored(situation, np.array([each.features for each in found]))
    return mask_of(situation, found[int(np.argmax(scores))].candidate)


def scored(situation: Situation, features: Array) -> Array:
    """Scores of candidates by their features, shape (N, K).

    Of objects that are far larger than what was drawn the trees have seen few: there the smaller one is meant.
    """
    if situation.chosen is not None:
        return CHANGES.scores(features)
    if len(situation.inside) >= SEVERAL:
        beyond = np.maximum(features[:, START.index("fullness")] - _FULL, 0.0)
        return trees("start").scores(features) - _BEYOND * beyond
    return FIRST.scores(features)


def mask_of(situation: Situation, candidate: Candidate) -> Mask:
    """The object that a candidate makes, shape (H, W)."""
    rows, cols = situation.look.level.shape
    top, bottom, left, right = _whole_box(situation, candidate)
    top, bottom, left, right = max(top - 1, 0), min(bottom + 1, rows), max(left - 1, 0), min(right + 1, cols)
    everything = Grid(0, top, left, np.arange(top, bottom), np.arange(left, right), (False,) * 4)
    mask = np.zeros((rows, cols), np.bool_)
    mask[top:bottom, left:right] = _object_on(situation, candidate, everything)
    return mask


def _first(situation: Situation, candidate: Candidate) -> Array | None:
    grid = grid_over(candidate.box, situation.look.level.shape)
    mask = _object_on(situation, candidate, grid)
    pixels = np.count_nonzero(mask) << (2 * grid.scale)
    size = situation.look.level.size
    if not 0 < pixels <= _MOST * size:
        return None
    middle = np.rint(situation.inside.mean(axis=0)).astype(np.int64)
    features = object_features(situation.look, grid, mask, middle)
    if len(situation.inside) < SEVERAL:
        return np.append(features[_FIRST], float(candidate.kind == Kind.CUT))
    radius = float(np.linalg.norm(situation.inside - middle, axis=1).mean())
    star = candidate.kind == Kind.STAR
    return np.concatenate(
        [
            features,
            description(situation.look, grid, mask, middle, situation.strong, radius),
            [float(candidate.kind == kind) for kind in _START_KINDS],
            [0.0 if star else candidate.instability, candidate.instability if star else 0.0],
            np.log([pixels / size, pixels, pixels / max(np.pi * radius**2, 1.0)]),
        ]
    )


def _next(situation: Situation, candidate: Candidate, before: Array, ratio: Array) -> Array | None:
    assert situation.chosen is not None
    shape = situation.look.level.shape
    grid = grid_over(_whole_box(situation, candidate), shape)
    mask, former = _object_on(situation, candidate, grid), grid.of(situation.chosen)
    changed_points = np.count_nonzero(mask ^ former)
    pixels = changed_points << (2 * grid.scale)
    if not changed_points or np.count_nonzero(mask) << (2 * grid.scale) > _MOST * situation.look.level.size:
        return None
    features = object_features(situation.look, grid, mask, situation.inside[0])
    near = grid_over(candidate.box, shape)
    was = near.of(situation.chosen)
    now = candidate.within(near.rows, near.cols)
    change = ((now != was) & (was != situation.adding)) if candidate.whole else now
    if not change.any():
        return None
    changed = change_features(situation.look, near, change, was, ratio, situation.pixel, situation.adding)
    area = max(situation.area, 1)
    sizes = [np.log(pixels / area), np.log(pixels), float(situation.adding), candidate.instability]
    kinds = [float(candidate.kind == kind) for kind in _KINDS]
    differences = features[_MORE] - before[_MORE]
    return np.concatenate([features[_NOW], differences, changed, sizes, kinds])


def _whole_box(situation: Situation, candidate: Candidate) -> Box:
    """Box that holds the object before and after."""
    return candidate.box if situation.chosen is None else union(situation.box, candidate.box)


def _object_on(situation: Situation, candidate: Candidate, grid: Grid) -> Mask:
    """The object that a candidate makes, on a grid: linked with the clicks, without small holes."""
    inside, outside = _points(grid, situation.inside), _points(grid, situation.outside)
    region = candidate.within(grid.rows, grid.cols)
    if situation.chosen is None:
        region[outside[:, 0], outside[:, 1]] = False
        region = without_holes(np.ascontiguousarray(region), outside)
    else:
        region = _changed(situation, candidate, grid, region, outside)
    region[outside[:, 0], outside[:, 1]] = False
    region[inside[:, 0], inside[:, 1]] = True
    return linked(np.ascontiguousarray(region), inside)


def _changed(situation: Situation, candidate: Candidate, grid: Grid, region: Mask, outside: Index) -> Mask:
    """The object after a change; only what is linked with the click changes."""
    assert situation.chosen is not None
    before = grid.of(situation.chosen)
    change = (region != before) if candidate.whole else region
    change = linked(np.ascontiguousarray(change & (before != situation.adding)), _points(grid, situation.pixel[None]))
    if not situation.adding:
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


def _tied(situation: Situation, mask: Mask) -> Mask:
    mask[situation.outside[:, 0], situation.outside[:, 1]] = False
    mask[situation.inside[:, 0], situation.inside[:, 1]] = True
    return linked(mask, situation.inside)
