"""The objects that a run proposes, by what it knows itself: the seeds it began with, and what it found."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Protocol

import numpy as np
import scipy

from cpm_core.field.edge_map import automatic_smoothing, edge_map
from cpm_core.field.start_area.drawn_area import is_everywhere
from cpm_core.field.volume_field import pitch_of
from cpm_core.image.gray_levels import limit_specks
from cpm_core.image.image import Image
from cpm_core.image.region import Region
from cpm_core.model.starts import STRONG_EDGE_FRACTION, divergence_centers, is_allowed
from cpm_core.model.volume.starts import seeds_at_centers, volume_edge_strength
from cpm_core.numerics.grids import label_joined_pairs, running_maximum
from cpm_core.numerics.types import Array, Arrays, Callback, Sides
from cpm_core.objects.all_bodies import find_bodies_everywhere
from cpm_core.objects.all_objects import build_proposal, find_objects_everywhere
from cpm_core.objects.body_evidence import rate_body
from cpm_core.objects.partition import Partition
from cpm_core.objects.selection import Selection, remark_on_doubt
from cpm_core.objects.volume_partition import FoundInImage, VolumePartition, require_image
from cpm_core.parameters.provenance import Provenance

FoundObjects = tuple[Selection, ...]
"""The objects that a run proposes, the best first."""

MIN_LIKELY_CONFIDENCE = 0.7
"""Confidence from which an object is likely."""

_MIN_RULE_SHARE = 0.95
"""Least share of the places of a rule, such as the strong edges, at which a run began that began by this rule."""

_SEEDING_TOLERANCE = 2
"""Distance from a place of a rule at which a seed is there [px]."""

_EXACT_TOLERANCE = 1e-3
"""Distance at which a seed is exactly at a place, in single precision [px]."""

_MAX_ROW_SPACING = 6.0
"""Largest distance of neighbors in a drawn row of seeds; seeds farther apart are clicks [px]."""

_ROW_SLACK = 1.5
"""Multiple of the distance of a seed from its nearest neighbor up to which others belong to the same piece."""

_LATTICE_SLACK = 1.01
"""Multiple of that distance up to which a third neighbor makes a seed one of an even grid, however wide."""

_NEAREST_SEEDS = 8
"""Number of neighbors of a seed that are looked at."""

_SAME_OBJECT_OVERLAP = 0.5
"""Overlap (intersection over union) from which the objects of two pieces of a start are the same."""

_MAX_TAKEN_SEEDS = 0.2
"""Largest share of the seeds of a piece in objects that contours enclose, if its own object is sought elsewhere."""

_MAX_BODY_POINTS = 20
"""Largest number of seeds in a body that are its positive points."""


class RunOutcome(FoundInImage, Protocol):
    """What a run found, and how it began."""

    @property
    def seeds(self) -> Array:
        """Seeds, shape (M, D) [px]."""

    @property
    def provenance(self) -> Provenance:
        """Origin of what was found."""


def find_objects(result: RunOutcome, check: Callback = lambda: None, *, continues: bool = False) -> FoundObjects:
    """Find the objects that a run proposes, the best first.

    A run from everywhere proposes all objects of the image, or all bodies inside the surface, split at necks. One from
    drawn starts proposes the object of each connected piece of them.

    Parameters
    ----------
    result : Result
        Outcome of the run; without seeds, of one from everywhere.
    check : callable
        Called from time to time; it may raise to end the search.
    continues : bool
        Whether the run in an image began along the contours of another one, whose objects may have divided or united:
        then what its contours enclose is proposed first.

    Returns
    -------
    tuple of Selection
        Ranked by confidence.

    Raises
    ------
    ValueError
        When the result does not know its image.
    """
    image = require_image(result)
    pieces = () if is_run_everywhere(result) else split_seeds(result.seeds, _relative_sides(image))
    if image.ndim == 3:
        bodies = _find_bodies(VolumePartition.from_result(result), pieces, check)
        return tuple(sorted(bodies, key=lambda one: (-one.confidence, -one.size)))
    partition = Partition.from_result(result)
    if not pieces:
        return tuple(find_objects_everywhere(partition, check))
    find = _find_continued_objects if continues else _find_started_objects
    return tuple(sorted(find(partition, pieces, check), key=lambda one: -one.confidence))


def is_likely(found: Selection) -> bool:
    """Return whether an object is likely, to be accepted together with others; one of unknown confidence is."""
    return not found.confidence < MIN_LIKELY_CONFIDENCE


def is_run_everywhere(result: RunOutcome) -> bool:
    """Return whether a run began everywhere: evenly, on strong edges, or at all centers; also without seeds."""
    image, seeds, regions = require_image(result), result.seeds, result.regions
    even = (_relative_sides(image), (1.0,) * image.ndim)  # grids are even in space, those of `uniform_grid` in voxels
    if not len(seeds) or any(is_everywhere(seeds, image.shape, regions, sides) for sides in even):
        return True
    on_pixels = (seeds == np.rint(seeds)).all(axis=1)  # those of rules are, but for some at the border
    return (bool(on_pixels.all()) and _begins_on_edges(result, image)) or (
        bool(image.ndim == 3 or on_pixels.mean() > 0.5) and _covers_centers(result, image)
    )


def _relative_sides(image: Image) -> Sides:
    """Return the sides of a pixel that distances of seeds are measured by: in a volume as particles feel them."""
    return pitch_of(image.spacing) if image.ndim == 3 else (1.0, 1.0)


def _begins_on_edges(result: RunOutcome, image: Image) -> bool:
    """Return whether nearly all seeds, on whole pixels, are on strong edges, or nearly all strong edges have seeds."""
    smoothing = result.provenance.parameters.get("smoothing", 1.0)
    if image.ndim == 3:
        strength = volume_edge_strength(image, 1.0 if isinstance(smoothing, str) else smoothing)
    else:
        gray = image.gray_levels(result.channel)
        sigma = automatic_smoothing(gray) if isinstance(smoothing, str) else smoothing
        strength = edge_map(limit_specks(gray), sigma)
    strong = strength > STRONG_EDGE_FRACTION * strength.max()
    strong[strong] = is_allowed(np.argwhere(strong).astype(float), result.regions)
    seeded, at = np.zeros(image.shape, bool), tuple(result.seeds.astype(np.int64).T)
    seeded[at] = True
    covered = running_maximum(seeded, _SEEDING_TOLERANCE)[strong]
    return bool(max(strong[at].mean(), covered.mean() if covered.size else 0.0) >= _MIN_RULE_SHARE)


def _covers_centers(result: RunOutcome, image: Image) -> bool:
    """Return whether seeds are at nearly all centers of divergence of an image, where they may be."""
    centers = seeds_at_centers(image) if image.ndim == 3 else divergence_centers(image.gray_levels(result.channel))
    centers = centers[is_allowed(centers, result.regions)]
    away = np.asarray(scipy.spatial.cKDTree(result.seeds).query(centers)[0])
    tolerance = _SEEDING_TOLERANCE if image.ndim == 2 else _EXACT_TOLERANCE  # in volumes they are on no whole voxels
    return bool(len(centers) and (away <= tolerance).mean() >= _MIN_RULE_SHARE)


def split_seeds(seeds: Array, sides: Sides) -> Arrays:
    """Split drawn seeds, shape (M, D) [px], into connected pieces: rows, grids and single clicks, each (N, D).

    `sides` are those of a pixel, the least of which is 1.
    """
    places = seeds * sides
    count = min(_NEAREST_SEEDS, len(seeds) - 1)
    if not count:
        return (seeds,)
    away, near = map(np.asarray, scipy.spatial.cKDTree(places).query(places, k=np.arange(2, count + 2)))
    nearest = np.maximum(away[:, 0], 1.0)  # seeds may coincide
    in_lattice = away[:, min(2, count - 1)] <= _LATTICE_SLACK * nearest if count > 2 else np.zeros(len(seeds), bool)
    joined = away <= _ROW_SLACK * np.minimum(nearest[:, None], nearest[near])
    joined &= (away <= _MAX_ROW_SPACING) | in_lattice[:, None] | in_lattice[near]
    rows, columns = np.nonzero(joined)
    piece = label_joined_pairs((rows, near[rows, columns]), len(seeds))
    _, first = np.unique(piece, return_index=True)
    return tuple(seeds[piece == piece[at]] for at in np.sort(first))


def _find_started_objects(partition: Partition, pieces: Iterable[Array], check: Callback) -> Iterator[Selection]:
    """Find the object of each piece of a start, shape (N, 2) [px]; nothing where there is none, or no other one."""
    found: list[Selection] = []
    for piece in pieces:
        check()
        one = partition.select(piece)
        if not one.has_boundary or one.has_only_points:
            continue  # as from a start across an edge
        if all(one.region.compute_iou(other.region) <= _SAME_OBJECT_OVERLAP for other in found):
            found.append(one)
            yield one


def _find_continued_objects(partition: Partition, pieces: Arrays, check: Callback) -> Iterator[Selection]:
    """Find what contours enclose unambiguously, and elsewhere the object of each piece of a start, (N, 2) [px]."""
    taken = np.zeros(partition.shape, bool)
    for mask in partition.find_unambiguous_objects():
        check()
        taken |= mask
        yield remark_on_doubt(build_proposal(partition, mask, unambiguous=True))
    left = [each for each in pieces if taken[tuple(np.rint(each).astype(int).T)].mean() <= _MAX_TAKEN_SEEDS]
    for one in _find_started_objects(partition, left, check):
        if taken[one.region.window][one.region.mask].mean() <= _SAME_OBJECT_OVERLAP:
            yield one


def _find_bodies(partition: VolumePartition, pieces: Arrays, check: Callback) -> Iterator[Selection]:
    """Find the body with most seeds of each piece of a start, shape (N, 3) [voxels]; without pieces, all of them."""
    if not len(partition.surface.faces):
        return
    if not pieces:
        yield from find_bodies_everywhere(partition, check)
    chosen: dict[int, Array] = {}
    for piece in pieces:
        number = partition.find_body_numbers(piece)
        body = int(np.bincount(number[number > 0], minlength=1).argmax())
        if body:
            chosen.setdefault(body, piece[number == body][:_MAX_BODY_POINTS])
    for body, points in chosen.items():
        check()
        boundary = partition.extract_boundary(np.array([body]))
        if len(boundary.faces):
            yield rate_body(partition.build_selection(Region(surface=boundary), points))
