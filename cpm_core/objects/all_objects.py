"""All objects of an image: of the regions that edges bound, and what the network makes of them, the likeliest.

What contours bound, and what the network takes a point for in the middle of each region between edges, are candidates
with a probability. The likeliest one is an object; then the likeliest of those that do not overlap with it, and so on,
unless several in it count more together. For what an unambiguous contour encloses without a neck the odds are the
geometric mean of those of a region and of an object that was selected. Then the probabilities are corrected by how much
each candidate resembles the others, and all is done once more.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
import scipy

from cpm_core.image.region import Region
from cpm_core.numerics.grids import bounding_window, enclose_windows, expand_window, find_largest_part, measure_depth
from cpm_core.numerics.parallel import map_in_parallel
from cpm_core.numerics.types import Array, Callback, Mask
from cpm_core.objects.candidate_regions import CandidateRegions, is_brighter_outside, is_known, is_part_of
from cpm_core.objects.confidence import (
    FAINT,
    ConfidenceFeatures,
    RegionFeatures,
    estimate_among_siblings,
    estimate_confidence,
    estimate_region_confidence,
)
from cpm_core.objects.image_parts import ImageParts
from cpm_core.objects.merged_basins import MIN_OBJECT_AREA
from cpm_core.objects.partition import Partition
from cpm_core.objects.region_evidence import RegionEvidence
from cpm_core.objects.selection import Candidate, Selection

_MIN_CONFIDENCE = 0.05
"""Least probability that an object is correct."""

_MIN_RELATIVE_CONFIDENCE = 0.12
"""Least such probability, as a fraction of the likeliest object's: beside a leaf, textures of the soil are none."""

_MIN_SIBLING_CONFIDENCE = 0.3
"""Least probability of an object beside which others are judged."""

_MIN_CERTAIN_CONFIDENCE = 0.3
"""Least probability with which a region may lie beside objects whose edges rise the other way."""

_NEXT_DISTANCE = 3
"""Distance up to which two regions lie next to each other [px]."""

_MIN_NESTED_CONFIDENCE = 0.5
"""Least such probability of an object in another one."""

_MAX_OVERLAP = 0.3
"""Share of the smaller one of two candidates above which they are not both objects, unless one is nested."""

_MIN_NESTED_SHARE = 0.95
"""Least share of the smaller object that lies in the larger one if it is nested."""

_MAX_NESTED_AREA = 0.6
"""Largest area of a nested object, as a fraction of the larger one's area."""

_SAME_ANSWER_IOU = 0.8
"""Overlap (intersection over union) from which two answers to points mean the same object."""

_PART_COST = 0.1
"""What an object costs, as a probability, where several take the place of one."""

_MAX_SHARED_RIM = 0.3
"""Largest share of the boundary of a nested object that runs along the boundary of the larger one."""


def find_objects_everywhere(partition: Partition, check: Callback = lambda: None) -> Iterator[Selection]:
    """Find all objects of an image, the likeliest first.

    `check` is called between the evaluations of regions, and may raise to end the search. Without the network, the
    objects are those that unambiguous contours enclose.
    """
    if not partition.uses_network:
        for mask in partition.find_unambiguous_objects():
            yield build_proposal(partition, mask, ConfidenceFeatures(point_count=0), unambiguous=True)
        return
    yield from find_objects_in_parts(ImageParts.from_partition(partition), check)


def find_objects_in_parts(parts: ImageParts, check: Callback = lambda: None) -> Iterator[Selection]:
    """Find all objects of an image that is divided into parts, by the network."""
    partition = parts.partition
    for found in find_image_objects(parts, check):
        mask = found.region.paste(partition.shape)
        one = build_proposal(partition, mask, found.features, unambiguous=found.unambiguous)
        yield replace(one, confidence=found.confidence)


def find_image_objects(parts: ImageParts, check: Callback = lambda: None) -> list[Candidate]:
    """Find the objects of `find_objects_everywhere`, without their outlines."""
    evidence = RegionEvidence(parts)
    rated = (rate_candidate(one, evidence.measure_candidate(one)) for one in predict_candidates(evidence, check))
    return choose_objects(rated, parts.partition.values)


def predict_candidates(evidence: RegionEvidence, check: Callback = lambda: None) -> list[Candidate]:
    """Predict the candidates for the objects of an image."""
    found = CandidateRegions.from_parts(evidence.parts)

    def predict(region: Candidate) -> list[Candidate]:
        check()
        return list(evidence.predict_candidates(region))

    bounded: list[Candidate] = []
    selected: list[Candidate] = []
    for one in itertools.chain.from_iterable(map_in_parallel(predict, found.regions)):
        if one.bounded:
            bounded.append(one)
        elif one.region.size >= MIN_OBJECT_AREA and found.may_be_object(one.region):
            selected.append(one)
    return bounded + _choose_distinct(selected)


def _choose_distinct(candidates: Iterable[Candidate]) -> list[Candidate]:
    """Choose the likeliest of candidates that are nearly the same."""
    chosen: list[Candidate] = []
    for one in sorted(candidates, key=lambda one: -one.likelihood):
        if not is_known(one.region, (other.region for other in chosen), _SAME_ANSWER_IOU):
            chosen.append(one)
    return chosen


def rate_candidate(candidate: Candidate, features: RegionFeatures) -> Candidate:
    """Rate a candidate by what was measured of it.

    Whether a contour is unambiguous says little of the regions from which the rule for these was learned, and much of
    the objects from which the other one was, so that both count there (a logarithmic opinion pool).
    """
    found = estimate_region_confidence(features)
    if candidate.features is not None and features.unambiguous and not features.has_neck:
        selected = estimate_confidence(candidate.features._replace(unambiguous=True))
        found = float(scipy.special.expit(scipy.special.logit([found, selected]).mean()))
    return candidate._replace(strength=features.strength, confidence=found)


def choose_objects(rated: Iterable[Candidate], values: Array) -> list[Candidate]:
    """Choose objects among the candidates of an image, shape (H, W); the likeliest come first.

    Objects of an image resemble each other: where several are likely, these tell how likely each candidate is beside
    them, and all are chosen once more. One that is likely alone stays as likely as it is.
    """
    rated = list(rated)
    likely = find_likely_objects(rated, values)
    if len(likely) > 1:
        rated = [
            one._replace(confidence=estimate_among_siblings(one.confidence, *weights))
            for one, weights in zip(rated, weigh_siblings(rated, likely, values), strict=True)
        ]
    return _choose_likeliest(rated, values)


def find_likely_objects(rated: Iterable[Candidate], values: Array) -> list[Candidate]:
    """Find the candidates of an image, shape (H, W), that are likely before the others are looked at."""
    return [found for found in _choose_likeliest(rated, values) if found.confidence >= _MIN_SIBLING_CONFIDENCE]


def weigh_siblings(
    rated: list[Candidate], likely: list[Candidate], values: Array
) -> Iterator[tuple[float, float, float]]:
    """Weigh the likely objects beside each candidate: yield what `estimate_among_siblings` takes after confidence."""
    rises = [is_brighter_outside(found.region, values) for found in likely]
    strengths = [float(np.log(found.strength + FAINT)) for found in likely]
    for one in rated:
        region = one.region
        apart = [
            (found.confidence**2, rise, strength)
            for found, rise, strength in zip(likely, rises, strengths, strict=True)
            if region.count_shared(found.region) <= _MAX_OVERLAP * min(region.size, found.region.size)
        ]
        own = bool(apart) and is_brighter_outside(region, values)
        amount = sum(weight for weight, _, _ in apart)
        usual = sum(weight * strength for weight, _, strength in apart)
        weakness = max(usual - amount * float(np.log(one.strength + FAINT)), 0.0)
        yield sum(weight if rise == own else -weight for weight, rise, _ in apart), amount, weakness


def _choose_likeliest(rated: Iterable[Candidate], values: Array) -> list[Candidate]:
    """Choose the likeliest candidate, the likeliest of those that do not overlap with it, and so on.

    Then an object gives way to several that lie in it, if these count more together.
    """
    ordered = _order_likely(rated)
    chosen = _choose_beside([], ordered, values)
    wholes = sorted(chosen, key=lambda one: -one.region.size)
    while wholes:
        whole = wholes.pop(0)
        others = [one for one in chosen if one is not whole]
        parts = _choose_beside(others, [one for one in ordered if is_part_of(one.region, whole.region)], values)
        if len(parts) > 1 and sum(one.confidence - _PART_COST for one in parts) > whole.confidence - _PART_COST:
            chosen = others + parts
            wholes += parts
    return sorted(chosen, key=lambda one: -one.confidence)


def _order_likely(rated: Iterable[Candidate]) -> list[Candidate]:
    """Order the candidates that are likely enough to be objects, the likeliest first."""
    ordered = sorted(rated, key=lambda one: -one.confidence)
    least = max(_MIN_CONFIDENCE, _MIN_RELATIVE_CONFIDENCE * ordered[0].confidence) if ordered else 0.0
    return [one for one in ordered if one.confidence >= least]


def _choose_beside(chosen: list[Candidate], ordered: list[Candidate], values: Array) -> list[Candidate]:
    """Choose among candidates, the likeliest first, those that may be objects beside others chosen before."""
    found: list[Candidate] = []
    for one in ordered:
        region = _fit_between(one, [other.region for other in itertools.chain(chosen, found)], values)
        if region is not None:
            found.append(one._replace(region=region))
    return found


def _fit_between(candidate: Candidate, chosen: list[Region], values: Array) -> Region | None:
    """Fit a candidate between the objects chosen before, without the pixels of others; None where it is no object."""
    region, confidence = candidate.region, candidate.confidence
    if confidence < _MIN_CERTAIN_CONFIDENCE and _is_background(region, chosen, values):
        return None
    rest = region
    for other in chosen:
        both = region.count_shared(other)
        if both > _MAX_OVERLAP * min(region.size, other.size):
            nested = confidence >= _MIN_NESTED_CONFIDENCE and _is_nested(region, other)
            if not nested or is_brighter_outside(region, values) != is_brighter_outside(other, values):
                return None
        elif both:
            rest = rest.without(other)
    if rest.size < MIN_OBJECT_AREA:
        return None
    rest = rest if rest is region else Region.from_mask(find_largest_part(rest.mask), rest.origin)
    return rest if rest.size >= MIN_OBJECT_AREA else None


def _is_background(region: Region, chosen: list[Region], values: Array) -> bool:
    """Return whether a region lies beside objects whose edges all rise the other way, in an image of shape (H, W)."""
    window = expand_window(region.window, _NEXT_DISTANCE, values.shape)
    around = scipy.ndimage.binary_dilation(region.cut_out(window), iterations=_NEXT_DISTANCE)
    touched = [other for other in chosen if (other.cut_out(window) & around).any()]
    rises = {is_brighter_outside(other, values) for other in touched}
    return len(rises) == 1 and is_brighter_outside(region, values) not in rises


def _is_nested(one: Region, two: Region) -> bool:
    """Return whether one of two regions that overlap lies deep in the other."""
    both = one.count_shared(two)
    small, large = (one, two) if one.size < two.size else (two, one)
    if both < _MIN_NESTED_SHARE * small.size or both > _MAX_NESTED_AREA * large.size:
        return False
    window = enclose_windows(one.window, two.window)
    inner, outer = small.cut_out(window), large.cut_out(window)
    rim = inner & ~scipy.ndimage.binary_erosion(inner)
    return bool((~scipy.ndimage.binary_erosion(outer, iterations=3))[rim].mean() <= _MAX_SHARED_RIM)


def build_proposal(
    partition: Partition, mask: Mask, features: ConfidenceFeatures | None = None, *, unambiguous: bool = False
) -> Selection:
    """Build the selection of some pixels, shape (H, W), with the deepest of them as its positive point."""
    box = bounding_window(mask)
    depth = measure_depth(mask[box])
    place = np.argwhere(depth == depth.max())[:1] + [float(side.start) for side in box]
    if features is None and not partition.uses_network:
        features = ConfidenceFeatures(point_count=0)
    elif features is None:
        features = ConfidenceFeatures(*partition.evaluate_mask(mask, place)[2:], point_count=0)
    return partition.build_selection(mask, place, features=features, unambiguous=unambiguous)
